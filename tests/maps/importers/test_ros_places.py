"""The list of places and doorways beside a ROS map: the way back of an export, and what is left out of it."""

from __future__ import annotations

import msgspec
import pytest

from intellwheels_maps import floor, names
from intellwheels_maps.check import check_map
from intellwheels_maps.importers import Imported
from intellwheels_maps.ros_export import export_ros
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Corner, Door, DoorKind, Doorway, Grid, Map, Place, Side, SiteOffset, Wall
from tests.every_case import every_case
from tests.maps.importers.drawn_floors import read

CELL = 0.05


def again(document: Map, places: str | None = None) -> Imported:
    """Return what is imported of an exported map, with another list of places if one is given."""
    files = export_ros(document, CELL, "m.pgm")
    listed = (files.places if places is None else places).encode()
    return read({"m.yaml": files.head.encode(), "m.pgm": files.image, "m.places.yaml": listed})


@every_case("name", names("floors"))
def test_places_and_doors_come_back(name: str) -> None:
    document = floor(name)
    found = again(document)
    assert found.left_out == ()
    assert check_map(found.map) == []
    assert found.map.grid == document.grid
    assert [doorway.name for doorway in found.map.doorway] == [doorway.name for doorway in document.doorway]
    for doorway, before in zip(found.map.doorway, document.doorway, strict=True):
        assert (doorway.door, doorway.heading_deg) == (before.door, before.heading_deg)
        # The walls are cells: the opening has a whole number of them.
        assert doorway.width == pytest.approx(before.width, abs=CELL + 1e-6)
        assert (doorway.x, doorway.y) == pytest.approx((before.x, before.y), abs=CELL / 2 + 1e-6)


def corridor(offset: SiteOffset | None = None) -> Map:
    """Return two walls with a gap of 1 m, a doorway in it, and a place."""
    walls = tuple(
        Wall(thickness=0.2, corner=(Corner(x=west, y=0.0), Corner(x=west + 4.0, y=0.0))) for west in (0.0, 5.0)
    )
    doorway = Doorway(name="d", x=4.5, y=0.0, heading_deg=90.0, width=1.0)
    grid = Grid(position=(Place(name="p", x=1.0, y=1.0, heading_deg=180.0),))
    return Map(format="iw.v1", name="m", wall=walls, doorway=(doorway,), grid=grid, offset=offset)


@every_case("swing", [90.0, -120.0])
@every_case("side", ["left", "right"])
@every_case("kind", ["hinged", "double-hinged", "sliding", "double-sliding"])
def test_every_door_comes_back(kind: DoorKind, side: Side, swing: float) -> None:
    before = corridor()
    door = Door(kind=kind, side=side, swing_deg=swing)
    doorways = tuple(msgspec.structs.replace(doorway, door=door) for doorway in before.doorway)
    assert again(msgspec.structs.replace(before, doorway=doorways)).map.doorway == doorways


def test_a_far_site_has_the_same_places() -> None:
    found = again(corridor(SiteOffset(x=600_000.0, y=4_500_000.0))).map
    assert found.offset is not None
    assert found.grid is not None
    (place,), (doorway,) = found.grid.position, found.doorway
    assert (found.offset.x + place.x, found.offset.y + place.y, place.heading_deg) == (600_001.0, 4_500_001.0, 180.0)
    assert found.offset.x + doorway.x == pytest.approx(600_004.5)


def test_a_map_without_the_list_has_none() -> None:
    files = export_ros(corridor(), CELL, "m.pgm")
    found = read({"m.yaml": files.head.encode(), "m.pgm": files.image})
    assert (found.map.grid, found.map.doorway, found.left_out) == (None, (), ())


@every_case(
    ("listed", "left_out"),
    [
        ("places: [", "m.places.yaml: line 2: expected YAML, got "),
        ("- 3", "m.places.yaml: expected keys and values, got a list"),
        ("rooms: []", "m.places.yaml: 'rooms': key that is not known"),
        ("places: 3", "m.places.yaml: places: expected a list, got 3"),
        ("places: [p]", "m.places.yaml: places[0]: expected keys and values, got 'p'"),
        ("places: [{x: 1, y: 1}]", "m.places.yaml: places[0]: name: expected a name, got null"),
        ("places: [{name: p, x: 1}]", "m.places.yaml: places[0]: y: expected a number in [-1e+08, 1e+08], got null"),
        ("places: [{name: p, x: .nan, y: 1}]", "m.places.yaml: places[0]: x: expected a number"),
        ("places: [{name: p, x: true, y: 1}]", "m.places.yaml: places[0]: x: expected a number"),
        ("places: [{name: p, x: 1, y: 1, yaw: .inf}]", "m.places.yaml: places[0]: yaw: expected a number"),
        ("places: [{name: p, x: 1, y: 1, kinds: [a b]}]", "m.places.yaml: places[0]: kinds: expected a list of words"),
        (
            "places: [{name: p, x: 1, y: 1, z: 1}]",
            "m.places.yaml: places[0]: expected the keys name, x, y, yaw, kinds,",
        ),
        ("places: [{name: p, x: 1, y: 0}]", "m.places.yaml: places[0]: place inside a wall"),
        ("doorways: [{name: d, x: 4.5, y: 0, width: 0}]", "m.places.yaml: doorways[0]: width: expected a number"),
        (
            "doorways: [{name: d, x: 4.5, y: 0, yaw: 1.57, width: 1, door: iris}]",
            "m.places.yaml: doorways[0]: door: expected one of hinged, double-hinged, sliding, double-sliding",
        ),
        (
            "doorways: [{name: d, x: 4.5, y: 3, yaw: 1.57, width: 1}]",
            "m.places.yaml: doorways[0]: doorway without a wall on each side",
        ),
    ],
)
def test_what_cannot_be_read_is_left_out(listed: str, left_out: str) -> None:
    found = again(corridor(), f"{listed}\n")
    (line,) = found.left_out
    assert line.startswith(left_out)
    assert (len(found.map.wall), found.map.grid, found.map.doorway) == (2, None, ())


def test_a_list_that_is_too_long_to_be_read_is_left_out() -> None:
    files = export_ros(corridor(), CELL, "m.pgm")
    found = read({"m.yaml": files.head.encode(), "m.pgm": files.image, "m.places.yaml": b"#" * (17 << 20)})
    assert found.left_out == ("m.places.yaml: expected at most 16,777,216 bytes, got 17,825,792",)


def test_what_can_be_read_is_kept() -> None:
    places = "places: [{name: a, x: 1, y: 1}, {name: b}]"
    doorways = "doorways: [{name: d, x: 4.4, y: 0, yaw: 1.570796, width: 0.9, door: sliding}]"
    found = again(corridor(), f"{places}\n{doorways}\n")
    assert found.map.grid == Grid(position=(Place(name="a", x=1.0, y=1.0),))
    (doorway,) = found.map.doorway
    assert (doorway.x, doorway.width, doorway.door and doorway.door.kind) == (4.5, 1.0, "sliding")
    assert len(found.left_out) == 1


def test_a_wrong_image_is_still_refused() -> None:
    with pytest.raises(WireError, match=r"m\.pgm: expected an image"):
        read(
            {
                "m.yaml": b"image: m.pgm\nresolution: 1\norigin: [0, 0, 0]\n",
                "m.pgm": b"",
                "m.places.yaml": b"places: []",
            }
        )
