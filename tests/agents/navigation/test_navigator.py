"""The parts together, without a world: goals, plans, doors."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from intellwheels_agents.minds.navigate import equip
from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.navigation.motion_window import Choice, MotionWindow
from intellwheels_agents.navigation.navigator import Navigator
from intellwheels_agents.options import Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import (
    Corner,
    Doorway,
    Goal,
    Heard,
    LidarReading,
    Map,
    Measures,
    Position,
    Sensors,
    TruthReading,
    UserInput,
    Wall,
)
from tests.agents.kinematics import RUN, context
from tests.agents.navigation.rooms import room


def navigator(document: Map, goals: list[tuple[float, float]]) -> Navigator:
    body = equip(robot("mid-wheel"), Options({"truth": "true"}))
    return Navigator(context(body, Position(x=1.5, y=3.0, heading=0.0)), document, 0.8, 0.15, True, goals)


def measured(tick: int, x: float = 1.5, scan: LidarReading | None = None, **fields: object) -> Measures:
    truth = TruthReading(id="truth", x=x, y=3.0, heading=0.0, speed=0.0, turn_rate=0.0)
    sensors = Sensors(truth=(truth,), lidar=() if scan is None else (scan,))
    base = Measures(run=RUN, tick=tick, time=0.05 * tick, sensors=sensors)
    return msgspec.structs.replace(base, **fields)


def test_it_drives_from_the_first_tick() -> None:
    answer = navigator(room(), [(4.5, 3.0)]).decide(measured(1))
    assert answer.mode == "autonomous"
    assert answer.left_motor == answer.right_motor
    assert (answer.left_motor or 0.0) > 0.0
    assert answer.goal == Goal(x=4.5, y=3.0)


def test_without_a_goal_it_stands_until_the_user_sets_one() -> None:
    one = navigator(room(), [])
    assert one.decide(measured(1)).mode == "arrived"
    goal = UserInput(goal=Goal(x=4.5, y=3.0))
    modes = [one.decide(measured(tick, user_input=goal)).mode for tick in range(2, 200)]
    assert modes[0] == "planning"
    assert modes[-1] == "autonomous"


def test_message_gives_a_goal() -> None:
    one = navigator(room(), [])
    order = Heard(sender="operator", tick=1, distance=0.0, text="go 4.5 3.0")
    assert one.decide(measured(1, message=(order,))).goal == Goal(x=4.5, y=3.0)


def test_points_are_passed_in_order() -> None:
    one = navigator(room(), [(3.0, 3.0), (4.5, 3.0)])
    assert one.decide(measured(1)).goal == Goal(x=3.0, y=3.0)
    assert one.decide(measured(2, x=3.0)).goal == Goal(x=4.5, y=3.0)
    one.decide(measured(3, x=4.5))
    assert one.decide(measured(4, x=4.5)).mode == "arrived"


def test_goal_without_a_way_is_reported() -> None:
    answer = navigator(room((2.6, 0.0, 2.9, 6.0)), [(4.5, 3.0)]).decide(measured(1))
    assert answer.mode == "unreachable"
    assert (answer.left_motor, answer.right_motor) == (0.0, 0.0)


def test_closed_door_is_asked_to_open() -> None:
    walls = tuple(
        Wall(thickness=0.1, corner=(Corner(x=3.5, y=low), Corner(x=3.5, y=high)))
        for low, high in ((0.0, 2.4), (3.6, 6.0))
    )
    plain = room()
    doorway = Doorway(name="door", x=3.5, y=3.0, heading_deg=0.0, width=1.2)
    one = navigator(msgspec.structs.replace(plain, wall=plain.wall + walls, doorway=(doorway,)), [(4.8, 3.0)])
    scan = LidarReading(id="scan-front", start_deg=-90.0, step_deg=1.0, ranges=_leaf(), statuses=())
    said = [one.decide(measured(tick, scan=scan)).say for tick in range(1, 40)]
    assert "open" in said
    assert said.count("open") <= 4


def _leaf(ahead: float = 1.425) -> tuple[float | None, ...]:
    """Return the ranges of a scanner at the front left corner to a leaf of 1 m, so far ahead of it, m."""
    found: list[float | None] = []
    for degree in range(-90, 181):
        angle = math.radians(degree)
        metres = ahead / math.cos(angle) if abs(degree) < 80 else None
        inside = metres is not None and abs(0.3275 + metres * math.sin(angle)) < 0.5
        found.append(metres if inside else None)
    return tuple(found)


@pytest.mark.parametrize("name", ["rear-wheel", "front-wheel", "intellwheels", "corridor-chair", "car"])
def test_any_robot_document_will_do(name: str) -> None:
    body = equip(robot(name), Options({"truth": "true"}))
    one = Navigator(context(body, Position(x=6.0, y=6.0, heading=0.0)), room(size=20.0), 0.8, 0.15, True, [(14.0, 6.0)])
    truth = TruthReading(id="truth", x=6.0, y=6.0, heading=0.0, speed=0.0, turn_rate=0.0)
    answer = one.decide(Measures(run=RUN, tick=1, time=0.05, sensors=Sensors(truth=(truth,))))
    assert answer.mode == "autonomous"


@pytest.mark.parametrize(("speed", "moves"), [(0.5, False), (-0.5, True)], ids=["away", "nearer"])
def test_what_moves_away_counts_as_standing(monkeypatch: pytest.MonkeyPatch, speed: float, moves: bool) -> None:
    seen: list[float] = []

    def choose(self: MotionWindow, _pose: object, _goal: object, points: Floats, _slow: float = 1.0) -> Choice:
        near = points[np.abs(points[:, 1]) < 0.2]
        seen.append(float(np.abs(near[:, 2]).max(initial=0.0)))
        return Choice(self.stop(), 0.0, True)

    monkeypatch.setattr(MotionWindow, "choose", choose)
    one = navigator(room(size=12.0), [(8.0, 3.0)])
    for tick in range(1, 30):
        ranges = _leaf(1.6 + speed * 0.05 * tick)
        scan = LidarReading(id="scan-front", tick=tick, start_deg=-90.0, step_deg=1.0, ranges=ranges, statuses=())
        one.decide(measured(tick, scan=scan))
    assert (max(seen) > 0.2) is moves
