from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import xmlschema
from lxml import etree

from tests.every_case import every_case
from tests.schemas.documents import REFUSED, ROOT, SCHEMAS, vectors, xsd

FOLDER = SCHEMAS / "xsd" / "writer"


@pytest.fixture(scope="module")
def schemas() -> dict[bool, Any]:
    """The two schemas, by whether the document is an operator's say."""
    return {
        False: xmlschema.XMLSchema10(FOLDER / "iw.xsd"),
        True: xmlschema.XMLSchema10(FOLDER / "operator-say.xsd"),
    }


@every_case("path", vectors("xml"), ids=lambda path: path.name)
def test_every_vector_is_valid(schemas: dict[bool, Any], path: Path) -> None:
    schema = schemas[path.name.startswith("OperatorSay")]
    assert [error.reason for error in schema.iter_errors(path.read_text(encoding="utf-8"))] == []


def test_libxml2_agrees() -> None:
    schema = xsd("writer/iw.xsd")
    for path in vectors("xml"):
        if not path.name.startswith("OperatorSay"):
            assert schema.validate(etree.parse(str(path))), (path.name, schema.error_log)


@pytest.mark.parametrize(
    "name",
    [
        "Actions-left-motor-word.xml", "Actions-left-motor-nan.xml", "Actions-left-motor-plus.xml",
        "Actions-tick-exponent.xml", "Actions-unknown.xml", "Actions-unknown-element.xml", "Actions-say-twice.xml",
        "Actions-stray-text.xml", "Actions-another-root.xml", "Actions-mode-long.xml", "Actions-leave-capital.xml",
        "Actions-say-return.xml", "Robot-cone-zero.xml", "Robot-height.xml", "Robot-file-version.xml",
        "Robot-name-capital.xml", "Robot-user-input.xml", "Robot-rays.xml", "Step-zero.xml", "Teleport-nowhere.xml",
        "Map-no-format.xml",
    ],
)  # fmt: skip
def test_wrong_fields_are_invalid(schemas: dict[bool, Any], name: str) -> None:
    assert not schemas[False].is_valid((REFUSED / name).read_text(encoding="utf-8"))


def test_shipped_files_are_valid(schemas: dict[bool, Any]) -> None:
    for path in (ROOT / "maps").rglob("*.xml"):
        assert [error.reason for error in schemas[False].iter_errors(path)] == [], path
