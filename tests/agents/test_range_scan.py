"""A reading is in the way if its obstacle could be in the strip that the body sweeps."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.range_scan import RangeScan, outline
from intellwheels_maps import robot
from intellwheels_schemas.messages import ProximityReading, Robot, Sensors, Status
from tests.agents.kinematics import Body, box

CHAIR = robot("rear-wheel")


def seen(**readings: float) -> RangeScan:
    scan = RangeScan(CHAIR)
    found = tuple(ProximityReading(id=name.replace("_", "-"), value=value) for name, value in readings.items())
    scan.update(Sensors(proximity=found))
    return scan


def test_one_box_form_has_the_same_outline_as_one_part() -> None:
    found = outline(Robot(length=1.10, width=0.62, center=0.227))
    assert (found.front, found.back, found.side) == pytest.approx((0.8503, 0.2497, 0.31))
    assert (outline(CHAIR).front, outline(CHAIR).back) == pytest.approx((found.front, found.back), abs=1e-3)


def test_gap_ahead_is_the_range_of_the_front_sensor() -> None:
    assert seen(front=1.2).gap == pytest.approx(1.2)


def test_obstacle_beside_is_not_in_the_way() -> None:
    assert math.isinf(seen(left=0.1, right=0.1, back=0.1).gap)


def test_jamb_beside_the_front_is_not_in_the_way_but_one_ahead_is() -> None:
    assert math.isinf(seen(front_right=0.25).gap)
    assert seen(front_right=0.05).gap < 0.05


@pytest.mark.parametrize(("status", "gap"), [("none", math.inf), ("near", 0.05), ("fault", math.inf)])
def test_status_of_a_reading_without_a_value_counts(status: Status, gap: float) -> None:
    scan = RangeScan(CHAIR)
    scan.update(Sensors(proximity=(ProximityReading(id="front", status=status),)))
    assert scan.gap == pytest.approx(gap)


def test_clearance_to_each_side_combines_side_and_diagonal_sensors() -> None:
    scan = RangeScan(CHAIR)
    body = Body(CHAIR)
    scan.update(body.measures(box(-3.0, -1.0, 20.0, 2.0)).sensors)
    assert scan.right < scan.left
