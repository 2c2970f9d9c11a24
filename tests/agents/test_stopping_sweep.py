"""A body never gives a command after which it could not stop before a point."""

from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_agents.stopping_sweep import MARGIN, SHARE, SPARE, StoppingSweep
from intellwheels_maps import robot
from intellwheels_schemas.messages import EncodersReading, Robot

CHAIR = robot("mid-wheel")
FRONT, SIDE = 0.575, 0.3275


def sweep(period: float = 0.05, **fields: object) -> StoppingSweep:
    return StoppingSweep(msgspec.structs.replace(CHAIR, **fields), period)


def run_out(curve: float, limit: float | None, speed: float) -> float:
    """Return how far a wheel rolls from a speed to rest, summed in steps of a millisecond."""
    tau, way = -0.05 / math.log(curve), 0.0
    for _ in range(60_000):
        slope = -speed / tau
        speed += 1e-3 * (slope if limit is None else max(-limit, min(limit, slope)))
        way += 1e-3 * speed
    return way


@pytest.mark.parametrize("curve", [0.4, 0.95])
@pytest.mark.parametrize("limit", [None, 0.3, 2.0])
def test_full_speed_is_allowed_if_the_way_to_rest_is_a_share_of_what_is_free(curve: float, limit: float | None) -> None:
    one = sweep(acceleration_curve=curve, acceleration_limit=limit, top_speed=1.0)
    one.drive(1.0, 0.0)
    for _ in range(400):
        one.measure(None)
    # A tick and the spare time at full speed, then the run-out.
    way = (0.05 + SPARE + run_out(curve, limit, 1.0)) / SHARE
    assert one.needed(1.0) == pytest.approx(way + MARGIN, abs=0.01)
    one.watch([(FRONT + way + 0.03, 0.0)])
    assert one.is_free(1.0, 0.0)
    one.watch([(FRONT + way - 0.03, 0.0)])
    assert not one.is_free(1.0, 0.0)
    one.watch([(FRONT + 0.1, SIDE + 2.0 * MARGIN)])
    assert one.is_free(1.0, 0.0)


def test_a_corner_may_not_swing_into_a_point_and_the_other_way_is_free() -> None:
    one = sweep()
    one.watch([(FRONT - 0.02, SIDE + MARGIN + 0.002)])
    assert not one.is_free(0.0, 1.0)
    assert one.is_free(0.0, -1.0)
    assert one.is_free(0.0, 0.0)
    assert not one.is_free(0.0, 0.2)
    one.watch([(FRONT - 0.02, SIDE + MARGIN + 0.002)], 0.02)
    assert one.is_free(0.0, 0.2)


def test_nearer_than_the_margin_it_may_pass_and_leave_but_not_come_nearer() -> None:
    one = sweep()
    one.watch([(0.1, SIDE + 0.02)])
    assert one.is_free(0.5, 0.0)
    one.watch([(FRONT + 0.02, 0.0)])
    assert not one.is_free(0.2, 0.0)
    assert one.is_free(-0.2, 0.0)


def test_encoders_override_the_motor_model_if_they_differ_clearly() -> None:
    one = sweep()
    one.drive(1.0, 0.0)
    a_metre = CHAIR.encoder_ticks / (math.pi * CHAIR.wheel_diameter)
    for tick in range(20):
        one.measure(EncodersReading(id="w", left=round(0.01 * tick * a_metre), right=round(0.01 * tick * a_metre)))
    # The wheels turn at 0.2 m/s, whatever the motors were told: it can stop.
    one.watch([(FRONT + 0.12, 0.0)])
    assert one.is_free(0.0, 0.0)
    for _ in range(20):
        one.measure(None)
    assert not one.is_free(0.0, 0.0)


def test_distances_are_those_of_the_footprint() -> None:
    one = StoppingSweep(Robot(length=1.0, width=0.6, top_speed=1.0), 0.05)
    assert one.radius == pytest.approx(math.hypot(0.5, 0.3))
    assert one.clearance(0.8, 0.7) == pytest.approx(0.5)
    assert one.clearance(0.0, 0.4) == pytest.approx(0.1)
    assert one.contains(0.4, 0.2)
    assert not one.contains(0.4, 0.31)
