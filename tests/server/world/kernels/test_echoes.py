"""What sonars hear: mirrors, posts, what hides what, steps and the chirps of others."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_schemas.messages import Corner, Part, Position, Proximity, Robot, Wall
from intellwheels_server.world import State, measures
from intellwheels_server.world.kernels.echoes import COMB, segment_in_wedge
from tests.server.worlds import box_wall, cart, run, world

# Names of functions that compiled code hides from type checkers' view of a tuple.
SEGMENT: Any = segment_in_wedge


def _sonar(sensor_id: str = "s", **fields: Any) -> Proximity:
    known: dict[str, Any] = {
        "x": 0.0, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "cone_deg": 60.0, "max_range": 5.0, "model": "sonar",
    }  # fmt: skip
    return Proximity(id=sensor_id, **{**known, **fields})


def _heard(state: State, agent: str = "a", at: int = 0) -> float | str:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    reading = sensors.proximity[at]
    return reading.status if reading.value is None else reading.value


def _told(distance: float) -> Any:
    return pytest.approx(COMB * round(distance / COMB), abs=1e-12)


def _lost_from(turns: list[float], walls: list[Wall]) -> float:
    """Return the first of some directions of a sonar, in degrees, in which it hears nothing."""
    sonars = tuple(_sonar(f"s{k}", direction_deg=turn) for k, turn in enumerate(turns))
    state = world({"a": cart(proximity=sonars)}, walls)
    heard = [_heard(state, at=k) for k in range(len(turns))]
    first = heard.index("none")
    assert all(value == "none" for value in heard[first:])
    assert all(value == _told(2.0) for value in heard[:first])
    return turns[first]


def test_wall_is_lost_beyond_25_degrees_between_axis_and_normal() -> None:
    turns = [0.5 * k for k in range(60)]
    assert _lost_from(turns, [box_wall(2.0, -9.0, 3.0, 9.0)]) == pytest.approx(25.0, abs=1.0)
    mirrored = [-turn for turn in turns]
    assert _lost_from(mirrored, [box_wall(2.0, -9.0, 3.0, 9.0)]) == pytest.approx(-25.0, abs=1.0)
    slanted = Wall(corner=tuple(Corner(x=x, y=y) for x, y in ((2.0, -9.0), (9.0, 0.0), (2.0, 9.0))))
    assert _lost_from(turns, [slanted]) == pytest.approx(25.0, abs=1.0)


@pytest.mark.parametrize("body", [True, False])
def test_post_of_25_mm_is_lost_beyond_2_4_m(*, body: bool) -> None:
    for distance, heard in ((1.0, True), (2.39, True), (2.41, False), (3.5, False)):
        robots = {"a": cart(proximity=(_sonar(),))}
        walls = []
        if body:
            part = Part(x=0.0, y=0.0, length=0.025, width=0.025, bottom=0.0, top=1.0)
            robots["post"] = Robot(part=(part,), position=Position(x=distance + 0.0125, y=0.0, heading=0.0))
        else:
            walls.append(box_wall(distance, -0.0125, distance + 0.025, 0.0125))
        assert _heard(world(robots, walls)) == (_told(distance) if heard else "none")


def test_post_answers_from_whatever_side_it_is_seen() -> None:
    turned = [(2.0, 0.0), (2.02, -0.02), (2.04, 0.0), (2.02, 0.02)]
    walls = [Wall(corner=tuple(Corner(x=x, y=y) for x, y in turned))]
    assert _heard(world({"a": cart(proximity=(_sonar(),))}, walls)) == _told(2.0)


def test_body_answers_from_whatever_side_it_is_seen() -> None:
    robots = {"a": cart(proximity=(_sonar(),)), "b": cart(3.0, heading=math.radians(45))}
    nearest = 3.0 - 0.8 * math.sqrt(0.5)  # the corner
    assert _heard(world(robots)) == pytest.approx(nearest, abs=COMB)


def test_nothing_is_heard_through_a_wall_that_is_lost() -> None:
    ahead = box_wall(4.0, -9.0, 5.0, 9.0)
    slanted = Wall(corner=tuple(Corner(x=x, y=y) for x, y in ((1.0, -2.0), (1.2, -2.0), (4.2, 2.0), (4.0, 2.0))))
    sonar = (_sonar(cone_deg=20.0),)
    assert _heard(world({"a": cart(proximity=sonar)}, [ahead])) == _told(4.0)
    assert _heard(world({"a": cart(proximity=sonar)}, [ahead, slanted])) == "none"


def test_too_close_and_inside_are_near() -> None:
    walls = [box_wall(1.0, -1.0, 2.0, 1.0)]
    assert _heard(world({"a": cart(proximity=(_sonar(min_range=1.2),))}, walls)) == "near"
    assert _heard(world({"a": cart(proximity=(_sonar(x=1.5),))}, walls)) == "near"


def test_distances_come_in_steps_of_8_65_mm() -> None:
    state = world({"a": cart(proximity=(_sonar(),))}, [box_wall(3.0, -9.0, 4.0, 9.0)])
    for _ in range(10):
        value = _heard(state)
        assert isinstance(value, float)
        assert value / 0.00865 == pytest.approx(round(value / 0.00865), abs=1e-9)
        assert value == pytest.approx(3.0 - float(state.numbers[0, 0]), abs=0.0044)
        state, _ = run(state, 1, {"a": (0.3, 0.3)})


def _facing(crosstalk: float, walls: list[Wall] | None = None, **fields: Any) -> State:
    robots = {
        "a": cart(proximity=(_sonar(x=0.5, crosstalk=crosstalk),)),
        "b": cart(4.0, heading=math.pi, proximity=(_sonar(x=0.5, **fields),)),
    }
    return world(robots, walls or [])


def test_chirp_of_a_sonar_that_looks_back_counts_as_half_the_way() -> None:
    assert _heard(_facing(0.0)) == _told(3.0)
    assert _heard(_facing(1.0)) == _told(1.5)
    assert _heard(_facing(1.0), "b") == _told(3.0)
    assert _heard(_facing(1.0, direction_deg=90.0)) == _told(3.0)


def test_chirp_is_not_heard_through_a_wall_nor_of_another_firing_group() -> None:
    assert _heard(_facing(1.0, [box_wall(2.2, -1.0, 2.4, 1.0)])) == _told(1.7)
    # In the first tick group 1 is silent; then the other does not fire again.
    assert _heard(_facing(1.0, every=2, group=1)) == _told(3.0)
    state, _ = run(_facing(1.0, every=2, group=1), 1)
    assert _heard(state) == _told(1.5)


def test_share_of_chirps_that_is_taken_for_an_echo() -> None:
    state = _facing(0.3)
    taken = 0
    for _ in range(400):
        taken += _heard(state) == _told(1.5)
        state, _ = run(state, 1)
    assert taken == pytest.approx(120, abs=37)  # four standard deviations


def test_nearest_point_of_a_segment_in_a_wedge() -> None:
    half = math.radians(30)
    cone = (1.0, 0.0, math.cos(half), math.sin(half))
    assert SEGMENT(2.0, -1.0, 2.0, 1.0, *cone) == pytest.approx((4.0, 2.0, 0.0))
    # From the left it begins where the left side of the wedge meets it.
    aside = 2.0 * math.tan(half)
    assert SEGMENT(2.0, 0.5, 2.0, 9.0, *cone)[0] == pytest.approx(4.25)
    assert SEGMENT(1.0, 3.0, 4.0, 0.0, *cone)[0] == pytest.approx(8.0 if half > math.pi / 4 else _crossing(half))
    assert SEGMENT(2.0, aside + 0.01, 2.0, 9.0, *cone)[0] == math.inf
    assert SEGMENT(-2.0, -1.0, -2.0, 1.0, *cone)[0] == math.inf
    assert SEGMENT(-2.0, -1.0, -2.0, 1.0, 1.0, 0.0, -1.0, 0.0)[0] == 4.0


def _crossing(half: float) -> float:
    """Return the square of the way along the left side to the line x + y = 4."""
    return (4.0 / (math.cos(half) + math.sin(half))) ** 2
