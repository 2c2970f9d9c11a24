"""Labs of the ancestor: walls, border, beacons, target, grid, and what is refused."""

from __future__ import annotations

import pytest

from intellwheels_maps.check import check_map
from intellwheels_maps.importers.ciber_lab import is_lab
from intellwheels_schemas.errors import WireError
from tests.maps.importers.drawn_floors import area_of, read

LAB = b"""<?xml version="1.0"?>
<!-- <Map> -->
<Lab Name="Test Lab" Height="14" Width="28">
  <Beacon X="7.5" Y="3.5" Height="2"/>
  <Target X="7.5" Y="3.5" Radius="2"/>
  <Wall Height="3"><Corner X="1" Y="1"/><Corner X="3" Y="1"/><Corner X="3" Y="2"/><Corner X="1" Y="2"/></Wall>
  <Row/>
</Lab>
"""
GRID = b'<Grid>\n<Position X="13" Y="10" Dir="-90"/><Position X="11" Y="10" Dir="45"/></Grid>'


def test_a_lab_and_the_grid_beside_it() -> None:
    found = read({"MyLab.xml": LAB, "MyGrid.xml": GRID})
    document = found.map
    assert check_map(document) == []
    assert document.title == "Test Lab"
    assert area_of(document).bounds == pytest.approx((-0.1, -0.1, 28.1, 14.1))
    assert area_of(document).area == pytest.approx(2.0 + 0.1 * (2 * 28.1 + 2 * 14.1) - 0.01, abs=0.02)
    assert document.wall[1].height == 3.0
    assert document.grid is not None
    assert [(place.name, place.x, place.y, place.heading_deg, place.kinds) for place in document.grid.position] == [
        ("beacon1", 7.5, 3.5, 0.0, ("beacon",)), ("start1", 13.0, 10.0, -90.0, ()), ("start2", 11.0, 10.0, 45.0, ()),
    ]  # fmt: skip
    assert document.zone[0].name == "target"
    assert found.left_out == ("line 7: element Row",)


def test_a_lab_without_a_grid_says_so() -> None:
    assert "start grid" in read({"MyLab.xml": LAB}).left_out[-1]


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        (b'X="3" Y="1"', b'X="three" Y="1"', r"MyLab\.xml: line 6: Corner\.X: expected a number in .*, got 'three'"),
        (b'X="3" Y="1"', b'Y="1"', r"line 6: Corner\.X: expected a number in .*, got none"),
        (b'Height="14"', b'Height="1e9"', r"line 3: Lab\.Height: expected a number in \[0\.1, 5000\]"),
        (b"<Lab ", b'<Lab Format="iw.v1" ', r"MyLab\.xml: expected a lab of the Ciber-Rato .*, got the Lab of"),
        (b"</Lab>", b"", r"MyLab\.xml: line \d: .*expected"),
        (b"<!-- <Map> -->", b'<!DOCTYPE a [<!ENTITY b "c">]>', r"MyLab\.xml: line \d: .*"),
        (b'<Corner X="1" Y="1"/><Corner X="3" Y="1"/>', b"", "expected a wall of at least 3 corners, got 2"),
    ],
)
def test_a_wrong_lab_is_refused_with_its_line(old: bytes, new: bytes, text: str) -> None:
    assert old in LAB
    with pytest.raises(WireError, match=text):
        read({"MyLab.xml": LAB.replace(old, new, 1)})


def test_a_wrong_grid_is_refused_by_its_name() -> None:
    with pytest.raises(WireError, match=r"MyGrid\.xml: line 2: Position\.X: expected a number"):
        read({"MyLab.xml": LAB, "MyGrid.xml": GRID.replace(b'X="13"', b'X="x"')})
    with pytest.raises(WireError, match=r"MyGrid\.xml: expected the root Grid, got 'Map'"):
        read({"MyLab.xml": LAB, "MyGrid.xml": b"<Map/>"})


def test_too_many_elements_are_refused() -> None:
    with pytest.raises(WireError, match="expected at most 50,000 elements, got more"):
        read({"MyLab.xml": LAB.replace(b"<Row/>", b"<Row/>" * 50_001)})


def test_only_the_root_tells_a_lab() -> None:
    assert is_lab(LAB)
    assert is_lab(b"<Lab/>")
    assert not is_lab(b"<!-- <Lab> --><Map/>")
    assert not is_lab(b"<Laboratory/>")
    assert not is_lab(b"")
