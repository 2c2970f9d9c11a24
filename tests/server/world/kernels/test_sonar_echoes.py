"""What sonars hear: mirrors, posts, what hides what, and steps."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_schemas.messages import Corner, Part, Position, Proximity, Robot, Wall
from intellwheels_server.world import State, measures
from intellwheels_server.world.kernels.sonar_echoes import COMB
from tests.server.worlds import box_wall, cart, run, world


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
