"""The doorways of two rooms, and which of them leads to a goal."""

from __future__ import annotations

import pytest

from intellwheels_agents.doorways import doorways, near_wall, way_through
from intellwheels_maps import floor
from tests.agents.person_trials import two_rooms


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
