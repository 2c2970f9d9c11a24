"""Drawings: walls from outlines, lines and arcs, doors from blocks, and what is left out or refused."""

from __future__ import annotations

import io
import math
from typing import Any

import ezdxf
import pytest

from intellwheels_maps.check import check_map
from intellwheels_maps.importers import Imported
from intellwheels_maps.importers.dxf_plan import LINE
from intellwheels_schemas.errors import WireError
from tests.maps.importers.drawn_floors import area_of, drawn, read, refusal, write_dxf

WALL = {"layer": "A-WALL"}


def drawing(units: int = 6) -> Any:
    document = ezdxf.new()  # type: ignore[attr-defined]
    document.header["$INSUNITS"] = units
    return document


def imported(document: Any) -> Imported:
    text = io.StringIO()
    document.write(text)
    return read({"plan.dxf": text.getvalue().encode()})


def test_two_lines_are_the_faces_of_a_wall_and_one_line_is_thin() -> None:
    document = drawing()
    space = document.modelspace()
    for a, b in (((0, 0), (5, 0)), ((5, 0), (5, 0.2)), ((5, 0.2), (0, 0.2)), ((0, 0.2), (0, 0)), ((0, 3), (5, 3))):
        space.add_line(a, b, dxfattribs=WALL)
    found = imported(document).map
    assert area_of(found).area == pytest.approx(5 * 0.2 + 5 * LINE, abs=1e-3)
    assert [wall.thickness for wall in found.wall] == [None, LINE]


def test_the_outline_of_a_room_is_a_line_and_a_width_is_a_thickness() -> None:
    document = drawing()
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (8, 0), (8, 6), (0, 6)], close=True, dxfattribs=WALL)
    space.add_lwpolyline([(2, 2), (4, 2)], dxfattribs={"layer": "PAREDES", "const_width": 0.3})
    found = imported(document).map
    assert area_of(found).area == pytest.approx(28 * LINE + 2 * 0.3, rel=0.01)


def test_an_arc_is_flattened_to_millimetres() -> None:
    document = drawing()
    document.modelspace().add_arc((0, 0), 4.0, 0, 90, dxfattribs=WALL)
    (wall,) = imported(document).map.wall
    distances = [math.hypot(corner.x, corner.y) for corner in wall.corner]
    assert distances == pytest.approx([4.0] * len(distances), abs=2e-3)
    chords = [math.dist((a.x, a.y), (b.x, b.y)) for a, b in zip(wall.corner, wall.corner[1:], strict=False)]
    assert all(4.0 - math.sqrt(16.0 - (chord / 2) ** 2) < 0.007 for chord in chords)


@pytest.mark.parametrize(("units", "metres"), [(1, 0.0254), (2, 0.3048), (4, 0.001), (5, 0.01), (6, 1.0)])
def test_units_of_the_drawing(units: int, metres: float) -> None:
    document = drawing(units)
    document.modelspace().add_lwpolyline([(0, 0), (5 / metres, 0)], dxfattribs=WALL | {"const_width": 0.1 / metres})
    assert area_of(imported(document).map).bounds == pytest.approx((0.0, -0.05, 5.0, 0.05), abs=1e-4)


def test_blocks_are_expanded_where_they_are_inserted() -> None:
    document = drawing()
    block = document.blocks.new("column")
    block.add_lwpolyline([(0, 0), (0.4, 0), (0.4, 0.4), (0, 0.4)], close=True)
    outer = document.blocks.new("pair")
    outer.add_blockref("column", (0, 0))
    outer.add_blockref("column", (2, 0))
    document.modelspace().add_blockref("pair", (10, 5), dxfattribs={"layer": "S-COLS", "rotation": 90.0})
    found = imported(document).map
    assert area_of(found).area == pytest.approx(2 * 0.16)
    assert area_of(found).bounds == pytest.approx((9.6, 5.0, 10.0, 7.4))


def test_two_leaves_that_meet_are_one_door() -> None:
    document = drawing()
    space = document.modelspace()
    for a, b in (((0, 0), (4, 0)), ((6, 0), (9, 0))):
        space.add_lwpolyline([a, b], dxfattribs=WALL | {"const_width": 0.1})
    space.add_arc((4, 0), 1.0, 0, 90, dxfattribs={"layer": "doors"})
    space.add_arc((6, 0), 1.0, 90, 180, dxfattribs={"layer": "doors"})
    (doorway,) = imported(document).map.doorway
    assert doorway.door is not None
    assert (doorway.door.kind, doorway.width) == ("double-hinged", 2.0)
    # Both leaves open towards +y.
    assert math.sin(math.radians(doorway.heading_deg)) * doorway.door.swing_deg > 0


def test_a_glass_wall_is_open_where_a_door_is_drawn_on_it() -> None:
    document = drawing()
    space = document.modelspace()
    space.add_line((0, 0), (9, 0), dxfattribs={"layer": "windows line"})
    space.add_arc((4, 0), 1.0, 0, 90, dxfattribs={"layer": "doors"})
    found = imported(document).map
    assert area_of(found).area == pytest.approx(8 * LINE)
    (doorway,) = found.doorway
    assert (doorway.x, doorway.y, doorway.width) == (4.5, 0.0, 1.0)


def test_a_window_block_closes_its_opening() -> None:
    document = drawing()
    block = document.blocks.new("wind 1400")
    block.add_line((0, 0), (1.4, 0))
    block.add_line((0, 0.1), (1.4, 0.1))
    document.modelspace().add_blockref("wind 1400", (3, 0), dxfattribs={"layer": "0"})
    assert area_of(imported(document).map).bounds == pytest.approx((3.0, 0.0, 4.4, 0.1))


def test_what_is_not_known_is_counted_by_layer() -> None:
    document = drawing()
    space = document.modelspace()
    space.add_line((0, 0), (3, 0), dxfattribs=WALL)
    for number in range(7):
        space.add_line((number, 1), (number, 2), dxfattribs={"layer": "Furniture"})
    space.add_text("hall", dxfattribs={"layer": "A-WALL"})
    found = imported(document)
    assert found.left_out == (
        "layer 'A-WALL': TEXT, not known as walls, windows or doors",
        "layer 'Furniture': LINE, not known as walls, windows or doors: 7",
    )
    assert found.things == 8
    assert check_map(found.map) == []


def test_wrong_units_are_refused() -> None:
    document = drawing(0)
    document.modelspace().add_line((0, 0), (5, 0), dxfattribs=WALL)
    with pytest.raises(WireError, match=r"plan\.dxf: \$INSUNITS: expected the unit of the drawing, got none"):
        imported(document)
    document.header["$INSUNITS"] = 7  # kilometres
    document.modelspace().add_line((0, 0), (500, 0), dxfattribs=WALL)
    with pytest.raises(WireError, match=r"expected at most 9,000 m across, got 500,000 x 0 m; are the units right\?"):
        imported(document)


def test_a_drawing_without_walls_is_refused() -> None:
    with pytest.raises(WireError, match=r"plan\.dxf: expected at least one wall, got none"):
        imported(drawing())


def test_binary_and_damaged_drawings_are_refused() -> None:
    with pytest.raises(WireError, match=r"plan\.dxf: expected DXF as text, got a binary one"):
        read({"plan.dxf": b"AutoCAD Binary DXF\r\n\x1a\x00"})
    data = write_dxf(drawn(1))["floor.dxf"]
    for at in range(100, len(data), len(data) // 12):
        damaged = data[:at] + b"\xff\x00ZZ\n" + data[at + 40 :]
        error = refusal({"plan.dxf": damaged})
        assert error is None or error.startswith("plan.dxf: ")


def test_lines_that_all_cross_are_refused_before_they_are_cut() -> None:
    document = drawing()
    space = document.modelspace()
    for number in range(700):
        space.add_line((number / 10, 0), (number / 10, 70), dxfattribs=WALL)
        space.add_line((0, number / 10), (70, number / 10), dxfattribs=WALL)
    with pytest.raises(WireError, match="expected at most 300,000 crossings of lines on wall layers, got more"):
        imported(document)
