"""A reading is in the way when what it saw could stand in the strip the body sweeps."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.range_scan import RangeScan, outline
from intellwheels_maps import robot
from intellwheels_schemas.messages import ProximityReading, Robot, Sensors, Status
from tests.agents.kinematics import Body, box

CHAIR = robot("rear-wheel")


def seen(**readings: float) -> RangeScan:
    around = RangeScan(CHAIR)
    found = tuple(ProximityReading(id=name.replace("_", "-"), value=value) for name, value in readings.items())
    around.update(Sensors(proximity=found))
    return around


def test_the_outline_of_the_one_part_form_is_that_of_the_same_box() -> None:
    found = outline(Robot(length=1.10, width=0.62, center=0.227))
    assert (found.front, found.back, found.side) == pytest.approx((0.8503, 0.2497, 0.31))
    assert (outline(CHAIR).front, outline(CHAIR).back) == pytest.approx((found.front, found.back), abs=1e-3)


def test_what_stands_before_it_is_as_far_as_the_front_sensor_says() -> None:
    assert seen(front=1.2).gap == pytest.approx(1.2)


def test_what_stands_beside_is_not_in_the_way() -> None:
    assert math.isinf(seen(left=0.1, right=0.1, back=0.1).gap)


def test_a_jamb_beside_the_front_is_not_in_the_way_and_one_before_it_is() -> None:
    assert math.isinf(seen(front_right=0.25).gap)
    assert seen(front_right=0.05).gap < 0.05


@pytest.mark.parametrize(("status", "gap"), [("none", math.inf), ("near", 0.05), ("fault", math.inf)])
def test_a_reading_without_a_value_still_tells_something(status: Status, gap: float) -> None:
    around = RangeScan(CHAIR)
    around.update(Sensors(proximity=(ProximityReading(id="front", status=status),)))
    assert around.gap == pytest.approx(gap)


def test_room_to_each_side_is_that_of_the_sensors_beside_and_ahead() -> None:
    around = RangeScan(CHAIR)
    body = Body(CHAIR)
    around.update(body.measures(box(-3.0, -1.0, 20.0, 2.0)).sensors)
    assert around.right < around.left
