"""What holds for every format: floors that are written are read again, and hostile files are refused."""

from __future__ import annotations

import math
from importlib.util import find_spec

import pytest

from intellwheels_maps import importers
from intellwheels_maps.check import check_map
from intellwheels_maps.importers import FloorSource, import_floor
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Doorway
from tests.maps.importers import drawn_floors as floors
from tests.maps.importers.drawn_floors import DrawnDoor, DrawnFloor, Point, Write

FLOORS = [range(20), pytest.param(range(20, 60), marks=pytest.mark.soak)]
"""Seeds of the floors of the suite, and the others."""
needs_ifc = pytest.mark.skipif(find_spec("ifcopenshell") is None, reason="needs the extra ifc")

WRITERS = [
    pytest.param(floors.write_ros, (0.0, 0.0), floors.CELL, id="ros"),
    pytest.param(floors.write_rmf, (0.0, 0.0), 1e-3, id="rmf"),
    pytest.param(floors.write_dxf, (0.0, 0.0), 1e-3, id="dxf"),
    pytest.param(floors.write_geojson, None, 1e-3, id="geojson"),
    pytest.param(floors.write_lab, (20.0, 20.0), 1e-3, id="lab"),
    pytest.param(floors.write_ifc, (0.0, 0.0), 1e-3, id="ifc", marks=needs_ifc),
]
"""The writer of each format, by how much it moves the floor (None: to its south west corner), and its resolution."""


@pytest.mark.parametrize("seeds", FLOORS, ids=["few", "many"])
@pytest.mark.parametrize(("write", "shift", "resolution"), WRITERS)
def test_floors_that_are_written_are_read_again(
    write: Write, shift: Point | None, resolution: float, seeds: range
) -> None:
    import shapely

    for seed in seeds:
        floor = floors.drawn(seed)
        found = floors.read(write(floor)).map
        assert check_map(found) == []
        wanted = floor.area()
        move = (-wanted.bounds[0], -wanted.bounds[1]) if shift is None else shift
        area = floors.area_of(found)
        if write is floors.write_lab:  # its border is not part of the floor that was drawn
            area = shapely.intersection(area, shapely.box(0.0, 0.0, 60.0, 60.0))
        difference = shapely.symmetric_difference(shapely.affinity.translate(wanted, *move), area)
        assert floors.thickest(difference, resolution) <= resolution / 2, seed
        if write is floors.write_ros:
            assert area.area == pytest.approx(wanted.area, rel=1e-8)
        if write in (floors.write_rmf, floors.write_dxf, floors.write_ifc, floors.write_geojson):
            check_doors(found.doorway, floor, move, leaves=write is not floors.write_geojson)
        if write in (floors.write_rmf, floors.write_geojson, floors.write_lab):
            places = [(place.x, place.y) for place in found.grid.position if "beacon" not in place.kinds]  # type: ignore[union-attr]
            expected = [(x + move[0], y + move[1]) for x, y in map(floor.turned, floor.places)]
            assert [value for at in places for value in at] == pytest.approx(
                [value for at in expected for value in at], abs=resolution
            )


def check_doors(found: tuple[Doorway, ...], floor: DrawnFloor, move: Point, *, leaves: bool) -> None:
    """Check that doorways are where doors were drawn, as wide, with the same hinge and the same open leaf."""
    assert len(found) == len(floor.doors)

    def middle(door: DrawnDoor) -> Point:
        x, y = floor.turned(((door.left[0] + door.right[0]) / 2, (door.left[1] + door.right[1]) / 2))
        return x + move[0], y + move[1]

    for door in floor.doors:
        doorway = min(found, key=lambda one: math.dist((one.x, one.y), middle(door)))
        assert math.dist((doorway.x, doorway.y), middle(door)) < 2e-3
        assert doorway.width == pytest.approx(math.dist(door.left, door.right), abs=2e-3)
        if not leaves:
            continue
        assert doorway.door is not None
        assert doorway.door.kind == "hinged"
        # Compared as where the hinge is and where the tip of the open leaf is.
        hinge, tip = leaf_of(doorway)
        (hx, hy), (ox, oy) = floor.turned(door.left), floor.turned(door.right)
        turn = math.copysign(math.pi / 2, door.swing)
        dx, dy = ox - hx, oy - hy
        expected = hx + dx * math.cos(turn) - dy * math.sin(turn), hy + dx * math.sin(turn) + dy * math.cos(turn)
        assert math.dist(hinge, (hx + move[0], hy + move[1])) < 5e-3
        assert math.dist(tip, (expected[0] + move[0], expected[1] + move[1])) < 5e-3


def leaf_of(doorway: Doorway) -> tuple[Point, Point]:
    """Return where the hinge of a doorway's leaf is, and where its tip is when it is open."""
    assert doorway.door is not None
    heading = math.radians(doorway.heading_deg)
    side = 1.0 if doorway.door.side == "left" else -1.0
    half = doorway.width / 2
    hinge = doorway.x - math.sin(heading) * side * half, doorway.y + math.cos(heading) * side * half
    ahead = math.copysign(doorway.width, doorway.door.swing_deg)
    return hinge, (hinge[0] + math.cos(heading) * ahead, hinge[1] + math.sin(heading) * ahead)


@pytest.mark.parametrize(("write", "shift", "resolution"), WRITERS)
def test_a_file_that_is_cut_anywhere_is_refused_or_read(write: Write, shift: Point | None, resolution: float) -> None:
    files = write(floors.drawn(1))
    name = next(iter(files))
    data = files[name]
    refused = 0
    for part in range(12):
        files[name] = data[: len(data) * part // 12]
        error = floors.refusal(files)
        refused += error is not None
        assert error is None or (error.startswith(name) and "expected" in error)
    assert refused >= 6


@pytest.mark.parametrize("ending", importers.ENDINGS)
@pytest.mark.parametrize("data", [b"", b"\x00" * 64, b"\xff\xfe\x00", b"<xml/>", b"{}", b"[]", b"0\nSECTION\n0\nEOF\n"])
def test_a_file_of_something_else_is_refused_by_its_name(ending: str, data: bytes) -> None:
    if ending == ".ifc" and find_spec("ifcopenshell") is None:
        pytest.skip("needs the extra ifc")
    with pytest.raises(WireError, match=r"^floor.*expected"):
        floors.read({f"floor{ending}": data})


def test_without_its_extra_a_format_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("intellwheels_maps.importers.missing_extra", lambda *extras: f"expected the extra {extras[0]}")
    with pytest.raises(WireError, match=r"^a\.ifc: expected the extra ifc"):
        import_floor(FloorSource("a.ifc", b"", lambda _: b""))
    with pytest.raises(WireError, match=r"^a\.yaml: expected the extra floors"):
        import_floor(FloorSource("a.yaml", b"", lambda _: b""))
