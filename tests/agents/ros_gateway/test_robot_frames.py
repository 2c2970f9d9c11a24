"""Frames of a chair."""

from __future__ import annotations

import math

from intellwheels_agents.ros_gateway.robot_frames import frame_of, is_base, sensor_frames
from intellwheels_maps import robot


def test_frame_of_a_sensor_looks_along_its_axis() -> None:
    frame = sensor_frames(robot("intellwheels"))["left"]
    assert (frame.name, frame.pose.x, frame.pose.y, frame.height) == ("left", 0.096, 0.33, 0.4)
    assert frame.pose.heading == math.pi / 2.0


def test_imu_is_at_the_centre_of_movement() -> None:
    frame = sensor_frames(robot("lidar-chair"))["imu"]
    assert (frame.pose.x, frame.pose.y, frame.pose.heading) == (0.0, 0.0, 0.0)


def test_sensor_on_a_door_frame_stays_where_the_door_started() -> None:
    frames = sensor_frames(robot("door"))
    assert any(frame.fixed_at_start for frame in frames.values())


def test_names_of_the_body_frame() -> None:
    assert frame_of("chair1", "odom") == "chair1/odom"
    assert all(is_base(frame, "chair1") for frame in ("", "base_link", "chair1/base_link", "/chair1/base_link"))
    assert not any(is_base(frame, "chair1") for frame in ("map", "odom", "chair2/base_link"))
