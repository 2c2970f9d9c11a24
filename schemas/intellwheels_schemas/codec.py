"""Converts messages to bytes and back, in both encodings. `decode` raises only `WireError`.

An ordinary JSON document needs one typed decode and three searches in its bytes. Any other document takes a slow path,
which finds the exact error and its place.
"""

from __future__ import annotations

import enum
import json
from collections.abc import Callable
from functools import cache
from typing import Any, Final, TypeVar, cast

import msgspec

from intellwheels_schemas import elements, plain_actions, rules
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import check_plain, object_of_pairs, root_of, shown, too_long
from intellwheels_schemas.messages import (
    Actions,
    CrewJoin,
    Delete,
    Leave,
    Load,
    OperatorSay,
    Pause,
    Pose,
    Quit,
    Record,
    Reset,
    Restore,
    Resume,
    Robot,
    Save,
    Say,
    Seek,
    Spawn,
    Speed,
    Step,
    Take,
    Teleport,
    UserInput,
)
from intellwheels_schemas.shapes import shape_of

_M = TypeVar("_M", bound=Record)


class Encoding(enum.StrEnum):
    """The encodings of a payload; the value is the text of Zenoh's encoding, as it is written.

    The key says the version. With a suffix, Zenoh's own tools would not recognise the encoding and would print base64.
    """

    JSON = "application/json"
    XML = "application/xml"


VERSION: Final = "iw.v1"
MAX_BYTES: Final = 1 << 20
"""Longest message of any kind, 1 MiB: the limit of the link."""

SMALL: Final = 4096
LIMITS: Final[dict[type[Record], int]] = {
    **dict.fromkeys(
        (Actions, UserInput, Say, OperatorSay, Leave, Pause, Resume, Step, Reset, Speed, Delete, Teleport, Take, Save,
         Restore, Seek, Quit),
        SMALL,
    ),
    Pose: 4 * SMALL,
    Robot: 16 * SMALL,
    Spawn: 16 * SMALL,
    CrewJoin: MAX_BYTES // 2,
    Load: MAX_BYTES,
}  # fmt: skip
"""Longest message of each class that the simulator receives, in bytes; for all others it is `MAX_BYTES`."""

_TYPES: Final = {"application/json": Encoding.JSON, "application/xml": Encoding.XML}
_UNSAID: Final = frozenset({"", "zenoh/bytes", "zenoh/string"})

_write = msgspec.json.Encoder().encode


def is_known(encoding: str) -> bool:
    """Return whether Zenoh's encoding, as text, is one of this contract, with or without the version."""
    kind, _, schema = encoding.partition(";")
    return kind in _TYPES and schema in {"", VERSION}


def encoding_of(encoding: str, data: bytes = b"") -> Encoding:
    """Return the encoding of a payload.

    Args:
        encoding: Zenoh's encoding as text. Empty text, `zenoh/bytes` and `zenoh/string` do not determine it.
        data: The payload. Its first byte decides if `encoding` does not.

    Raises:
        WireError: `encoding`, or `version` for another version of the contract.
    """
    kind, _, schema = encoding.partition(";")
    found = _TYPES.get(kind)
    if found is not None and schema in {"", VERSION}:
        return found
    if found is not None and schema.startswith("iw."):
        raise WireError("version", f"encoding: expected version {VERSION}, got {shown(schema)}", "encoding")
    if encoding in _UNSAID:
        if data[:1] == b"{":
            return Encoding.JSON
        if data[:1] == b"<":
            return Encoding.XML
        raise WireError(
            "encoding", "encoding: expected a payload that begins with { or <, got another byte", "encoding"
        )
    text = f"encoding: expected {Encoding.JSON} or {Encoding.XML}, got {shown(encoding)}"
    raise WireError("encoding", text, "encoding")


# ---------------------------------------------------------------- out


def _canonical(message: _M) -> _M:
    """Return the message with every value that equals its default replaced by the default itself.

    msgspec leaves out a field only if its value is the same object as the default. A computed 0.0 is another object.
    """
    shape = shape_of(type(message))
    if not shape.ragged:
        return message
    changes: dict[str, Any] = {}
    for member in shape.members:
        value = getattr(message, member.name)
        if value is member.default:
            continue
        if member.record is None:
            if value == member.default:
                changes[member.name] = member.default
        elif shape_of(member.record).ragged and value is not None:
            if isinstance(value, Record):
                new: Any = _canonical(value)
                if new is not value:
                    changes[member.name] = new
            else:
                items = tuple([_canonical(item) for item in value])
                if any(a is not b for a, b in zip(items, value, strict=True)):
                    changes[member.name] = items
    return msgspec.structs.replace(message, **changes) if changes else message


def _nulls_belong(plain: Any, cls: type[Record]) -> bool:
    for member in shape_of(cls).members:
        value = plain.get(member.wire, ())
        if value is None:
            return False
        if member.record is not None:
            items = value if isinstance(value, list) else [value] if value else []
            if not all(_nulls_belong(item, member.record) for item in items):
                return False
        elif isinstance(value, list) and None in value and member.scalar is not None and not member.scalar.nullable:
            return False
    return True


def encode(message: Record, encoding: Encoding = Encoding.JSON) -> bytes:
    """Return the bytes of a message.

    Raises:
        ValueError: A number is not finite. This is a bug.
    """
    if encoding is Encoding.JSON:
        data = _write(_canonical(message))
        # msgspec writes NaN as null. Only the arrays of a lidar contain nulls. Text may contain the word null.
        if b"null" in data and not _nulls_belong(msgspec.json.decode(data), type(message)):
            raise ValueError(f"{root_of(type(message))}: expected finite numbers, got {message}")
        return data
    return elements.to_xml(message).encode()


# ---------------------------------------------------------------- in


@cache
def decoder_for(cls: type[_M]) -> Callable[[bytes], _M]:
    """Return the fast typed JSON reader of a class. It does not detect repeated names and nulls."""
    return cast("Callable[[bytes], _M]", msgspec.json.Decoder(cls).decode)


def _no_constant(name: str) -> Any:
    raise ValueError(f"expected a number, got {name}")


def parse_json(data: bytes, where: str) -> Any:
    """Return the plain data of a JSON document.

    Raises:
        WireError: `malformed`.
    """
    try:
        return json.loads(data.decode(), object_pairs_hook=object_of_pairs, parse_constant=_no_constant)
    except RecursionError:
        raise WireError(
            "malformed", f"{where}: expected JSON of moderate depth, got it nested too deeply", where
        ) from None
    except ValueError as error:
        detail = str(error)[:120].encode("ascii", "backslashreplace").decode()
        raise WireError("malformed", f"{where}: expected well-formed JSON, got {detail}", where) from None


def from_plain(cls: type[_M], plain: Any, *, strict: bool = True) -> _M:
    """Return a message from plain data (parsed JSON). The rules that span several fields are not checked.

    Raises:
        WireError: The first error in the data.
    """
    root = root_of(cls)
    check_plain(shape_of(cls), plain, root, strict=strict)
    try:
        return msgspec.convert(plain, cls)
    except (msgspec.ValidationError, RecursionError) as error:
        raise WireError("value", f"{root}: {error}", root) from None


def _from_json(cls: type[_M], data: bytes, strict: bool, read: Callable[[bytes], _M]) -> _M:
    try:
        message = read(data)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        pass
    else:
        if repeats_nothing(message, data):
            return message
    return from_plain(cls, parse_json(data, root_of(cls)), strict=strict)


def repeats_nothing(message: Record, data: bytes) -> bool:
    """Return whether a JSON document surely has no repeated name and no null, which a fast reader does not detect.

    Args:
        message: What the fast reader found in it.
        data: The document.
    """
    written = _write(message)
    if written == data:  # as our writer writes it
        return True
    # The encoded message repeats no name, so equal numbers of colons mean that the data repeats none either.
    # A colon within text counts on both sides, unless it is escaped.
    return b"null" not in data and b"\\u" not in data and data.count(b":") == written.count(b":")


def _from_xml(cls: type[_M], data: bytes, strict: bool) -> _M:
    root = root_of(cls)
    element = elements.parse(data, root)
    if element.tag != root:
        raise WireError("malformed", f"{root}: expected <{root}>, got <{str(element.tag)[:40]}>", root)
    plain = elements.to_plain(element, cls, root, strict=strict)
    try:
        return msgspec.convert(plain, cls)
    except (msgspec.ValidationError, RecursionError):
        return from_plain(cls, plain, strict=strict)


def decode(cls: type[_M], data: bytes, encoding: Encoding = Encoding.JSON, *, strict: bool = True) -> _M:
    """Return the message that the bytes encode.

    Args:
        cls: The class that belongs to the key.
        data: The payload.
        encoding: The encoding of the payload, from `encoding_of`.
        strict: Whether unknown fields are refused (in the simulator) or ignored (in all other programs).

    Raises:
        WireError: The bytes are wrong. The error has code, place and text. Nothing else is raised.
    """
    limit, read, has_rule = _reading(cls)
    if len(data) > limit:
        raise too_long(root_of(cls), limit, "bytes", len(data))
    if cls is Actions:
        plain = plain_actions.from_json(data) if encoding is Encoding.JSON else plain_actions.from_xml(data)
        if plain is not None:
            return cast("_M", plain)
    message: _M = _from_json(cls, data, strict, read) if encoding is Encoding.JSON else _from_xml(cls, data, strict)
    if has_rule:
        rules.check(message)
    if isinstance(message, Actions):
        plain_actions.remember(message)
    return message


@cache
def _reading(cls: type[_M]) -> tuple[int, Callable[[bytes], _M], bool]:
    """Return the longest message of a class, its fast reader, and whether a rule spans several of its fields."""
    return LIMITS.get(cls, MAX_BYTES), decoder_for(cls), rules.has_rule(cls)
