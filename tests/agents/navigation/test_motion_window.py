"""The window takes what is cheap among what is safe, and a body that obeys it stands before it touches."""

from __future__ import annotations

import functools
import math

import msgspec
import numpy as np
import pytest

from intellwheels_agents.navigation.cost_to_go import CostToGo
from intellwheels_agents.navigation.footprint_clearance import boxes_of
from intellwheels_agents.navigation.motion_window import ACCELERATION, MARGIN, TURN_RATE, MotionWindow
from intellwheels_schemas.messages import Robot
from tests.agents.navigation.rooms import CHAIR, room, weights

NOTHING = np.zeros((0, 5))


def window(body: Robot = CHAIR, period: float = 0.05) -> MotionWindow:
    return MotionWindow(body, boxes_of(body)[:1], period, 0.8)


@functools.cache
def ahead() -> CostToGo:
    """Return the costs to a goal 8 m ahead of where the bodies start."""
    found = CostToGo.to_point(weights(room(size=12.0)), (10.0, 6.0), 0.1)
    found.expand(10**7)
    return found


def drive(
    one: MotionWindow, points: np.ndarray, seconds: float, period: float = 0.05
) -> tuple[tuple[float, float, float], float]:
    """Drive an ideal body towards the goal ahead among points of the map; return its pose and its least gap."""
    x, y, heading = 2.0, 6.0, 0.0
    least, v, w = math.inf, 0.0, 0.0
    for _ in range(round(seconds / period)):
        one.starts(v, w)
        c, s = math.cos(heading), math.sin(heading)
        dx, dy = points[:, 0] - x, points[:, 1] - y
        velocity = points[:, 2:4]
        body = np.stack(
            [
                c * dx + s * dy,
                c * dy - s * dx,
                c * velocity[:, 0] + s * velocity[:, 1],
                c * velocity[:, 1] - s * velocity[:, 0],
                points[:, 4],
            ],
            axis=1,
        )
        if body.shape[0]:
            least = min(least, float(one.gaps(body[:, 0], body[:, 1]).min()))
        one.choose((x, y, heading), ahead(), body)
        keep = CHAIR.acceleration_curve ** (period / 0.05)
        v = keep * one.actual.speed + (1.0 - keep) * one.last.speed
        w = keep * one.actual.rate + (1.0 - keep) * one.last.rate
        x, y, heading = x + v * period * math.cos(heading), y + v * period * math.sin(heading), heading + w * period
        points = points + np.concatenate([velocity * period, np.zeros((points.shape[0], 3))], axis=1)
    return (x, y, heading), least


def wall(x: float, low: float, high: float, vx: float = 0.0) -> np.ndarray:
    ys = np.arange(low, high, 0.05)
    return np.stack([np.full(ys.size, x), ys, np.full(ys.size, vx), np.zeros(ys.size), np.zeros(ys.size)], axis=1)


@pytest.mark.parametrize("period", [pytest.param(0.02, marks=pytest.mark.soak), 0.05, 0.2])
def test_body_arrives_where_nothing_is_in_the_way(period: float) -> None:
    (x, y, _), _ = drive(window(period=period), NOTHING, 20.0, period)
    assert math.hypot(x - 10.0, y - 6.0) < 0.15


def test_speed_grows_at_the_comfortable_rate() -> None:
    one = window()
    one.choose((2.0, 6.0, 0.0), ahead(), NOTHING)
    assert one.last.speed == pytest.approx(ACCELERATION * 0.05)
    assert abs(one.last.rate) <= TURN_RATE


@pytest.mark.parametrize(("curve", "limit"), [(0.0, None), (0.5, 2.0), (0.95, 0.3)])
def test_body_stands_before_a_wall(curve: float, limit: float | None) -> None:
    body = msgspec.structs.replace(CHAIR, acceleration_curve=curve, acceleration_limit=limit)
    (x, _, _), least = drive(window(body), wall(5.0, 4.0, 8.0), 12.0)
    assert least > 0.0
    assert x > 3.5


def test_body_stands_before_what_comes_towards_it() -> None:
    _, least = drive(window(), wall(9.0, 0.2, 11.8, vx=-0.4), 6.0)
    assert least > 0.0


def test_body_passes_beside_an_obstacle() -> None:
    (x, y, _), least = drive(window(), wall(6.0, 6.4, 9.0), 20.0)
    assert math.hypot(x - 10.0, y - 6.0) < 0.2
    assert least >= MARGIN - 0.01


def test_body_that_is_too_near_may_leave_and_never_comes_nearer() -> None:
    # A wall at its back, 1 cm away.
    _, least = drive(window(), wall(2.0 - 0.31, 5.0, 7.0), 10.0)
    assert least == pytest.approx(0.01, abs=1e-6)


def test_without_a_safe_command_it_brakes() -> None:
    one = window()
    one.last = one.actual = type(one.last)(0.8, 0.0)
    choice = one.choose((2.0, 6.0, 0.0), ahead(), wall(0.72, -1.0, 1.0))
    assert choice.command == (0.0, 0.0)
    assert not choice.moves


def test_window_reaches_as_far_as_braking_takes() -> None:
    slow = msgspec.structs.replace(CHAIR, acceleration_limit=0.3)
    assert window(slow).reach > window().reach + 0.2
