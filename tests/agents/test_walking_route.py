"""Ways around the walls of a map."""

from __future__ import annotations

import itertools
import math

import pytest

from intellwheels_agents.walking_route import NARROW, WalkingRoute
from intellwheels_maps import floor
from intellwheels_schemas.messages import Corner, Map, Wall
from tests.agents.person_trials import two_rooms


def length(start: tuple[float, float], way: list[tuple[float, float]]) -> float:
    return sum(math.dist(a, b) for a, b in itertools.pairwise([start, *way]))


def test_goal_in_sight_is_walked_to_straight() -> None:
    assert WalkingRoute(two_rooms(0.9)).way((-2.0, 0.0), (2.0, 0.1)) == [(2.0, 0.1)]
    assert WalkingRoute(Map(format="iw.v1", name="empty")).way((0.0, 0.0), (9.0, 9.0)) == [(9.0, 9.0)]


@pytest.mark.parametrize("width", [0.8, 0.9, 1.0])
@pytest.mark.parametrize("start", [(-0.5, 2.0), (-4.0, -1.8)])
def test_way_to_another_room_leads_through_the_door(width: float, start: tuple[float, float]) -> None:
    route = WalkingRoute(two_rooms(width))
    way = route.way(start, (7.0, 2.0))
    assert way[-1] == (7.0, 2.0)
    assert length(start, way) < math.dist(start, (0.0, 0.0)) + math.dist((0.0, 0.0), (7.0, 2.0)) + 0.3
    found = [route.passage(a, b, 5.0) for a, b in itertools.pairwise([start, *way])]
    assert any(through is not None and math.dist(through, (0.0, 0.0)) < 0.2 for through in found)


def test_wide_opening_is_no_passage() -> None:
    assert WalkingRoute(two_rooms(2.0)).passage((-1.0, 0.0), (1.0, 0.0), 5.0) is None


def test_way_on_the_ward_is_short_and_clear_of_walls() -> None:
    document = floor("ward")
    assert document.grid
    places = {place.name: (place.x, place.y) for place in document.grid.position}
    route = WalkingRoute(document)
    start, goal = places["room2-a"], places["room4-a"]
    way = route.way(start, goal)
    assert len(way) > 1
    assert length(start, way) < 2.0 * math.dist(start, goal)
    for a, b in itertools.pairwise(way[:-1]):
        assert route.clear(a, b, NARROW)


def test_goal_that_cannot_be_reached_is_walked_to_straight() -> None:
    corners = tuple(Corner(x=x, y=y) for x, y in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)))
    route = WalkingRoute(Map(format="iw.v1", name="box", wall=(Wall(corner=corners, thickness=0.1),)))
    assert route.way((0.0, 0.0), (5.0, 0.0)) == [(5.0, 0.0)]


def test_beam_over_the_head_is_no_wall() -> None:
    beam = Wall(corner=(Corner(x=0.0, y=-1.0), Corner(x=0.0, y=1.0)), thickness=0.1, bottom=2.0)
    route = WalkingRoute(Map(format="iw.v1", name="beam", wall=(beam,)))
    assert route.way((-1.0, 0.0), (1.0, 0.0)) == [(1.0, 0.0)]
    assert not route.on_wall((0.0, 0.0))


def test_solid_pillar_is_walked_around() -> None:
    pillar = Wall(corner=tuple(Corner(x=x, y=y) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))))
    route = WalkingRoute(Map(format="iw.v1", name="pillar", wall=(pillar,)))
    way = route.way((-2.0, 0.1), (2.0, 0.1))
    assert len(way) >= 2
    assert length((-2.0, 0.1), way) < 5.0
    assert route.on_wall((0.5, 0.1))
