"""The vectors, and the schemas that judge them, for the tests of the schemas."""

from __future__ import annotations

import json
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import jsonschema
from lxml import etree

ROOT = Path(__file__).parents[2]
SCHEMAS = ROOT / "schemas"
REFUSED = SCHEMAS / "vectors" / "refused"
GROWN = SCHEMAS / "vectors" / "grown"


def class_name(path: Path) -> str:
    """Return the name of a vector's document."""
    return path.name.replace(".", "-").partition("-")[0]


def vectors(ending: str) -> list[Path]:
    """Return the valid documents."""
    return sorted((SCHEMAS / "vectors").glob(f"*.{ending}"))


@cache
def json_validator(name: str, folder: str) -> Any:
    """Return the JSON Schema of a document, for a `reader` or a `writer`."""
    schema = json.loads((SCHEMAS / "json" / folder / f"{name}.json").read_bytes())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@cache
def xsd(file: str) -> Any:
    """Return the XML Schema of a file below `xsd/`."""
    return etree.XMLSchema(etree.parse(str(SCHEMAS / "xsd" / file)))


@cache
def rules() -> Any:
    """Return the Schematron rules."""
    # The stubs of lxml do not have this module.
    return import_module("lxml.isoschematron").Schematron(etree.parse(str(SCHEMAS / "xsd" / "rules.sch")))


def is_parsed_and_valid(path: Path) -> bool:
    """Return whether a document can be parsed and the schemas for writers find nothing wrong with it."""
    data = path.read_bytes()
    try:
        if path.suffix == ".json":
            return bool(json_validator(class_name(path), "writer").is_valid(json.loads(data.decode())))
        document = etree.fromstring(data)
    except (ValueError, RecursionError, etree.XMLSyntaxError):
        return False
    return bool(xsd("writer/iw.xsd").validate(document) and rules().validate(document))
