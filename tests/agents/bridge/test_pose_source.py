from __future__ import annotations

import math

import pytest

from intellwheels_agents.bridge.hardware_driver import Fix
from intellwheels_agents.bridge.pose_source import Calibration, PoseSource, PoseSourceName
from intellwheels_maps import robot
from intellwheels_schemas.messages import Position
from tests.agents.bridge.readings import reading

CHAIR = robot("intellwheels")
START = Position(x=1.0, y=2.0, heading=math.pi / 2.0)
METRE = round(CHAIR.encoder_ticks / (math.pi * CHAIR.wheel_diameter))


def source(name: PoseSourceName = "raw", **more: object) -> PoseSource:
    made = PoseSource(CHAIR, name, Calibration(ratio=1.01, track_ratio=1.02), **more)  # type: ignore[arg-type]
    made.begin(START)
    return made


def test_counts_begin_wherever_they_are() -> None:
    one = source()
    one.take(reading(1, 5000, 7000))
    assert one.estimate is not None
    assert (one.estimate.x, one.estimate.y) == (1.0, 2.0)
    one.take(reading(2, 5000 + METRE, 7000 + METRE))
    assert (one.estimate.x, one.estimate.y) == pytest.approx((1.0, 3.0), abs=1e-3)
    assert (one.left, one.right) == (METRE, METRE)


@pytest.mark.parametrize(("name", "turns"), [("raw", 0.0), ("calibrated", 0.01 / (0.572 * 1.02))])
def test_only_what_is_calibrated_knows_the_wheels_as_they_are(name: PoseSourceName, turns: float) -> None:
    one = source(name)
    one.take(reading(1))
    one.take(reading(2, METRE, METRE))
    assert one.estimate is not None
    assert one.estimate.heading - START.heading == pytest.approx(turns, rel=0.01, abs=1e-9)


def test_only_what_is_corrected_takes_a_fix() -> None:
    for name, expected in (("calibrated", 2.0), ("corrected", 2.5)):
        one = source(name, drift=1e-2)  # type: ignore[arg-type]
        one.take(reading(1))
        for seq in range(2, 12):
            one.take(reading(seq, METRE * seq * (-1) ** seq, METRE * seq * (-1) ** seq))
        assert one.estimate is not None
        one.take(reading(12, 0, 0, fix=Fix(1.0, 2.5, 0.001)))
        assert one.estimate.y == pytest.approx(expected, abs=0.02)


def test_an_overtaken_reading_is_dropped_and_a_gap_costs_nothing() -> None:
    one = source()
    one.take(reading(1))
    assert one.take(reading(4, 300, 300))
    assert not one.take(reading(3, 200, 200))
    assert one.take(reading(5, METRE, METRE))
    assert one.estimate is not None
    assert one.estimate.y == pytest.approx(3.0, abs=1e-3)
    assert (one.stale, one.lost) == (1, 2)


@pytest.mark.parametrize(("returns", "y"), [(False, 3.0), (True, 2.0)])
def test_a_new_era_goes_on_from_there_or_from_the_start(returns: bool, y: float) -> None:
    one = source(returns=returns)
    one.take(reading(1))
    one.take(reading(2, METRE, METRE))
    assert one.take(reading(1, 17, 18, era="b"))
    assert one.estimate is not None
    assert one.estimate.y == pytest.approx(y, abs=1e-3)
    assert one.left == (0 if returns else METRE)


def test_the_start_is_told_once() -> None:
    one = source()
    one.begin(Position(x=9.0, y=9.0, heading=0.0))
    assert one.start == START
