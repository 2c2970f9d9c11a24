"""Goals of ROS as user input."""

from __future__ import annotations

import pytest

from intellwheels_agents.ros_gateway.chair_goal import user_goal
from intellwheels_schemas.errors import WireError
from tests.agents.ros_gateway.stand_in_node import pose_stamped


@pytest.mark.parametrize("frame", ["map", "/map", ""])
def test_goal_is_that_of_the_user(frame: str) -> None:
    goal = user_goal(pose_stamped(3.0, 4.0, 0.5, frame)).goal
    assert goal is not None
    assert (goal.x, goal.y, goal.heading) == pytest.approx((3.0, 4.0, 0.5))


def test_goal_in_another_frame_is_refused() -> None:
    with pytest.raises(WireError, match=r"goal_pose\.header\.frame_id: expected 'map', got 'chair1/odom'"):
        user_goal(pose_stamped(3.0, 4.0, 0.5, "chair1/odom"))


def test_goal_that_is_no_pose_is_refused() -> None:
    with pytest.raises(WireError, match="goal_pose: expected finite numbers"):
        user_goal(pose_stamped(float("nan"), 4.0, 0.5))
