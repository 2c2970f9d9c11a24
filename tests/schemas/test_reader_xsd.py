from __future__ import annotations

from pathlib import Path

import pytest
import xmlschema
from lxml import etree

from tests.every_case import every_case
from tests.schemas.documents import GROWN, REFUSED, SCHEMAS, class_name, vectors, xsd


@every_case("path", [*vectors("xml"), *sorted(GROWN.glob("*.xml"))], ids=lambda path: path.name)
def test_every_vector_is_valid_also_with_unknown_fields(path: Path) -> None:
    schema = xsd(f"reader/{class_name(path)}.xsd")
    assert schema.validate(etree.parse(str(path))), schema.error_log


@pytest.mark.parametrize("path", sorted(GROWN.glob("*.xml")), ids=lambda path: path.name)
def test_another_validator_agrees(path: Path) -> None:
    assert xmlschema.XMLSchema10(SCHEMAS / "xsd" / "reader" / f"{class_name(path)}.xsd").is_valid(path)


@pytest.mark.parametrize("path", sorted(GROWN.glob("*.xml")), ids=lambda path: path.name)
def test_unknown_fields_pass_no_writer(path: Path) -> None:
    assert not xsd("writer/iw.xsd").validate(etree.parse(str(path)))


def test_unknown_fields_pass_at_every_depth_and_known_ones_are_checked() -> None:
    text = (SCHEMAS / "vectors" / "Measures.xml").read_text(encoding="utf-8")
    grown = text.replace('Value="1.25"/>', 'Value="1.25" Colour="red"><Echo At="2"/></Proximity><Sniffer Id="nose"/>')
    assert grown != text
    assert xsd("reader/Measures.xsd").validate(etree.fromstring(grown))
    assert not xsd("reader/Measures.xsd").validate(etree.fromstring(grown.replace("1.25", "far")))


@pytest.mark.parametrize(
    "name", ["Actions-left-motor-word.xml", "Actions-goal-half.xml", "Robot-cone-zero.xml", "Robot-no-id.xml"]
)
def test_wrong_known_fields_are_invalid(name: str) -> None:
    assert not xsd(f"reader/{class_name(REFUSED / name)}.xsd").validate(etree.parse(str(REFUSED / name)))
