"""Poses, scans and log lines as messages of Foxglove, read with the schemas that come with them."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_agents.record_gateway import motion_messages as motion
from intellwheels_schemas.messages import Entity, Event, Lidar, LidarReading, OdometryReading, Position, Robot
from tests.agents.record_gateway.decoded import decoded

ROBOT = Robot(
    position=Position(x=1.0, y=2.0, heading=0.5),
    lidar=(Lidar(id="laser", x=0.4, y=0.1, z=0.3, direction_deg=0.0, fov_deg=180.0, rays=3, max_range=8.0),),
)
TIME = 3_000_000_007


def heading_of(rotation: Any) -> float:
    return 2.0 * math.atan2(rotation.z, rotation.w)


def test_frames_of_a_body_and_of_its_start_are_in_the_map() -> None:
    entity = Entity(name="map", x=4.0, y=5.0, heading=-3.0)
    found = decoded(motion.transforms([entity], {"map": ROBOT}, TIME)).transforms
    assert [(one.parent_frame_id, one.child_frame_id) for one in found] == [("map", "map/body"), ("map", "map/start")]
    assert (found[0].translation.x, found[0].translation.y) == (4.0, 5.0)
    assert heading_of(found[0].rotation) == pytest.approx(-3.0)
    assert heading_of(found[1].rotation) == pytest.approx(0.5)
    assert (found[0].timestamp.seconds, found[0].timestamp.nanos) == (3, 7)


def test_true_motion_has_the_twist_in_the_frame_of_the_body() -> None:
    found = decoded(motion.true_motion(Entity(name="c", x=1.0, y=2.0, heading=0.1, speed=0.7, turn_rate=-0.2), TIME))
    assert (found.frame_id, found.body_frame_id) == ("map", "c/body")
    assert (found.linear_velocity.x, found.angular_velocity.z) == (0.7, -0.2)


def test_odometry_is_in_the_frame_of_the_start() -> None:
    found = decoded(motion.odometry("c", OdometryReading(id="o", x=1.0, y=2.0, heading=0.3), TIME))
    assert (found.frame_id, found.pose.position.x) == ("c/start", 1.0)
    assert not found.HasField("linear_velocity")


def test_ranges_without_a_value_are_those_of_rep_117() -> None:
    reading = LidarReading(
        id="laser", start_deg=-90.0, step_deg=90.0, ranges=(None, 2.0, None), statuses=("none", "ok", "near")
    )
    message = motion.laser_scan("c", ROBOT, reading, TIME)
    assert message is not None
    found = decoded(message)
    assert list(found.ranges) == [math.inf, 2.0, -math.inf]
    assert (found.start_angle, found.end_angle) == pytest.approx((-math.pi / 2, math.pi / 2))
    assert (found.frame_id, found.pose.position.x, found.pose.position.z) == ("c/body", 0.4, 0.3)


def test_a_scan_of_an_unknown_sensor_is_none() -> None:
    assert motion.laser_scan("c", ROBOT, LidarReading(id="x", start_deg=0.0, step_deg=1.0), TIME) is None


def test_a_contact_is_a_warning_with_what_was_touched() -> None:
    event = Event(run="0" * 16, tick=3, number=1, code="contact", agent="c", other="wall", speed=0.5)
    found = decoded(motion.log_of_event(event, TIME))
    assert (found.level, found.name, found.message) == (3, "c", "contact agent=c other=wall speed=0.5")
