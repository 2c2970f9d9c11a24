"""What a chair publishes at a tick."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import pytest

from intellwheels_agents.ros_gateway.chair_messages import ChairMessages, chair_topics
from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.ros_types import encode_message
from intellwheels_maps import names, robot
from intellwheels_schemas.messages import Measures
from tests.agents.ros_gateway.made_up import CHAIR, PERIOD, measured, readings
from tests.agents.ros_gateway.stand_in_node import STORE, seconds_of
from tests.every_case import every_case

START = PlanePose(3.0, 2.0, math.pi / 2.0)


def sent(messages: ChairMessages, measures: Measures) -> dict[str, Any]:
    """Return the messages of a tick by topic, as another reader of CDR gets them."""
    found = {}
    for topic, message in messages.messages(measures):
        found[topic] = STORE.deserialize_cdr(encode_message(message), message.__msgtype__)
    return found


@every_case("name", names("robots"))
def test_every_included_robot_has_topics_for_its_sensors(name: str) -> None:
    topics = [topic.name for topic in chair_topics("c", robot(name))]
    assert len(set(topics)) == len(topics)
    assert len([topic for topic in topics if "/range/" in topic]) == len(robot(name).proximity)


def test_messages_are_those_that_were_advertised() -> None:
    topics = {topic.name: topic.type for topic in chair_topics("c", CHAIR)}
    messages = ChairMessages("c", CHAIR, PERIOD, START)
    found = {topic: message.__msgtype__ for topic, message in messages.messages(measured(0, readings(0.0)))}
    found[messages.static().topic] = messages.static().message.__msgtype__
    assert found == topics


def test_stamps_are_ticks() -> None:
    found = sent(ChairMessages("c", CHAIR, PERIOD, START), measured(7, readings(0.0)))
    for topic in ("/c/odom", "/c/scan", "/c/imu", "/c/joint_states", "/diagnostics"):
        assert seconds_of(found[topic].header.stamp) == pytest.approx(0.35)
    late = sent(ChairMessages("c", CHAIR, PERIOD, START), measured(7, readings(0.0, tick=5)))
    assert seconds_of(late["/c/odom"].header.stamp) == pytest.approx(0.25)


def test_odometry_begins_at_zero_and_the_start_is_its_place_on_the_map() -> None:
    messages = ChairMessages("c", CHAIR, PERIOD, START)
    sent(messages, measured(0, readings(0.0)))
    found = sent(messages, measured(1, readings(0.02)))
    odometry = found["/c/odom"]
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("c/odom", "c/base_link")
    assert odometry.pose.pose.position.x == 0.02
    assert odometry.twist.twist.linear.x == pytest.approx(0.4)
    assert odometry.pose.covariance[0] > 0.0
    on_map, on_odometry = found["/tf"].transforms
    assert (on_map.header.frame_id, on_map.child_frame_id) == ("map", "c/odom")
    assert (on_map.transform.translation.x, on_map.transform.translation.y) == (3.0, 2.0)
    assert on_map.transform.rotation.z == pytest.approx(math.sqrt(0.5))
    assert (on_odometry.header.frame_id, on_odometry.child_frame_id) == ("c/odom", "c/base_link")


def test_truth_corrects_the_place_of_the_odometry() -> None:
    body = msgspec.structs.replace(CHAIR)
    messages = ChairMessages("c", body, PERIOD, START, "truth")
    found = sent(messages, measured(1, readings(1.0, truth=(3.1, 3.0, math.pi / 2.0))))
    on_map = found["/tf"].transforms[0].transform.translation
    # A metre behind the true pose, along y.
    assert (on_map.x, on_map.y) == pytest.approx((3.1, 2.0))


def test_another_node_may_localise() -> None:
    found = sent(ChairMessages("c", CHAIR, PERIOD, START, "none"), measured(1, readings(1.0)))
    assert [one.child_frame_id for one in found["/tf"].transforms] == ["c/base_link"]


def test_watched_chair_is_where_it_is_now() -> None:
    messages = ChairMessages("c", CHAIR, PERIOD, PlanePose(5.0, 5.0, 0.0), moved=True)
    for tick, x in ((9, 2.0), (10, 2.5)):
        on_map = sent(messages, measured(tick, readings(x)))["/tf"].transforms[0].transform.translation
        assert (on_map.x, on_map.y) == pytest.approx((3.0, 5.0))


def test_sensors_have_fixed_frames() -> None:
    message = ChairMessages("c", CHAIR, PERIOD, START).static().message
    found = {one.child_frame_id: one for one in message.transforms}
    lidar = found["c/lidar"]
    assert lidar.header.frame_id == "c/base_link"
    assert (lidar.transform.translation.x, lidar.transform.translation.z) == (0.696, 0.3)


def test_diagnostics_come_once_a_second_and_when_something_changes() -> None:
    messages = ChairMessages("c", CHAIR, PERIOD, START)
    told = [tick for tick in range(45) if "/diagnostics" in sent(messages, measured(tick, collision=tick == 30))]
    assert told == [0, 20, 30, 31]
    status = sent(messages, measured(100, collision=True))["/diagnostics"].status[0]
    assert (status.level, status.message, status.hardware_id) == (1, "blocked", "c")


def test_second_lidar_has_a_topic_of_its_own() -> None:
    second = msgspec.structs.replace(CHAIR.lidar[0], id="rear-lidar")
    body = msgspec.structs.replace(CHAIR, lidar=(*CHAIR.lidar, second))
    assert [topic.name for topic in chair_topics("c", body) if "scan" in topic.name] == [
        "/c/scan",
        "/c/scan/rear_lidar",
    ]


def test_unknown_readings_are_left_out() -> None:
    assert set(sent(ChairMessages("c", robot("table"), PERIOD, START), measured(1, readings(0.0)))) >= {"/diagnostics"}
