"""Converts between XML and the plain data of JSON, using the shape of the class.

XML is written as one line without declaration or indentation. XML that is read may come from any program: no DTD, no
entities, no network, bounded depth. Numbers follow the grammar of JSON, so that both encodings accept the same.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, Final, cast

from lxml import etree

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown, unknown_field
from intellwheels_schemas.messages import Record
from intellwheels_schemas.shapes import Form, Member, Scalar, Shape, number_text, shape_of

Plain = dict[str, Any]
_Write = Callable[[Any, list[str], str], None]

# Longer integers are outside every range, and Python refuses to convert integers of more than 4,300 digits.
_INTEGER: Final = re.compile(r"-?(?:0|[1-9][0-9]{0,18})\Z")
_NUMBER: Final = re.compile(r"-?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?\Z")
# A document type can only be before the root, so only the start is searched. The match is possessive: with
# backtracking, a megabyte of comment openings would take minutes.
_DOCTYPE: Final = re.compile(rb"(?:\xef\xbb\xbf)?(?>\s+|<\?.*?\?>|<!--.*?-->)*+<!DOCTYPE", re.DOTALL)
_SPACE: Final = " \t\r\n"
# Attributes by which a document names its schema; they are not read.
_XSI: Final = "{http://www.w3.org/2001/XMLSchema-instance}"


# ---------------------------------------------------------------- writing


def _escaped(text: str) -> str:
    if not ("&" in text or "<" in text or ">" in text or '"' in text or "\n" in text or "\t" in text):
        return text
    for plain, escaped in (
        ("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ('"', "&quot;"),
        # Readers turn bare line feeds and tabs in attributes into spaces.
        ("\n", "&#10;"), ("\t", "&#9;"),
    ):  # fmt: skip
        text = text.replace(plain, escaped)
    return text


def _cdata(text: str) -> str:
    return f"<![CDATA[{text.replace(']]>', ']]]]><![CDATA[>')}]]>"


def _truth(value: bool) -> str:
    return "true" if value else "false"


def _text_of(scalar: Scalar) -> Callable[[Any], str]:
    if scalar.kind == "truth":
        return _truth
    if scalar.kind == "number":
        return number_text
    if scalar.kind == "integer":
        return int.__str__
    return _escaped


@cache
def _writer(cls: type[Record]) -> _Write:
    """Return a function that appends the XML of one class to a list of strings."""
    shape = shape_of(cls)
    # Chosen once per class: the writer runs for every body in every tick.
    attributes = [
        (member.name, member.default, f' {member.wire}="', _text_of(member.scalar), member.form is Form.LIST)
        for member in shape.members
        if member.scalar is not None and member.form in {Form.ATTRIBUTE, Form.LIST}
    ]
    children = [
        (member.name, member.wire, member.form, _writer(member.record) if member.record is not None else None)
        for member in shape.members
        if member.form in {Form.RECORD, Form.RECORDS, Form.ELEMENT}
    ]
    content = shape.content.name if shape.content is not None else None

    def write(message: Any, out: list[str], tag: str) -> None:
        out.append(f"<{tag}")
        for name, default, opening, text_of, many in attributes:
            value = getattr(message, name)
            if value is default or value == default:
                continue
            text = " ".join(["-" if item is None else text_of(item) for item in value]) if many else text_of(value)
            out.append(f'{opening}{text}"')
        at = len(out)
        for name, wire, form, write_child in children:
            value = getattr(message, name)
            if value is None:
                continue
            if write_child is None:
                out.append(f"<{wire}>{_cdata(value)}</{wire}>")
            elif form is Form.RECORD:
                write_child(value, out, wire)
            else:
                for item in value:
                    write_child(item, out, wire)
        if content is not None:
            text = getattr(message, content)
            if text is not None:
                out.append(_cdata(text))
        if len(out) == at:
            out.append("/>")
        else:
            out[at] = f">{out[at]}"
            out.append(f"</{tag}>")

    return write


def to_xml(message: Record) -> str:
    """Return a message as one line of XML.

    Raises:
        ValueError: A number in the message is not finite, which is a bug.
    """
    out: list[str] = []
    cls = type(message)
    _writer(cls)(message, out, shape_of(cls).root)
    return "".join(out)


# ---------------------------------------------------------------- reading


def parse(data: bytes, where: str) -> etree._Element:
    """Return the root element of a document.

    Args:
        data: UTF-8; the caller has checked the length.
        where: Name of the document in errors.

    Raises:
        WireError: `malformed`.
    """
    if b"<!DOCTYPE" in data and _DOCTYPE.match(data):
        raise WireError("malformed", f"{where}: expected XML without a document type, got one", where)
    # Each call makes a new parser: parsers must not be shared between threads, and they keep their last error.
    parser = etree.XMLParser(
        encoding="utf-8", resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False,
        remove_comments=True, remove_pis=True,
    )  # fmt: skip
    try:
        return etree.fromstring(data, parser)
    except (etree.LxmlError, ValueError) as error:
        detail = str(error)[:120].encode("ascii", "backslashreplace").decode()
        raise WireError("malformed", f"{where}: expected well-formed XML, got {detail}", where) from error


def _integer(text: str) -> object:
    return int(text) if _INTEGER.match(text) else text


def _number(text: str) -> object:
    if not _NUMBER.match(text):
        return text
    value = float(text)
    return value if abs(value) <= 1.8e308 else text


_TRUTHS: Final[dict[str, bool]] = {"true": True, "false": False}


def _truth_value(text: str) -> object:
    return _TRUTHS.get(text, text)


def _same(text: str) -> object:
    return text


_VALUES: Final[dict[str, Callable[[str], object]]] = {
    "integer": _integer, "number": _number, "truth": _truth_value, "text": _same, "word": _same,
}  # fmt: skip


def _blank(text: str | None) -> bool:
    return not text or not text.strip(_SPACE)


def _stray(text: str, where: str) -> WireError:
    return WireError("field", f"{where}: expected no text here, got {shown(text.strip(_SPACE))}", where)


def _name_of(element: etree._Element) -> str:
    return str(element.tag)


def _text_only(element: etree._Element, where: str) -> str:
    if element.attrib or len(element):
        raise WireError("field", f"{where}: expected text only, got attributes or elements", where)
    return element.text or ""


_Reader = Callable[[str], object]


@cache
def _readers(cls: type[Record]) -> tuple[Shape, dict[str, tuple[_Reader, bool]], dict[str, Member]]:
    """Return the shape of a class, its attributes (a reader each, and whether it is a list), and its children."""
    shape = shape_of(cls)
    attributes: dict[str, tuple[_Reader, bool]] = {}
    children: dict[str, Member] = {}
    for member in shape.members:
        if member.form in {Form.ATTRIBUTE, Form.LIST} and member.scalar is not None:
            attributes[member.wire] = (_VALUES[member.scalar.kind], member.form is Form.LIST)
        elif member.form is not Form.CONTENT:
            children[member.wire] = member
    return shape, attributes, children


def to_plain(element: etree._Element, cls: type[Record], where: str, *, strict: bool) -> Plain:
    """Return the plain data of an element, with numbers converted.

    Args:
        element: The element.
        cls: The class of the element.
        where: The place of the element, for errors.
        strict: Whether unknown attributes and elements are refused; otherwise they are ignored.

    Raises:
        WireError: `field`, for an attribute, element or text that does not belong there. Values are checked later.
    """
    shape, attributes, children = _readers(cls)
    plain: Plain = {}
    for name, value in cast("list[tuple[str, str]]", element.items()):
        found = attributes.get(name)
        if found is not None:
            read, many = found
            if many:
                plain[name] = [None if item == "-" else read(item) for item in value.split(" ") if item]
            else:
                plain[name] = read(value)
        elif strict and not name.startswith(_XSI):
            raise unknown_field(shape, name, where)
    if shape.content is not None:
        text = element.text or ""
        # In XML, empty text and absent text look the same: required text is then empty, optional text absent.
        if text or shape.content.required:
            plain[shape.content.wire] = text
    elif not _blank(element.text):
        raise _stray(element.text or "", where)
    for child in element:
        name = _name_of(child)
        if not _blank(child.tail):
            raise _stray(child.tail or "", where)
        member = children.get(name)
        if member is None:
            if strict:
                raise unknown_field(shape, name, where)
        elif member.form is Form.RECORDS and member.record is not None:
            items = plain.setdefault(name, [])
            items.append(to_plain(child, member.record, f"{where}.{name}[{len(items)}]", strict=strict))
        elif name in plain:
            raise WireError("malformed", f"{where}: expected <{name}> once, got two", where)
        elif member.record is not None:
            plain[name] = to_plain(child, member.record, f"{where}.{name}", strict=strict)
        else:
            plain[name] = _text_only(child, f"{where}.{name}")
    return plain


def _line(element: etree._Element) -> int:
    return cast("int", element.sourceline or 0)


def places(element: etree._Element, cls: type[Record], where: str) -> Iterator[tuple[str, int]]:
    """Yield the place and line of an element and of all its children that are fields."""
    yield where, _line(element)
    counts: dict[str, int] = {}
    children = _readers(cls)[2]
    for child in element:
        member = children.get(_name_of(child))
        if member is None:
            continue
        place = f"{where}.{member.wire}"
        if member.form is Form.RECORDS:
            index = counts[member.wire] = counts.get(member.wire, -1) + 1
            place = f"{place}[{index}]"
        if member.record is None:
            yield place, _line(child)
        else:
            yield from places(child, member.record, place)
