"""XML Schema 1.0 of every document, made from the shapes, for programs that write it: unknown fields are not valid.

If no child of a class is repeated, the schema allows the children in any order. Otherwise it allows any number of each
child in any order, since XML Schema 1.0 cannot express more; `schematron` has the rest. Every document that the
simulator accepts is valid. `reader_xsd` makes the schemas for programs that read.
"""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, Final, Literal, get_origin
from xml.sax.saxutils import escape, quoteattr

from lxml import etree
from msgspec import inspect

from intellwheels_schemas import messages
from intellwheels_schemas.field_docs import field_docs
from intellwheels_schemas.messages import ROOTS, OperatorSay, Record
from intellwheels_schemas.shapes import Form, Member, Scalar, Shape, number_text, scalar_of, shape_of

_NUMBER: Final = r"-?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][+\-]?[0-9]+)?"
_INTEGER: Final = r"-?(0|[1-9][0-9]*)"


MADE: Final = "Made by python -m intellwheels_schemas; do not edit."


def _facets(scalar: Scalar) -> tuple[str, list[str]]:
    """Return the base type of a scalar and its facets."""
    facets: list[str] = []
    if scalar.kind == "truth":
        return "xs:boolean", ['<xs:pattern value="true|false"/>']
    if scalar.kind == "word":
        return "xs:string", [f"<xs:enumeration value={quoteattr(word)}/>" for word in scalar.words]
    if scalar.kind == "text":
        if scalar.pattern is not None:
            # XML itself limits the characters of other texts, except the carriage return.
            pattern = scalar.pattern.pattern.removeprefix("^").removesuffix(r"\Z") if scalar.expected else r"[^\r]*"
            facets.append(f"<xs:pattern value={quoteattr(pattern)}/>")
        if scalar.min_length:
            facets.append(f'<xs:minLength value="{scalar.min_length}"/>')
        if scalar.max_length is not None:
            facets.append(f'<xs:maxLength value="{scalar.max_length}"/>')
        return "xs:string", facets
    integer = scalar.kind == "integer"
    facets.append(f'<xs:pattern value="{_INTEGER if integer else _NUMBER}"/>')
    if scalar.low is not None:
        facets.append(f'<xs:min{"Ex" if scalar.low_open else "In"}clusive value="{number_text(scalar.low)}"/>')
    if scalar.high is not None:
        facets.append(f'<xs:max{"Ex" if scalar.high_open else "In"}clusive value="{number_text(scalar.high)}"/>')
    return "xs:integer" if integer else "xs:double", facets


def _note(text: str) -> str:
    return f"<xs:annotation><xs:documentation>{escape(text)}</xs:documentation></xs:annotation>"


def _simple(scalar: Scalar, name: str = "") -> str:
    base, facets = _facets(scalar)
    named = f' name="{name}"' if name else ""
    text = "; ".join(part for part in (scalar.description, f"unit: {scalar.unit}" if scalar.unit else "") if part)
    note = _note(text) if name and text else ""
    restriction = f'<xs:restriction base="{base}">{"".join(facets)}</xs:restriction>'
    return f"<xs:simpleType{named}>{note}{restriction}</xs:simpleType>"


def _key(scalar: Scalar) -> tuple[Any, ...]:
    """Return a key that is equal for two scalars of the same type, regardless of their use."""
    pattern = scalar.pattern.pattern if scalar.pattern is not None else None
    return (
        scalar.kind, scalar.low, scalar.high, scalar.low_open, scalar.high_open, pattern, scalar.min_length,
        scalar.max_length, frozenset(scalar.words), scalar.unit,
    )  # fmt: skip


def _named_scalars() -> dict[tuple[Any, ...], tuple[str, Scalar]]:
    """Return the scalars that have a name in `messages`."""
    named: dict[tuple[Any, ...], tuple[str, Scalar]] = {}
    for name, value in vars(messages).items():
        if get_origin(value) not in {Annotated, Literal}:
            continue
        scalar = scalar_of(inspect.type_info(value))
        if scalar is not None:
            named.setdefault(_key(scalar), (name, scalar))
    return named


class Types:
    """The types of a schema; `used` has the simple ones that were asked for, by name.

    Args:
        grows: Whether unknown attributes and children pass.
    """

    def __init__(self, *, grows: bool = False) -> None:
        self.grows = grows
        self.named = _named_scalars()
        self.used: dict[str, str] = {}

    def simple_types(self) -> str:
        """Return the definitions of the simple types that were used."""
        return "".join(self.used[name] for name in sorted(self.used))

    def type_of(self, scalar: Scalar) -> tuple[str, str]:
        """Return the name of a scalar's type, or an empty name and the definition of the type."""
        found = self.named.get(_key(scalar))
        if found is None:
            return ("xs:boolean", "") if scalar.kind == "truth" else ("", _simple(scalar))
        name = f"{found[0]}Type"
        self.used[name] = _simple(found[1], name)
        return name, ""

    def attribute(self, member: Member, text: str) -> str:
        """Return the declaration of an attribute."""
        if member.scalar is None:
            return ""
        note = _note(text)
        use = ' use="required"' if member.required else ""
        name, inline = self.type_of(member.scalar)
        opening = f'<xs:attribute name="{member.wire}"{use}'
        if member.form is Form.ATTRIBUTE:
            typed = f' type="{name}"' if name else ""
            return f"{opening}{typed}>{note}{inline}</xs:attribute>"
        item = f'<xs:list itemType="{name}"/>' if name else f"<xs:list>{inline}</xs:list>"
        if member.scalar.nullable:
            dash = _simple(Scalar(kind="word", words=("-",)))
            item = f'<xs:list><xs:simpleType><xs:union memberTypes="{name}">{dash}</xs:union></xs:simpleType></xs:list>'
        if member.max_count is not None:
            most = f'<xs:maxLength value="{member.max_count}"/>'
            item = f"<xs:restriction><xs:simpleType>{item}</xs:simpleType>{most}</xs:restriction>"
        return f"{opening}>{note}<xs:simpleType>{item}</xs:simpleType></xs:attribute>"

    def child(self, member: Member, occurs: str, text: str) -> str:
        """Return the declaration of a child element."""
        if member.record is not None:
            name = member.record.__name__
        else:
            name = self.type_of(member.scalar)[0] if member.scalar is not None else ""
        return f'<xs:element name="{member.wire}" type="{name}"{occurs}>{_note(text)}</xs:element>'

    def complex(self, shape: Shape) -> str:
        """Return the type of a class."""
        docs = field_docs(shape.cls)
        attributes = "".join(
            self.attribute(member, docs[member.name])
            for member in shape.members
            if member.form in {Form.ATTRIBUTE, Form.LIST}
        )
        children = [m for m in shape.members if m.form in {Form.RECORD, Form.RECORDS, Form.ELEMENT}]
        note = _note((shape.cls.__doc__ or "").partition("\n")[0])
        opening = f'<xs:complexType name="{shape.cls.__name__}">{note}'
        if self.grows:
            attributes += '<xs:anyAttribute processContents="skip"/>'
        if shape.content is not None and shape.content.scalar is not None:
            # An element with optional text is empty if the text is absent.
            name, _ = self.type_of(dataclasses.replace(shape.content.scalar, min_length=0))
            return (
                f'{opening}<xs:simpleContent><xs:extension base="{name}">{attributes}</xs:extension>'
                "</xs:simpleContent></xs:complexType>"
            )
        if self.grows:
            # Known elements are declared for the whole document. XML Schema 1.0 allows no wildcard beside them here.
            any_child = '<xs:any processContents="lax" minOccurs="0" maxOccurs="unbounded"/>'
            inside = f"<xs:sequence>{any_child}</xs:sequence>"
        elif any(member.form is Form.RECORDS for member in children):
            inside = "".join(self.child(member, "", docs[member.name]) for member in children)
            inside = f'<xs:choice minOccurs="0" maxOccurs="unbounded">{inside}</xs:choice>'
        elif children:
            inside = "".join(self.child(m, "" if m.required else ' minOccurs="0"', docs[m.name]) for m in children)
            inside = f"<xs:all>{inside}</xs:all>"
        else:
            inside = ""
        return f"{opening}{inside}{attributes}</xs:complexType>"


def classes_below(roots: list[type[Record]]) -> list[type[Record]]:
    """Return the classes of the roots and of everything in them, each once."""
    found: dict[type[Record], None] = {}

    def add(cls: type[Record]) -> None:
        if cls not in found:
            found[cls] = None
            for member in shape_of(cls).members:
                if member.record is not None:
                    add(member.record)

    for root in roots:
        add(root)
    return list(found)


def schema_file(inside: str, about: str) -> str:
    """Return the text of a schema with this content."""
    root = etree.fromstring(
        '<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema">'
        f"<xs:annotation><xs:documentation>{escape(about)}</xs:documentation></xs:annotation>{inside}</xs:schema>"
    )
    etree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + etree.tostring(root, encoding="unicode") + "\n"


def xsd_files() -> dict[str, str]:
    """Return the schema files by name: `iw.xsd`, `operator-say.xsd` for the message of ctl/say, and `types.xsd`."""
    types = Types()
    complexes = "".join(types.complex(shape_of(cls)) for cls in classes_below(list(ROOTS)))
    simples = types.simple_types()
    include = '<xs:include schemaLocation="types.xsd"/>'
    elements = "".join(
        f'<xs:element name="{root}" type="{cls.__name__}"/>' for cls, root in ROOTS.items() if cls is not OperatorSay
    )
    return {
        "types.xsd": schema_file(simples + complexes, f"Types of all documents, version iw.v1, to write. {MADE}"),
        "iw.xsd": schema_file(include + elements, f"All documents, version iw.v1, to write. {MADE}"),
        "operator-say.xsd": schema_file(
            f'{include}<xs:element name="Say" type="{OperatorSay.__name__}"/>',
            f"The Say of ctl/say, which has the same root element as that of an agent. {MADE}",
        ),
    }
