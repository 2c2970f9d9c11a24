"""The shape of a message class: a description of its fields, made once for the codecs and generators.

Bounds, units, defaults and XML forms come from the annotations in `messages`, so nothing is declared twice.
"""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final, Literal, cast, get_args, get_origin, get_type_hints

import msgspec
from msgspec import inspect

from intellwheels_schemas.messages import ROOTS, Record


class Form(enum.Enum):
    """The form of a field in XML."""

    ATTRIBUTE = "attribute"
    LIST = "list"  # a space-separated attribute
    RECORD = "record"  # one child element
    RECORDS = "records"  # repeated child elements
    ELEMENT = "element"  # a child element that holds text only
    CONTENT = "content"  # the element's own text


@dataclass(frozen=True, slots=True)
class Scalar:
    """A number, text, word or boolean, with its bounds.

    Attributes:
        kind: The type in JSON; `word` is one of a closed list, `truth` a boolean.
        low, high: Bounds, or None. With `low_open` and `high_open` the bound itself is excluded.
        nullable: Whether a list may contain null instead.
        description: Description of the type for people, or empty.
        expected: Name in errors for a text that must match a pattern, or empty.
        unit: SI unit, or `deg`; `1` for a share; empty if there is none.
    """

    kind: Literal["text", "integer", "number", "truth", "word"]
    low: float | None = None
    high: float | None = None
    low_open: bool = False
    high_open: bool = False
    pattern: re.Pattern[str] | None = None
    min_length: int = 0
    max_length: int | None = None
    words: tuple[str, ...] = ()
    nullable: bool = False
    description: str = ""
    expected: str = ""
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Member:
    """A field of a class.

    Attributes:
        wire: The name in XML and JSON.
        name: The name in Python.
        form: The form in XML.
        scalar: Type of the field or of its list items; None for records.
        record: Class of the field or of its list items; None for scalars.
        required: Whether a document must have the field.
        default: The default, or None.
        max_count: Largest number of list items, or None.
        sent: Whether it is required although it is None in Python before the harness fills it in.
    """

    wire: str
    name: str
    form: Form
    scalar: Scalar | None
    record: type[Record] | None
    required: bool
    default: Any
    max_count: int | None = None
    sent: bool = False


@dataclass(frozen=True, slots=True)
class Shape:
    """A class: its fields in declaration order.

    Attributes:
        root: Name of the XML element for a document, else the name of the class.
        members: The fields.
        by_wire: The fields by their name on the wire.
        content: The field whose value is the text of the element, or None.
        ragged: Whether a value in it, at any depth, could equal its default without being the same object.
    """

    cls: type[Record]
    root: str
    members: tuple[Member, ...]
    by_wire: dict[str, Member]
    content: Member | None
    ragged: bool


_NUMBERS: Final = (inspect.IntType, inspect.FloatType)


def _scalar(kind: inspect.Type, extra: dict[str, Any], schema: dict[str, Any], nullable: bool) -> Scalar | None:
    description = str(schema.get("description", ""))
    unit = str(extra.get("unit", ""))
    if isinstance(kind, _NUMBERS):
        low = kind.ge if kind.ge is not None else kind.gt
        high = kind.le if kind.le is not None else kind.lt
        return Scalar(
            kind="integer" if isinstance(kind, inspect.IntType) else "number",
            low=low,
            high=high,
            low_open=kind.gt is not None,
            high_open=kind.lt is not None,
            nullable=nullable,
            description=description,
            unit=unit,
        )
    if isinstance(kind, inspect.BoolType):
        return Scalar(kind="truth", description=description)
    if isinstance(kind, inspect.LiteralType):
        return Scalar(kind="word", words=tuple(str(value) for value in kind.values), description=description)
    if isinstance(kind, inspect.StrType):
        return Scalar(
            kind="text",
            pattern=re.compile(kind.pattern) if kind.pattern is not None else None,
            min_length=kind.min_length or 0,
            max_length=kind.max_length,
            description=description,
            expected=str(extra.get("expected", "")),
        )
    return None


def _peel(kind: inspect.Type) -> tuple[inspect.Type, dict[str, Any], dict[str, Any], bool]:
    """Return a type without `| None` and annotations, its extras, its schema keywords, and whether None is allowed."""
    extra: dict[str, Any] = {}
    schema: dict[str, Any] = {}
    nullable = False
    while True:
        if isinstance(kind, inspect.Metadata):
            # Outer annotations take precedence: they belong to the field, and inner ones to its type.
            extra = {**(kind.extra or {}), **extra}
            schema = {**(kind.extra_json_schema or {}), **schema}
            kind = kind.type
        elif isinstance(kind, inspect.UnionType):
            others = [one for one in kind.types if not isinstance(one, inspect.NoneType)]
            nullable = nullable or len(others) < len(kind.types)
            if len(others) != 1:
                raise TypeError(f"expected a field of one type, got {kind}")
            kind = others[0]
        else:
            return kind, extra, schema, nullable


_FORMS: Final = {"element": Form.ELEMENT, "text": Form.CONTENT}


def _words(hint: Any) -> tuple[str, ...]:
    """Return the words of a closed list in declaration order, since msgspec sorts them."""
    if get_origin(hint) is Literal:
        return get_args(hint)
    return next((words for inner in get_args(hint) if (words := _words(inner))), ())


def _member(field: inspect.Field, hint: Any) -> Member:
    kind, extra, schema, _ = _peel(field.type)
    # A field that is always sent has the default None in Python, for the programs whose harness fills it in.
    sent = extra.get("sent") == "always"
    required = field.required or sent
    default = None if required else field.default
    many = isinstance(kind, inspect.VarTupleType)
    max_count = None
    if isinstance(kind, inspect.VarTupleType):
        max_count = kind.max_length
        kind, item_extra, item_schema, nullable = _peel(kind.item_type)
        extra, schema = {**item_extra, **extra}, {**item_schema, **schema}
    else:
        nullable = False
    if isinstance(kind, inspect.StructType):
        form = Form.RECORDS if many else Form.RECORD
        record = cast("type[Record]", kind.cls)
        return Member(field.encode_name, field.name, form, None, record, required, default, max_count)
    scalar = _scalar(kind, extra, schema, nullable)
    if scalar is None:
        raise TypeError(f"{field.name}: no wire form for {kind}")
    if scalar.words:
        scalar = replace(scalar, words=_words(hint))
    form = Form.LIST if many else _FORMS.get(str(extra.get("xml", "")), Form.ATTRIBUTE)
    return Member(field.encode_name, field.name, form, scalar, None, required, default, max_count, sent)


def _may_be_equal_but_another(member: Member) -> bool:
    if member.record is not None:
        return shape_of(member.record).ragged
    # Python has only one object for each of these values, so msgspec recognises them by identity.
    return not (
        member.required
        or member.default is None
        or member.default == ()
        or isinstance(member.default, bool)
        or (isinstance(member.default, int) and abs(member.default) <= 5)
        or (member.scalar is not None and member.scalar.kind == "word" and str(member.default).isidentifier())
    )


@cache
def shape_of(cls: type[Record]) -> Shape:
    """Return the shape of a message class.

    Raises:
        TypeError: A field has a type that XML and JSON cannot express, which is a mistake in `messages`.
    """
    info = inspect.type_info(cls)
    if not isinstance(info, inspect.StructType):
        raise TypeError(f"expected a message class, got {cls}")
    hints = get_type_hints(cls, include_extras=True)
    members = tuple(_member(field, hints[field.name]) for field in info.fields)
    content = [member for member in members if member.form is Form.CONTENT]
    return Shape(
        cls=cls,
        root=ROOTS.get(cls, cls.__name__),
        members=members,
        by_wire={member.wire: member for member in members},
        content=content[0] if content else None,
        ragged=any(_may_be_equal_but_another(member) for member in members),
    )


_write = msgspec.json.Encoder().encode


def number_text(value: float) -> str:
    """Return the text of a float or an integer in both encodings: 5.0, 0.00001, 1e-7, 1e16.

    Raises:
        ValueError: The number is not finite, which no message may contain.
    """
    text = _write(value).decode()
    if text == "null":
        raise ValueError(f"expected a finite number, got {value}")
    return text


def scalar_of(kind: inspect.Type) -> Scalar | None:
    """Return the scalar that describes a type, or None if the type is not a scalar."""
    try:
        kind, extra, schema, nullable = _peel(kind)
    except TypeError:
        return None
    return _scalar(kind, extra, schema, nullable)
