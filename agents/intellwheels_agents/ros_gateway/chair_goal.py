"""A goal of ROS (`geometry_msgs/PoseStamped`) as the input of a chair's user. Pure."""

from __future__ import annotations

from typing import Any, Final

from intellwheels_agents.ros_gateway.plane_pose import pose_on_floor
from intellwheels_agents.ros_gateway.robot_frames import MAP
from intellwheels_schemas.errors import wrong_value
from intellwheels_schemas.messages import Goal, UserInput

POSE_STAMPED: Final = "geometry_msgs/msg/PoseStamped"


def user_goal(message: Any) -> UserInput:
    """Return the user input for a goal.

    Raises:
        WireError: The pose is not in the map frame, or no pose on the floor.
    """
    if message.header.frame_id.removeprefix("/") not in ("", MAP):
        raise wrong_value("goal_pose.header.frame_id", repr(MAP), repr(message.header.frame_id[:80]))
    pose = pose_on_floor(message.pose, "goal_pose")
    return UserInput(goal=Goal(x=pose.x, y=pose.y, heading=pose.heading))
