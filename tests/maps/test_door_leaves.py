"""The leaves of doors: where they stand, how they open, and which doors get none."""

from __future__ import annotations

import math

import msgspec
import pytest
import shapely

from intellwheels_maps import floor, robot
from intellwheels_maps.check import check_map, check_robot
from intellwheels_maps.door_leaves import Leaves, door_leaves
from intellwheels_maps.starts import boxes_at
from intellwheels_schemas.messages import Corner, Door, DoorKind, Doorway, Map, Side, Wall
from tests.every_case import every_case

MODEL = robot("door")


def corridor(door: Door | None, width: float = 1.0, heading: float = 0.0, *, more: tuple[Wall, ...] = ()) -> Map:
    """Return a wall along y with an opening at the origin, and its doorway."""
    half = width / 2
    walls = tuple(
        Wall(thickness=0.1, corner=(Corner(x=0.0, y=sign * half), Corner(x=0.0, y=sign * 4.0))) for sign in (1, -1)
    )
    doorway = Doorway(name="d", x=0.0, y=0.0, heading_deg=heading, width=width, door=door)
    return Map(format="iw.v1", name="m", wall=(*walls, *more), doorway=(doorway,))


def opened(leaves: Leaves, number: int = 0) -> tuple[float, float]:
    """Return where the middle of a leaf is when it is open."""
    cast = leaves.cast[number]
    assert leaves.floor.grid is not None
    place = next(one for one in leaves.floor.grid.position if one.name == cast.place)
    options = {option.name: option.value for option in cast.option}
    heading = math.radians(place.heading_deg)
    if "slide" in options:
        way = float(options["slide"])
        return place.x + way * math.cos(heading), place.y + way * math.sin(heading)
    heading += math.radians(float(options["angle"])) * (1 if options["swing"] == "left" else -1)
    body = leaves.robots[cast.robot]
    back = (0.5 - (body.center or 0.0)) * (body.length or 0.0)
    return place.x + back * math.cos(heading), place.y + back * math.sin(heading)


@every_case("heading", [0.0, 180.0])
@every_case("side", ["left", "right"])
@every_case("swing", [90.0, -90.0])
def test_a_hinged_leaf_opens_to_its_side(heading: float, side: Side, swing: float) -> None:
    leaves = door_leaves(corridor(Door(side=side, swing_deg=swing), heading=heading), MODEL)
    x, y = opened(leaves)
    ahead = 1.0 if (swing > 0) == (heading == 0.0) else -1.0
    hinge = 1.0 if (side == "left") == (heading == 0.0) else -1.0
    assert x == pytest.approx(ahead * 0.44, abs=0.01)
    assert y == pytest.approx(hinge * 0.44, abs=0.01)


@pytest.mark.parametrize(
    ("kind", "middles"),
    [
        ("hinged", [(0.435, 0.44)]),
        ("double-hinged", [(0.205, 0.44), (0.205, -0.44)]),
        ("sliding", [(-0.13, 1.0)]),
        ("double-sliding", [(-0.13, 0.79), (-0.13, -0.79)]),
    ],
)
def test_kinds_of_doors(kind: DoorKind, middles: list[tuple[float, float]]) -> None:
    leaves = door_leaves(corridor(Door(kind=kind)), MODEL)
    assert len(leaves.cast) == len(middles)
    for number, middle in enumerate(middles):
        x, y = opened(leaves, number)
        assert (abs(x), y) == pytest.approx((abs(middle[0]), middle[1]), abs=0.02)
    assert check_map(leaves.floor) == []
    assert all(check_robot(body) == [] for body in leaves.robots.values())
    assert all(body.anchored == ("hinged" in kind) for body in leaves.robots.values())


def test_sensors_keep_their_places_on_the_leaf() -> None:
    leaves = door_leaves(corridor(Door(), width=0.6), MODEL)
    (leaf,) = leaves.robots.values()
    assert leaf.length == 0.5
    assert [sensor.id for sensor in leaf.proximity] == [sensor.id for sensor in MODEL.proximity]
    assert all(abs(sensor.x) <= 0.5 and abs(sensor.y) == pytest.approx(0.025) for sensor in leaf.proximity[:4])


@pytest.mark.parametrize(
    ("door", "width", "text"),
    [
        (Door(), 0.4, "expected at least 0.5 m for a door, got 0.4 m"),
        (Door(swing_deg=5.0), 1.0, "expected a swing of 10 to 180 degrees, got 5"),
        (Door(kind="sliding"), 4.5, "expected room beside the wall for a leaf that slides 4.50 m, got none"),
    ],
)
def test_a_door_that_can_have_no_leaf_is_named(door: Door, width: float, text: str) -> None:
    # Walls across, at both ends of the wall with the opening.
    ends = tuple(Wall(thickness=0.1, corner=(Corner(x=-3.0, y=y), Corner(x=3.0, y=y))) for y in (4.0, -4.0))
    leaves = door_leaves(corridor(door, width, more=ends), MODEL)
    assert leaves.cast == ()
    assert leaves.left_out == (f"doorway 'd': {text}",)


def test_a_doorway_without_a_door_has_no_leaf() -> None:
    ward = floor("ward")
    assert door_leaves(ward, MODEL) == Leaves(ward, (), {}, ())


def test_leaves_stand_clear_of_walls_and_of_one_another() -> None:
    ward = floor("ward")
    doors = tuple(
        msgspec.structs.replace(doorway, door=Door(kind="double-hinged" if number % 2 else "hinged"))
        for number, doorway in enumerate(ward.doorway)
    )
    leaves = door_leaves(msgspec.structs.replace(ward, doorway=doors), MODEL)
    assert leaves.left_out == ()
    assert leaves.floor.grid is not None
    places = {place.name: place for place in leaves.floor.grid.position}
    boxes = [
        shapely.Polygon(corners)
        for cast in leaves.cast
        for corners, _, _ in boxes_at(leaves.robots[cast.robot], places[str(cast.place)])
    ]
    assert not any(one.intersects(other) for at, one in enumerate(boxes) for other in boxes[:at])
