"""Explains the error in a document: the slow, exact check of plain data.

The fast readers only detect that there is an error. This check compares the plain data (parsed JSON) with the shape of
the class. Its error gives the first wrong place, what was expected there and what was received.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from typing import Any, Final

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Record
from intellwheels_schemas.shapes import Form, Member, Scalar, Shape, shape_of

_NOUNS: Final = {
    "deg": "degrees",
    "rad": "radians",
    "m": "metres",
    "s": "seconds",
    "m/s": "metres a second",
    "m/s2": "metres a second squared",
    "rad/s": "radians a second",
}

# The text for Height, which could be understood as z.
_HEIGHT_HINTS: Final = {
    "Robot": "in the paper Height is a size on the plan: write Length and Width, and Top for the upper face",
    "Part": "write Bottom and Top",
}


# Why a value is refused that a reader of the paper may expect to pass, by the end of its place.
_VALUE_HINTS: Final = {
    (".AccelerationCurve", 1.0): "with 1 the motors would keep their last power for ever and never move: write 0.999",
}


class Repeated(dict[str, Any]):
    """An object in which a name occurs twice; `name` is the first such name."""

    name: str = ""


def object_of_pairs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return the object with these pairs, or a `Repeated` if a name occurs twice. For `json.loads`."""
    found = dict(pairs)
    if len(found) == len(pairs):
        return found
    marked = Repeated(found)
    seen: set[str] = set()
    for name, _ in pairs:
        if name in seen:
            marked.name = name
            break
        seen.add(name)
    return marked


def shown(value: object) -> str:
    """Return a short, printable text for a value that came from outside."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value) if abs(value) < 10**20 else "a very large number"
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    if isinstance(value, str):
        return repr(value) if len(value) <= 40 else f"{value[:37]!r} and {len(value) - 37} characters more"
    return "a list" if isinstance(value, list) else "an object"


def did_you_mean(got: str, known: Iterable[str]) -> str:
    """Return `; did you mean 'ward'?` if a known word is similar to what came, else nothing."""
    near = difflib.get_close_matches(got, list(known), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""


def _bound(value: float | None, none: str) -> str:
    return none if value is None else shown(value)


def expected(scalar: Scalar) -> str:
    """Return the valid values of a scalar in words, such as `degrees in (0, 360]`."""
    if scalar.kind == "truth":
        return "true or false"
    if scalar.kind == "word":
        return scalar.words[0] if len(scalar.words) == 1 else f"one of {', '.join(scalar.words)}"
    if scalar.kind == "text":
        return scalar.expected or "text"
    noun = "a whole number" if scalar.kind == "integer" else _NOUNS.get(scalar.unit, "a number")
    if scalar.low is None and scalar.high is None:
        return noun
    low = "(" if scalar.low_open or scalar.low is None else "["
    high = ")" if scalar.high_open or scalar.high is None else "]"
    return f"{noun} in {low}{_bound(scalar.low, '-inf')}, {_bound(scalar.high, 'inf')}{high}"


def fits(scalar: Scalar, value: object) -> bool:
    """Return whether a value of plain data is valid for the scalar."""
    match scalar.kind:
        case "truth":
            return isinstance(value, bool)
        case "word":
            return isinstance(value, str) and value in scalar.words
        case "text":
            return isinstance(value, str) and (scalar.pattern is None or scalar.pattern.match(value) is not None)
    if isinstance(value, bool) or not isinstance(value, int if scalar.kind == "integer" else (int, float)):
        return False
    try:
        number = float(value)
    except OverflowError:
        return False
    return (
        math.isfinite(number)
        and (scalar.low is None or (value > scalar.low if scalar.low_open else value >= scalar.low))
        and (scalar.high is None or (value < scalar.high if scalar.high_open else value <= scalar.high))
    )


def _wrong_scalar(scalar: Scalar, value: object, where: str) -> WireError:
    if isinstance(value, str) and scalar.kind == "text":
        if scalar.max_length is not None and len(value) > scalar.max_length:
            return too_long(where, scalar.max_length, "characters", len(value))
        if not value and scalar.min_length:
            return WireError("value", f"{where}: expected text of at least one character or no field, got ''", where)
        if not scalar.expected:
            bad = next((c for c in value if scalar.pattern is not None and not scalar.pattern.match(c)), "")
            return WireError(
                "value", f"{where}: expected XML 1.0 characters except carriage return, got {bad!r}", where
            )
    code: Any = "version" if scalar.words == ("iw.v1",) and isinstance(value, str) else "value"
    text = f"{where}: expected {expected(scalar)}, got {shown(value)}"
    for (place, refused), hint in _VALUE_HINTS.items():
        if where.endswith(place) and value == refused:
            text = f"{text}; {hint}"
    return WireError(code, text, where)


def too_long(where: str, most: int, things: str, got: int) -> WireError:
    """Return the error for an exceeded limit."""
    code: Any = "too-long" if things in {"characters", "bytes"} else "too-many"
    return WireError(code, f"{where}: expected at most {most} {things}, got {got}", where)


def check_scalar(scalar: Scalar, value: object, where: str) -> None:
    """Check one scalar of plain data.

    Raises:
        WireError: `value`, `version` or `too-long`.
    """
    if not fits(scalar, value) or (
        isinstance(value, str)
        and ((scalar.max_length is not None and len(value) > scalar.max_length) or len(value) < scalar.min_length)
    ):
        raise _wrong_scalar(scalar, value, where)


def _other_form(shape: Shape, member: Member) -> str:
    """Return how a field is written in XML, for one that was written in another form."""
    root, wire = shape.root, member.wire
    if member.form in {Form.ATTRIBUTE, Form.LIST}:
        example = member.scalar.words[0] if member.scalar is not None and member.scalar.words else "..."
        return f'expected an attribute, as in <{root} {wire}="{example}">, got an element'
    if member.form is Form.CONTENT:
        return f"expected the text of the element, as in <{root}>...</{root}>, got {wire}"
    example = f"<{wire}>...</{wire}>" if member.form is Form.ELEMENT else f"<{wire} .../>"
    return f"expected an element, as in <{root}>{example}</{root}>, got an attribute"


def unknown_field(shape: Shape, name: str, where: str) -> WireError:
    """Return the error for a field that the class does not have, with the name of its most similar field."""
    known = shape.by_wire.get(name)
    if known is not None:
        return WireError("field", f"{where}.{name}: {_other_form(shape, known)}", f"{where}.{name}")
    hint = _HEIGHT_HINTS.get(shape.cls.__name__, "") if name == "Height" else ""
    if not hint:
        near = difflib.get_close_matches(name, list(shape.by_wire), n=1)
        hint = f"did you mean {near[0]}?" if near else ""
    # A name from outside becomes part of the place only if it has the form of a field name.
    place = f"{where}.{name}" if name.isidentifier() and name.isascii() and len(name) <= 40 else where
    text = f"{place}: expected a field of {shape.root}, got {shown(name)}"
    return WireError("field", f"{text}; {hint}" if hint else text, place)


def _check_member(member: Member, value: Any, where: str, strict: bool) -> None:
    if member.form is Form.RECORD and member.record is not None:
        check_plain(shape_of(member.record), value, where, strict=strict)
        return
    if member.form in {Form.LIST, Form.RECORDS}:
        if not isinstance(value, list):
            raise WireError("value", f"{where}: expected a list, got {shown(value)}", where)
        if member.max_count is not None and len(value) > member.max_count:
            raise too_long(where, member.max_count, "of them", len(value))
        if member.record is not None:
            shape = shape_of(member.record)
            for index, item in enumerate(value):
                check_plain(shape, item, f"{where}[{index}]", strict=strict)
            return
        if member.scalar is not None:
            for index, item in enumerate(value):
                if item is not None or not member.scalar.nullable:
                    check_scalar(member.scalar, item, f"{where}[{index}]")
        return
    if member.scalar is not None:
        check_scalar(member.scalar, value, where)


def check_plain(shape: Shape, plain: Any, where: str, *, strict: bool) -> None:
    """Check plain data against a shape; without `strict`, unknown fields are removed from it.

    Args:
        shape: The shape that the data must have.
        plain: Parsed JSON: dicts, lists, text, numbers. Changed in place unless strict.
        where: Place of `plain`, with list items counted from 0.
        strict: Whether unknown fields are refused.

    Raises:
        WireError: The first error, in the order in which fields are declared.
    """
    if not isinstance(plain, dict):
        raise WireError("value", f"{where}: expected an object, got {shown(plain)}", where)
    if isinstance(plain, Repeated):
        raise WireError("malformed", f"{where}: expected each name once, got {shown(plain.name)} twice", where)
    unknown = [name for name in plain if name not in shape.by_wire]
    if unknown and strict:
        raise unknown_field(shape, unknown[0], where)
    for name in unknown:
        del plain[name]
    for member in shape.members:
        place = f"{where}.{member.wire}"
        if member.wire in plain:
            _check_member(member, plain[member.wire], place, strict)
        elif member.required:
            what = expected(member.scalar) if member.scalar is not None else f"a {member.wire}"
            raise WireError("field", f"{place}: expected {what}, got nothing", place)


def root_of(cls: type[Record]) -> str:
    """Return the first name in the places of a document."""
    return shape_of(cls).root
