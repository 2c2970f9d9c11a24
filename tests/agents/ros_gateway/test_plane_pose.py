"""Poses on the floor, and what is no such pose."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_agents.ros_gateway.plane_pose import PlanePose, half_angle, pose_on_floor
from intellwheels_agents.ros_gateway.ros_messages import pose_message
from intellwheels_schemas.errors import WireError


def test_a_pose_and_its_inverse_cancel() -> None:
    pose = PlanePose(1.0, -2.0, 0.7)
    for product in (pose @ pose.inverse(), pose.inverse() @ pose):
        assert (product.x, product.y, product.heading) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_ahead_of_a_body_that_looks_along_y_is_y() -> None:
    found = PlanePose(1.0, 1.0, math.pi / 2.0) @ PlanePose(2.0, 0.0, 0.1)
    assert (found.x, found.y, found.heading) == pytest.approx((1.0, 3.0, math.pi / 2.0 + 0.1))


def test_quarter_turn_is_half_of_it_in_a_quaternion() -> None:
    assert half_angle(math.pi / 2.0) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))


@pytest.mark.parametrize("heading", [0.0, 1.0, -3.0, math.pi])
def test_message_of_a_pose_is_read_back(heading: float) -> None:
    found = pose_on_floor(pose_message(PlanePose(3.0, 4.0, heading)), "pose")
    assert (found.x, found.y, found.heading) == pytest.approx((3.0, 4.0, heading))


def changed(part: str, **values: float) -> Any:
    pose = pose_message(PlanePose(1.0, 2.0, 0.5))
    for name, value in values.items():
        setattr(getattr(pose, part), name, value)
    return pose


@pytest.mark.parametrize(("pose", "text"), [
    (changed("position", x=math.nan), "pose: expected finite numbers"),
    (changed("orientation", w=math.inf), "pose: expected finite numbers"),
    (changed("position", y=1e300), "pose.position: expected metres up to 10000"),
    (changed("orientation", z=0.0, w=0.0), "pose.orientation: expected a quaternion of norm 1, got norm 0"),
    (changed("position", z=0.5), "pose: expected a pose on the floor"),
    (changed("orientation", x=0.6, z=0.0, w=0.8), "pose: expected a pose on the floor"),
])  # fmt: skip
def test_other_poses_are_refused(pose: Any, text: str) -> None:
    with pytest.raises(WireError) as caught:
        pose_on_floor(pose, "pose")
    assert caught.value.text.startswith(text)
