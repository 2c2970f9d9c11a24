"""JSON Schema (2020-12) of every document, from the shapes."""

from __future__ import annotations

from typing import Any

from intellwheels_schemas.messages import Record
from intellwheels_schemas.shapes import Form, Member, Scalar, shape_of
from intellwheels_schemas.vectors import NAMES

Schema = dict[str, Any]


def _scalar(scalar: Scalar) -> Schema:
    kinds = {"text": "string", "word": "string", "integer": "integer", "number": "number", "truth": "boolean"}
    schema: Schema = {"type": kinds[scalar.kind]}
    if scalar.words:
        schema["enum"] = list(scalar.words)
    if scalar.pattern is not None:
        # ECMAScript has no \Z, and its $ is the end.
        schema["pattern"] = scalar.pattern.pattern.removesuffix(r"\Z") + "$"
    if scalar.min_length:
        schema["minLength"] = scalar.min_length
    if scalar.max_length is not None:
        schema["maxLength"] = scalar.max_length
    if scalar.low is not None:
        schema["exclusiveMinimum" if scalar.low_open else "minimum"] = scalar.low
    if scalar.high is not None:
        schema["exclusiveMaximum" if scalar.high_open else "maximum"] = scalar.high
    return schema


def _member(member: Member) -> Schema:
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
    words = [member.description or (member.scalar.description if member.scalar is not None else "")]
    if member.scalar is not None and member.scalar.unit:
        words.append(f"unit: {member.scalar.unit}")
    if any(words):
        schema["description"] = "; ".join(word for word in words if word)
    if not member.required and member.default is not None and member.default != ():
        schema["default"] = member.default
    return schema


def _record(cls: type[Record]) -> Schema:
    shape = shape_of(cls)
    schema: Schema = {
        "type": "object",
        "description": (cls.__doc__ or "").partition("\n")[0],
        "properties": {member.wire: _member(member) for member in shape.members},
        "additionalProperties": False,
    }
    if required := [member.wire for member in shape.members if member.required]:
        schema["required"] = required
    return schema


def _add(cls: type[Record], definitions: dict[str, Schema]) -> None:
    for member in shape_of(cls).members:
        if member.record is not None and member.record.__name__ not in definitions:
            definitions[member.record.__name__] = _record(member.record)
            _add(member.record, definitions)


def json_schemas() -> dict[str, Schema]:
    """Return the schema of each document by its name.

    As strict as the simulator: unknown fields are refused. Who reads what a later version writes ignores them.
    """
    schemas: dict[str, Schema] = {}
    for name, cls in NAMES.items():
        definitions: dict[str, Schema] = {}
        _add(cls, definitions)
        schemas[name] = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": name, **_record(cls)}
        if definitions:
            schemas[name]["$defs"] = dict(sorted(definitions.items()))
    return schemas
