"""JSON Schema (2020-12) of every document, made from the shapes, and of the lines of the simulator's files."""

from __future__ import annotations

from typing import Any, Final

import msgspec

from intellwheels_schemas import file_records, messages
from intellwheels_schemas.field_docs import field_docs
from intellwheels_schemas.field_rules import json_rules
from intellwheels_schemas.file_records import LINES, FileRecord
from intellwheels_schemas.messages import Record
from intellwheels_schemas.shapes import Form, Member, Scalar, shape_of
from intellwheels_schemas.vectors import NAMES

Schema = dict[str, Any]

_DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"
# ECMAScript has no \Z. Its $ matches only the end.
_END: Final = r"\Z"


def _scalar(scalar: Scalar) -> Schema:
    kinds = {"text": "string", "word": "string", "integer": "integer", "number": "number", "truth": "boolean"}
    schema: Schema = {"type": kinds[scalar.kind]}
    if scalar.words:
        schema["enum"] = list(scalar.words)
    if scalar.pattern is not None:
        schema["pattern"] = f"{scalar.pattern.pattern.removesuffix(_END)}$"
    if scalar.min_length:
        schema["minLength"] = scalar.min_length
    if scalar.max_length is not None:
        schema["maxLength"] = scalar.max_length
    if scalar.low is not None:
        schema["exclusiveMinimum" if scalar.low_open else "minimum"] = scalar.low
    if scalar.high is not None:
        schema["exclusiveMaximum" if scalar.high_open else "maximum"] = scalar.high
    return schema


def _member(member: Member, text: str) -> Schema:
    if member.record is not None:
        item: Schema = {"$ref": f"#/$defs/{member.record.__name__}"}
    elif member.scalar is not None:
        item = _scalar(member.scalar)
        if member.scalar.nullable:
            item = {"anyOf": [item, {"type": "null"}]}
    else:
        item = {}
    schema = item
    if member.form in {Form.LIST, Form.RECORDS}:
        schema = {"type": "array", "items": item}
        if member.max_count is not None:
            schema["maxItems"] = member.max_count
    unit = member.scalar.unit if member.scalar is not None else ""
    schema["description"] = f"{text} Unit: {unit}." if unit else text
    if not member.required and member.default is not None and member.default != ():
        schema["default"] = member.default
    return schema


def _record(cls: type[Record], grows: bool) -> Schema:
    shape, docs = shape_of(cls), field_docs(cls)
    schema: Schema = {
        "type": "object",
        "description": (cls.__doc__ or "").partition("\n")[0],
        "properties": {member.wire: _member(member, docs[member.name]) for member in shape.members},
    }
    if not grows:
        schema["additionalProperties"] = False
    if required := [member.wire for member in shape.members if member.required]:
        schema["required"] = required
    if rules := json_rules(cls):
        schema["allOf"] = rules
    return schema


def _add(cls: type[Record], definitions: dict[str, Schema], grows: bool) -> None:
    for member in shape_of(cls).members:
        if member.record is not None and member.record.__name__ not in definitions:
            definitions[member.record.__name__] = _record(member.record, grows)
            _add(member.record, definitions, grows)


def _portable(schema: Any) -> Any:
    """Return a schema with the patterns rewritten for ECMAScript."""
    if isinstance(schema, dict):
        return {
            key: f"{value.removesuffix(_END)}$" if key == "pattern" else _portable(value)
            for key, value in schema.items()
        }
    return [_portable(item) for item in schema] if isinstance(schema, list) else schema


def _line(cls: type[FileRecord]) -> Schema:
    """Return the schema of a kind of line. Unknown fields are allowed, since a later version may add some."""
    _, components = msgspec.json.schema_components([cls], ref_template="#/$defs/{name}")
    definitions: dict[str, Schema] = {}
    for name, found in components.items():
        message = getattr(messages, name, None)
        definitions[name] = _logged(message) if message is not None else _described(name, found)
    return {**definitions.pop(cls.__name__), "$defs": dict(sorted(definitions.items()))}


def _logged(cls: type[Record]) -> Schema:
    """Return the schema of a message in a log. Logs of earlier versions have Actions and poses without a Session."""
    schema = _record(cls, True)
    optional = {member.wire for member in shape_of(cls).members if member.sent}
    if optional and not (required := [wire for wire in schema["required"] if wire not in optional]):
        del schema["required"]
    elif optional:
        schema["required"] = required
    return schema


def _described(name: str, found: Schema) -> Schema:
    """Return msgspec's schema of a file record, with the descriptions of its fields."""
    cls = getattr(file_records, name)
    schema: Schema = _portable(found)
    schema["description"] = (cls.__doc__ or "").partition("\n")[0]
    wires = dict(zip(cls.__struct_encode_fields__, cls.__struct_fields__, strict=True))
    for wire, member in schema["properties"].items():
        if wire in wires:
            member["description"] = field_docs(cls)[wires[wire]]
    return schema


def json_schemas(*, grows: bool) -> dict[str, Schema]:
    """Return the schemas of documents by name.

    Args:
        grows: Whether unknown fields pass, as in every program that reads a document. The others are for programs that
            write one: the simulator refuses unknown fields. The schemas of the lines of files are only for readers.
    """
    schemas: dict[str, Schema] = {}
    for name, cls in NAMES.items():
        definitions: dict[str, Schema] = {}
        _add(cls, definitions, grows)
        schemas[name] = {"$schema": _DIALECT, "title": name, **_record(cls, grows)}
        if definitions:
            schemas[name]["$defs"] = dict(sorted(definitions.items()))
    for line in LINES if grows else ():
        schemas[line.__name__] = {"$schema": _DIALECT, "title": line.__name__, **_line(line)}
    return schemas
