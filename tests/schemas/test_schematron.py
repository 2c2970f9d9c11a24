from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree

from tests.every_case import every_case
from tests.schemas.documents import GROWN, REFUSED, ROOT, rules, vectors, xsd


@every_case("path", [*vectors("xml"), *sorted(GROWN.glob("*.xml"))], ids=lambda path: path.name)
def test_every_vector_fulfils_the_rules(path: Path) -> None:
    assert rules().validate(etree.parse(str(path)))


def test_shipped_files_fulfil_the_rules() -> None:
    for path in (ROOT / "maps").rglob("*.xml"):
        assert rules().validate(etree.parse(str(path))), path


@every_case(
    "name",
    [
        "Actions-tick-space.xml", "Robot-parts.xml", "Robot-sensors.xml", "Robot-id-twice.xml", "Robot-ranges.xml",
        "Robot-part-flat.xml", "Robot-both-forms.xml", "Robot-file-with-name.xml", "Robot-mind-with-part.xml",
        "Robot-position-twice.xml", "Measures-lidar-lengths.xml", "Pose-covariance.xml", "Map-wall-line.xml",
        "Map-grid-twice.xml", "Map-wall-under.xml", "Scene-cast-twice.xml", "Scene-reach-nobody.xml",
        "Scene-experiment-no-row.xml",
    ],
)  # fmt: skip
def test_rules_refuse_what_the_xml_schema_lets_pass(name: str) -> None:
    document = etree.parse(str(REFUSED / name))
    assert xsd("writer/iw.xsd").validate(document)
    assert not rules().validate(document)


@pytest.mark.parametrize(
    "text",
    [
        '<Robot Role="mind" TopSpeed="0" Anchored="false"/>',
        '<Robot Length="1" Width="1"><Proximity Id="a" X="0" Y="0" Z="0" DirectionDeg="0" ConeDeg="9" MinRange="1E-2" '
        'MaxRange="4"/></Robot>',
        '<Pose X="0" Y="0" Heading="0" Covariance=" 1 0 0  1 0 1 "/>',
    ],
)
def test_rules_let_pass_what_the_simulator_takes(text: str) -> None:
    assert rules().validate(etree.fromstring(text))
