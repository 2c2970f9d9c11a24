"""Pedestrians: alone, passing each other, avoiding a chair, and in a crowd."""

from __future__ import annotations

import math
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from intellwheels_agents.options import OptionError
from intellwheels_maps import robot, scene
from intellwheels_schemas.messages import Corner, Doorway, Map, Position, Wall
from tests.agents.arena import Arena
from tests.agents.minds.corridor import Corridor, lane_order, weidmann
from tests.agents.person_trials import at_door, two_rooms

SEEDS = [str(seed) for seed in range(1, 21)]
FEW_OR_ALL = [*SEEDS[:2], *(pytest.param(seed, marks=pytest.mark.soak) for seed in SEEDS[2:])]
"""Seeds of the suite, and the others of the soak tests."""
STRETCH = {"MotorNoise": "0.05"}


def corridor(length: float, width: float) -> Map:
    x, y = length + 2.0, width / 2.0 + 0.05
    corners = [(-2.0, -y), (x, -y), (x, y), (-2.0, y), (-2.0, -y)]
    wall = Wall(corner=tuple(Corner(x=x, y=y) for x, y in corners), height=2.5, thickness=0.1)
    return Map(format="iw.v1", name="corridor", wall=(wall,))


def walker(arena: Arena, name: str, start: tuple[float, float], goal: tuple[float, float], **options: str) -> None:
    heading = math.atan2(goal[1] - start[1], goal[0] - start[0])
    options = {"points": f"{goal[0]:.3f} {goal[1]:.3f}"} | STRETCH | options
    arena.join(name, "person", "person", None, options, Position(x=start[0], y=start[1], heading=heading))


def far(arena: Arena, name: str, goal: tuple[float, float]) -> float:
    return math.dist(arena.paths[name][-1][:2], goal)


@pytest.mark.parametrize("seed", SEEDS[:3])
def test_free_walk_has_the_preferred_speed(seed: str) -> None:
    arena = Arena(corridor(30.0, 6.0), seed)
    walker(arena, "one", (0.0, 0.0), (30.0, 0.0))
    arena.run(3.0)
    (x, y, _), began = arena.paths["one"][-1], arena.state.time
    arena.run(15.0)
    speed = math.dist(arena.paths["one"][-1][:2], (x, y)) / (arena.state.time - began)
    assert speed == pytest.approx(1.34, rel=0.02)


@pytest.mark.parametrize("seed", SEEDS[:5])
@pytest.mark.parametrize("aside", [0.0, 0.15, -0.15])
def test_two_people_who_meet_pass_each_other(seed: str, aside: float) -> None:
    arena = Arena(corridor(12.0, 2.4), seed)
    walker(arena, "east", (0.0, 0.0), (12.0, 0.0))
    walker(arena, "west", (12.0, aside), (0.0, aside))
    took = arena.run(
        20.0, lambda arena: far(arena, "east", (12.0, 0.0)) < 0.5 and far(arena, "west", (0.0, aside)) < 0.5
    )
    assert took < 13.0
    assert arena.contacts() == []


@pytest.mark.parametrize("seed", FEW_OR_ALL)
def test_people_get_out_of_the_way_of_a_chair_that_does_not_look(seed: str) -> None:
    rng = np.random.default_rng(int(seed))
    arena = Arena(corridor(20.0, 3.4), seed)
    power = f"{0.5 / robot('rear-wheel').top_speed:.4f}"
    across = float(rng.uniform(-0.4, 0.4))
    at = Position(x=0.0, y=across, heading=0.0)
    arena.join("chair", "drive", "rear-wheel", None, {"left": power, "right": power}, at)
    for i in range(4):
        y = float(rng.uniform(-1.0, 1.0))
        walker(arena, f"to{i}", (6.0 + 3.0 * i + float(rng.uniform(-1.0, 1.0)), y), (-1.2, y))
    y = float(rng.uniform(-0.4, 0.4))
    walker(arena, "behind", (-1.2, y), (20.0, y))
    arena.run(16.0)
    assert arena.contacts() == []
    assert arena.paths["chair"][-1][0] == pytest.approx(8.0, abs=0.3)
    behind = [arena.paths[f"to{i}"][-1][0] < arena.paths["chair"][-1][0] for i in range(4)]
    assert sum(behind) >= 3


@pytest.mark.parametrize("name", ["crossing", "corner"])
@pytest.mark.parametrize("seed", FEW_OR_ALL)
def test_everybody_in_the_scene_arrives_without_contact(name: str, seed: str) -> None:
    document = scene(name)
    arena = Arena.of(document, seed)
    assert document.end
    assert document.end.timeout
    assert arena.setup.floor.grid
    places = {place.name: (place.x, place.y) for place in arena.setup.floor.grid.position}
    left = {reach.agent: reach for reach in document.end.reach}

    def there(arena: Arena) -> bool:
        for agent, reach in list(left.items()):
            if far(arena, agent, places[reach.place]) < reach.within:
                del left[agent]
        return not left

    arena.run(document.end.timeout.seconds, there)
    assert left == {}
    assert arena.contacts() == []


@pytest.mark.parametrize(
    ("density", "length", "settle", "seconds"),
    [(0.5, 6.0, 6.0, 8.0), (1.0, 6.0, 4.0, 6.0), pytest.param(2.0, 4.0, 3.0, 3.0, marks=pytest.mark.soak)],
)
def test_flow_of_a_crowd_is_near_weidmanns(density: float, length: float, settle: float, seconds: float) -> None:
    crowd = Corridor(density, length)
    assert crowd.flow(settle, seconds) == pytest.approx(density * weidmann(density), rel=0.2)


@pytest.mark.soak
@pytest.mark.parametrize("density", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("width", [2.0, 3.0])
def test_flow_of_a_crowd_is_near_weidmanns_for_minutes(density: float, width: float) -> None:
    flows = [Corridor(density, width=width, seed=seed).flow(10.0, 30.0) for seed in (1, 2, 3)]
    assert sum(flows) / len(flows) == pytest.approx(density * weidmann(density), rel=0.2)


def test_lanes_have_order_one_and_a_mixed_crowd_less() -> None:
    across = np.array([-1.0, -1.0, 1.0, 1.0])
    assert lane_order(across, np.array([1.0, 1.0, -1.0, -1.0])) == 1.0
    assert lane_order(across, np.array([1.0, -1.0, 1.0, -1.0])) == 0.0


def apart(*, together: bool) -> float:
    arena = Arena(corridor(30.0, 4.0))
    for name, other, y, speed in (("slow", "fast", 0.4, "0.9"), ("fast", "slow", -0.4, "1.4")):
        walker(arena, name, (0.0, y), (30.0, y), speed=speed, **({"with": other} if together else {}))
    arena.run(18.0)
    return math.dist(arena.paths["slow"][-1][:2], arena.paths["fast"][-1][:2])


def test_companions_stay_together_and_strangers_do_not() -> None:
    assert apart(together=True) < 3.0
    assert apart(together=False) > 6.0


@pytest.mark.parametrize("seed", [1, 2, pytest.param(3, marks=pytest.mark.soak)])
def test_two_side_by_side_pass_a_narrow_door(seed: int) -> None:
    row = at_door("side by side", 2, 0.8, seed)
    assert (row.passed, row.contacts) == (2, 0)
    assert row.seconds is not None
    assert row.seconds < 4.0


def test_ten_people_pass_a_door_nearly_as_fast_as_published() -> None:
    row = at_door("door", 10, 0.9, 2)
    assert (row.passed, row.contacts) == (10, 0)
    assert row.flow is not None
    assert 1.2 < row.flow < 1.9


@pytest.mark.soak
@pytest.mark.parametrize("people", [2, 4, 10])
@pytest.mark.parametrize("width", [0.8, 0.9, 1.0])
def test_nobody_is_stuck_at_a_door(people: int, width: float) -> None:
    rows = [at_door("door", people, width, seed) for seed in range(1, 9)]
    assert {row.passed for row in rows} == {people}
    assert sum(row.contacts for row in rows) == 0


def test_person_waits_for_a_chair_in_the_doorway() -> None:
    arena = Arena(two_rooms(1.0))
    power = f"{0.3 / robot('rear-wheel').top_speed:.4f}"
    at = Position(x=-1.2, y=0.0, heading=0.0)
    arena.join("chair", "drive", "rear-wheel", None, {"left": power, "right": power}, at)
    walker(arena, "one", (-2.2, 1.2), (4.0, 2.0))
    arena.run(20.0, lambda arena: arena.paths["one"][-1][0] > 0.5)
    assert arena.paths["one"][-1][0] > 0.5
    assert arena.contacts() == []
    passed = {name: next(i for i, (x, _, _) in enumerate(path) if x > 0.0) for name, path in arena.paths.items()}
    assert passed["chair"] < passed["one"]


def chair(arena: Arena, start: tuple[float, float], goal: tuple[float, float], mind: str = "waypoints") -> None:
    options = {"points": f"{goal[0]} {goal[1]}", **({"lead": "true", "speed": "0.6"} if mind == "waypoints" else {})}
    heading = math.atan2(goal[1] - start[1], goal[0] - start[0])
    arena.join("chair", mind, "rear-wheel", None, options, Position(x=start[0], y=start[1], heading=heading))


def test_quick_walker_follows_a_slow_one_where_it_cannot_overtake() -> None:
    arena = Arena(corridor(14.0, 1.0))
    walker(arena, "slow", (1.5, 0.0), (14.0, 0.0), speed="0.7")
    walker(arena, "quick", (0.0, 0.0), (14.0, 0.0), speed="1.4")
    arena.run(12.0)
    assert arena.contacts() == []
    gaps = [a[0] - b[0] for a, b in zip(arena.paths["slow"], arena.paths["quick"], strict=True)][100:]
    assert min(gaps) > 0.4
    assert max(gaps) < 1.2
    assert arena.paths["slow"][-1][0] == pytest.approx(1.5 + 12.0 * 0.7, abs=0.5)


def test_person_follows_a_chair_that_it_likes_through_a_doorway() -> None:
    arena = Arena(two_rooms(1.0))
    chair(arena, (-2.0, 0.0), (4.0, 0.0))
    arena.join("anna", "person", "person", None, {"likes": "chair"}, Position(x=-4.0, y=-1.5, heading=math.pi))
    arena.run(16.0)
    assert far(arena, "chair", (4.0, 0.0)) < 0.2
    assert 1.0 < far(arena, "anna", arena.paths["chair"][-1][:2]) < 2.0
    assert arena.contacts() == []


def test_chair_follows_a_person() -> None:
    arena = Arena(corridor(14.0, 2.4))
    walker(arena, "anna", (2.0, 0.0), (9.0, 0.0), speed="0.6", lead="true")
    arena.join("chair", "follow", "mid-wheel", None, {"leader": "anna"}, Position(x=0.0, y=0.0, heading=0.0))
    arena.run(20.0)
    assert far(arena, "anna", (9.0, 0.0)) < 0.5
    assert far(arena, "chair", arena.paths["anna"][-1][:2]) == pytest.approx(2.0, abs=0.3)
    assert arena.contacts() == []


@pytest.mark.parametrize("feels", [True, False])
def test_feelings_decide_who_follows_the_chair_and_who_keeps_off(feels: bool) -> None:
    arena = Arena(scene("feelings").map)
    for one in scene("feelings").cast:
        options = {each.name: each.value for each in one.option if feels or each.name not in {"likes", "fears"}}
        arena.join(one.name, one.mind, one.robot, one.place, options)
    assert arena.setup.floor.grid
    ends = {place.name: (place.x, place.y) for place in arena.setup.floor.grid.position}
    arena.run(15.0)
    assert far(arena, "ben", ends["goal3"]) < 0.6
    assert far(arena, "chair", ends["spare3"]) < 0.3
    assert (far(arena, "anna", ends["spare3"]) < 2.0) == feels
    assert arena.contacts() == []
    near = min(math.dist(a[:2], b[:2]) for a, b in zip(arena.paths["ben"], arena.paths["chair"], strict=True))
    assert (near > 1.7) == feels


def test_nobody_can_like_and_fear_the_same() -> None:
    with pytest.raises(OptionError, match="option fears: expected agents that it does not like, got 'chair'"):
        Arena("room").join("torn", "person", "person", "start1", {"likes": "anna, chair", "fears": "chair"})


def test_person_finds_a_wide_doorway_that_the_map_declares() -> None:
    """The wall is in its straight way."""
    door = Doorway(name="door", x=0.0, y=0.0, heading_deg=180.0, width=1.4)
    arena = Arena(msgspec.structs.replace(two_rooms(1.4), doorway=(door,)))
    walker(arena, "one", (-3.0, 2.2), (4.0, -2.0))
    arena.run(12.0, lambda arena: far(arena, "one", (4.0, -2.0)) < 0.5)
    assert far(arena, "one", (4.0, -2.0)) < 0.5
    assert arena.contacts() == []


def test_walker_in_a_loop_returns_and_goes_on() -> None:
    arena = Arena(corridor(12.0, 4.0))
    arena.join(
        "one", "person", "person", None, {"points": "4 0 0 0", "loop": "true"}, Position(x=0.0, y=0.0, heading=0.0)
    )
    arena.run(20.0)
    xs = [x for x, _, _ in arena.paths["one"]]
    assert sum(a < 2.0 <= b for a, b in pairwise(xs)) >= 2


def test_person_without_a_goal_stands_and_steps_aside_for_a_chair() -> None:
    arena = Arena(corridor(12.0, 3.4))
    arena.join("one", "person", "person", None, {}, Position(x=6.0, y=0.2, heading=math.pi))
    arena.run(2.0)
    assert arena.paths["one"][-1][:2] == pytest.approx((6.0, 0.2), abs=0.05)
    power = f"{0.5 / robot('rear-wheel').top_speed:.4f}"
    at = Position(x=0.0, y=0.0, heading=0.0)
    arena.join("chair", "drive", "rear-wheel", None, {"left": power, "right": power}, at)
    arena.run(18.0)
    assert arena.contacts() == []


def test_robot_without_encoders_cannot_walk() -> None:
    with pytest.raises(OptionError, match="expected a robot with encoders"):
        Arena("room").join("blind", "person", "crate", "start1")
