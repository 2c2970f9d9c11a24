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
    made = PoseSource(CHAIR, name, Calibration(wheel_ratio=1.01, track_ratio=1.02), **more)  # type: ignore[arg-type]
    made.set_start(START)
    return made


def test_counts_may_start_at_any_value() -> None:
    one = source()
    one.add(reading(1, 5000, 7000))
    assert one.estimate is not None
    assert (one.estimate.x, one.estimate.y) == (1.0, 2.0)
    one.add(reading(2, 5000 + METRE, 7000 + METRE))
    assert (one.estimate.x, one.estimate.y) == pytest.approx((1.0, 3.0), abs=1e-3)
    assert (one.left, one.right) == (METRE, METRE)


@pytest.mark.parametrize(("name", "turns"), [("raw", 0.0), ("calibrated", 0.01 / (0.572 * 1.02))])
def test_only_a_calibrated_source_uses_the_calibration(name: PoseSourceName, turns: float) -> None:
    one = source(name)
    one.add(reading(1))
    one.add(reading(2, METRE, METRE))
    assert one.estimate is not None
    assert one.estimate.heading - START.heading == pytest.approx(turns, rel=0.01, abs=1e-9)


def test_only_a_corrected_source_uses_fixes() -> None:
    for name, expected in (("calibrated", 2.0), ("corrected", 2.5)):
        one = source(name, drift=1e-2)  # type: ignore[arg-type]
        one.add(reading(1))
        for seq in range(2, 12):
            one.add(reading(seq, METRE * seq * (-1) ** seq, METRE * seq * (-1) ** seq))
        assert one.estimate is not None
        one.add(reading(12, 0, 0, fix=Fix(1.0, 2.5, 0.001)))
        assert one.estimate.y == pytest.approx(expected, abs=0.02)


def test_an_overtaken_reading_is_dropped_and_a_gap_costs_nothing() -> None:
    one = source()
    one.add(reading(1))
    assert one.add(reading(4, 300, 300))
    assert not one.add(reading(3, 200, 200))
    assert one.add(reading(5, METRE, METRE))
    assert one.estimate is not None
    assert one.estimate.y == pytest.approx(3.0, abs=1e-3)
    assert (one.overtaken, one.missing) == (1, 2)


@pytest.mark.parametrize(("restarts_at_start", "y"), [(False, 3.0), (True, 2.0)])
def test_a_new_epoch_continues_from_the_pose_or_from_the_start(restarts_at_start: bool, y: float) -> None:
    one = source(restarts_at_start=restarts_at_start)
    one.add(reading(1))
    one.add(reading(2, METRE, METRE))
    assert one.add(reading(1, 17, 18, epoch="b"))
    assert one.estimate is not None
    assert one.estimate.y == pytest.approx(y, abs=1e-3)
    assert one.left == (0 if restarts_at_start else METRE)


def test_only_the_first_start_counts() -> None:
    one = source()
    one.set_start(Position(x=9.0, y=9.0, heading=0.0))
    assert one.start == START
