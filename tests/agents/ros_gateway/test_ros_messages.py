"""Messages from plain numbers."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.ros_messages import header, matrix, time_message, transform, twist_message


@pytest.mark.parametrize(
    ("seconds", "sec", "nanosec"), [(0.0, 0, 0), (12.345, 12, 345_000_000), (0.05 * 3, 0, 150_000_000), (1e9, 10**9, 0)]
)
def test_time_is_exact_to_the_microsecond(seconds: float, sec: int, nanosec: int) -> None:
    found = time_message(seconds)
    assert (found.sec, found.nanosec) == (sec, nanosec)


def test_matrix_is_symmetric_and_has_a_full_diagonal() -> None:
    found = matrix(6, {(0, 0): 2.0, (0, 5): 0.5}, 1e-6).reshape(6, 6)
    assert np.array_equal(found, found.T)
    assert found[5, 0] == 0.5
    assert found.diagonal().tolist() == [2.0, *[1e-6] * 5]


def test_header_and_transform_name_their_frames() -> None:
    assert header("map", 1.5).stamp.nanosec == 500_000_000
    found = transform("map", "chair1/odom", PlanePose(1.0, 2.0, 0.0), 1.5, 0.3)
    assert (found.header.frame_id, found.child_frame_id) == ("map", "chair1/odom")
    assert (found.transform.translation.x, found.transform.translation.z, found.transform.rotation.w) == (1.0, 0.3, 1.0)


def test_twist_turns_about_z() -> None:
    found = twist_message(0.5, -0.25)
    assert (found.linear.x, found.linear.y, found.angular.z) == (0.5, 0.0, -0.25)
