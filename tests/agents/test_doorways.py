"""The doorways of two rooms and of whole floors, and which of them leads to a goal."""

from __future__ import annotations

import math
import os
from pathlib import Path

import msgspec
import pytest

from intellwheels_agents import doorways as module
from intellwheels_agents.doorways import doorways, near_wall, way_through
from intellwheels_maps import floor
from intellwheels_maps.hospital import CORRIDOR, hospital
from intellwheels_schemas.messages import Corner, Doorway, Map, Obstacle
from tests.agents.person_trials import two_rooms

PUBLIC = Path(os.environ.get("PUBLIC_FLOORS", "/work/shared/floors"))


@pytest.mark.parametrize("width", [0.8, 0.9, 1.0])
def test_door_between_two_rooms_is_found_once_in_the_middle_of_the_wall(width: float) -> None:
    ((door,), edges) = doorways(two_rooms(width))
    assert (door.x, door.y) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert (abs(door.ux), door.uy) == pytest.approx((1.0, 0.0))
    assert door.width == pytest.approx(width)
    assert set(door.walls) <= set(edges)


@pytest.mark.parametrize("name", ["crossing", "corner", "square", "corridor15m"])
def test_streets_and_wide_corridors_have_no_doorways(name: str) -> None:
    assert doorways(floor(name))[0] == ()


@pytest.mark.parametrize(
    ("here", "goal", "across"),
    [
        ((-3.0, 0.0), (7.0, 0.0), 1.0),
        ((-3.0, 1.8), (7.0, 1.8), 1.0),
        ((3.0, 1.0), (-5.0, 2.0), -1.0),
        ((-2.0, 0.0), (0.0, 0.1), 1.0),
        ((-3.0, 1.8), (-1.0, -2.0), None),
    ],
)
def test_doorway_leads_to_a_goal_in_the_other_room(
    here: tuple[float, float], goal: tuple[float, float], across: float | None
) -> None:
    doors, edges = doorways(two_rooms(0.9))
    found = way_through(doors, edges, here, goal)
    assert (None if found is None else found.ux) == across


def of_every_declared_one(document: Map) -> list[module.Doorway]:
    """Return the doorways found where the map declares some; each is found once."""
    found, _ = doorways(document)
    places = [(one.x, one.y) for one in document.doorway]
    near = [[one for one in found if math.dist((one.x, one.y), place) < module.SAME] for place in places]
    assert {len(ones) for ones in near} == {1}
    return [ones[0] for ones in near]


def test_every_doorway_of_the_hospital_is_found_and_leads_from_the_corridor_to_its_room() -> None:
    document = hospital(1)
    doors, edges = doorways(document)
    assert of_every_declared_one(document) == list(doors)
    assert document.grid is not None
    places = {place.name: (place.x, place.y) for place in document.grid.position}
    for declared in document.doorway[::10]:
        out = math.radians(declared.heading_deg) + math.pi
        here = (declared.x + CORRIDOR / 2.0 * math.cos(out), declared.y + CORRIDOR / 2.0 * math.sin(out))
        door = way_through(doors, edges, here, places[f"{declared.name}-5"])
        assert door is not None
        assert (door.x, door.y, door.width) == (declared.x, declared.y, declared.width)
        assert door.ux * math.cos(out) + door.uy * math.sin(out) == pytest.approx(-1.0)


def test_every_doorway_of_the_ward_is_found_once() -> None:
    document = floor("ward")
    assert [one.width for one in of_every_declared_one(document)] == [one.width for one in document.doorway]


@pytest.mark.skipif(not PUBLIC.is_dir(), reason="needs the public floors in the folder PUBLIC_FLOORS")
@pytest.mark.parametrize(
    ("file", "declared", "found"), [("rmf_hotel.building.yaml", 5, 5), ("westport1.geojson", 11, 23)]
)
def test_doorways_of_imported_floors_are_found(file: str, declared: int, found: int) -> None:
    document = floor(str(PUBLIC / file))
    assert len(of_every_declared_one(document)) == declared
    assert len(doorways(document)[0]) == found


def test_declared_doorway_that_is_blocked_or_too_narrow_is_no_way() -> None:
    def declared(width: float, *rings: list[tuple[float, float]]) -> Map:
        door = Doorway(name="d", x=0.0, y=0.0, heading_deg=0.0, width=width)
        return msgspec.structs.replace(_with_obstacles(two_rooms(width), *rings), doorway=(door,))

    assert len(doorways(declared(1.4))[0]) == 1
    assert doorways(declared(1.4, [(-0.1, -0.2), (0.1, -0.2), (0.1, 0.2), (-0.1, 0.2)]))[0] == ()
    assert doorways(declared(0.55))[0] == ()


def test_frame_of_a_doorway_and_that_of_the_map_convert_into_each_other() -> None:
    doors, edges = doorways(two_rooms(0.9))
    door = way_through(doors, edges, (3.0, 1.0), (-5.0, 2.0))
    assert door is not None
    assert door.local(3.0, 1.0) == pytest.approx((-3.0, -1.0))
    assert door.on_map(*door.local(3.0, 1.0)) == pytest.approx((3.0, 1.0))


def test_point_beside_a_jamb_is_near_a_wall_and_one_in_the_doorway_is_not() -> None:
    ((door,), _) = doorways(two_rooms(0.9))
    assert near_wall(door.walls, 0.0, 0.4, 0.1)
    assert not near_wall(door.walls, 0.0, 0.0, 0.1)


def _with_obstacles(document: Map, *rings: list[tuple[float, float]]) -> Map:
    obstacles = (
        Obstacle(name=f"o{k}", top=2.0, corner=tuple(Corner(x=x, y=y) for x, y in ring)) for k, ring in enumerate(rings)
    )
    return Map(format="iw.v1", name="obstacles", wall=document.wall, obstacle=tuple(obstacles))


def test_corners_that_are_nearly_the_same_are_no_trouble() -> None:
    """The square of the length of an edge between them is 0."""
    walls = two_rooms(0.9)
    ((door,), _) = doorways(_with_obstacles(walls, [(0.0, 1.5), (1e-170, 1.5), (0.0, 1.6), (-0.1, 1.6)]))
    assert (door.x, door.y) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_gaps_within_pillars_cost_little_on_a_map_of_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each pair of corners of a round pillar is a gap; it is compared with the walls beside it only."""
    pillars = [
        [(3.0 * k + math.cos(math.tau * n / 24) / 2.0, 9.0 + math.sin(math.tau * n / 24) / 2.0) for n in range(24)]
        for k in range(10)
    ]
    calls = 0
    plain = module._distance

    def counted(edge: module.Edge, x: float, y: float) -> float:
        nonlocal calls
        calls += 1
        return plain(edge, x, y)

    monkeypatch.setattr(module, "_distance", counted)
    found, edges = doorways(_with_obstacles(two_rooms(0.9), *pillars))
    assert any((one.x, one.y) == pytest.approx((0.0, 0.0), abs=1e-9) for one in found)
    assert calls < 100 * len(edges)
