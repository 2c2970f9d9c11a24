"""Keys, tokens and attachments, against those of a real node (ROS 2 Kilted, rmw_zenoh_cpp 0.6.7)."""

from __future__ import annotations

import pytest

from intellwheels_agents.ros_gateway.rmw_wire import (
    LATCHED,
    NO_HASH,
    SENSOR_DATA,
    Attachment,
    EntityToken,
    NodeName,
    Qos,
    RosType,
    any_type_key,
    gid_of,
    nodes_of,
    read_attachment,
    read_token,
    topic_key,
    type_in,
)
from intellwheels_schemas.errors import WireError

ODOMETRY = RosType("nav_msgs/msg/Odometry", "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0")
SESSION = "8d4dcd11f64ab0d7f270127ac5728dc0"
NODE = NodeName(0, SESSION, 0, "/chair1", "golden")
ATTACHED = bytes.fromhex("0100000000000000e7809048e75eec18107e99993af6842c059b5778ce3d5b0679")


def test_key_and_token_are_those_of_the_real_node() -> None:
    dds = f"nav_msgs::msg::dds_::Odometry_/{ODOMETRY.hash}"
    assert topic_key(0, "/chair1/odom", ODOMETRY) == f"0/chair1/odom/{dds}"
    assert NODE.token() == f"@ros2_lv/0/{SESSION}/0/0/NN/%/%chair1/golden"
    token = NODE.entity_token(10, "MP", "/chair1/odom", ODOMETRY, Qos())
    assert token == f"@ros2_lv/0/{SESSION}/0/10/MP/%/%chair1/golden/%chair1%odom/{dds}/::,10:,:,:,,"


def test_a_node_of_the_root_has_a_percent_for_its_namespace() -> None:
    assert NodeName(7, SESSION, 3, "/", "n").token() == f"@ros2_lv/7/{SESSION}/3/3/NN/%/%/n"


@pytest.mark.parametrize(
    ("qos", "text"),
    [
        (Qos(), "::,10:,:,:,,"),
        (SENSOR_DATA, "2::,5:,:,:,,"),
        (LATCHED, ":1:,1:,:,:,,"),
        (Qos(depth=1, reliable=False), "2::,1:,:,:,,"),
    ],
)
def test_quality_of_service_is_that_of_the_real_node(qos: Qos, text: str) -> None:
    assert qos.text() == text


def test_attachment_of_the_real_node_is_read_and_written_to_the_byte() -> None:
    read = read_attachment(ATTACHED)
    assert read == Attachment(1, 0x18EC5EE7489080E7, bytes.fromhex("7e99993af6842c059b5778ce3d5b0679"))
    assert read.encoded() == ATTACHED


@pytest.mark.parametrize("data", [None, b"", ATTACHED[:-1], ATTACHED + b"\0", bytes(33)])
def test_another_attachment_is_refused(data: bytes | None) -> None:
    with pytest.raises(WireError, match="attachment: expected"):
        read_attachment(data)


def test_tokens_are_read_back() -> None:
    assert read_token(NODE.token()) == EntityToken("/chair1", "golden", "NN")
    token = NODE.entity_token(19, "SS", "/get_map", RosType("nav_msgs/srv/GetMap", NO_HASH), Qos())
    assert read_token(token) == EntityToken(
        "/chair1", "golden", "SS", "/get_map", "nav_msgs::srv::dds_::GetMap_", NO_HASH
    )


@pytest.mark.parametrize("key", ["", "0/x", "@ros2_lv/0/1/2/3/XX/%/%/n", "@ros2_lv/0/1/2/3/NN/%/%/n/a/b/c/d", "x/" * 8])
def test_another_key_is_no_token(key: str) -> None:
    assert read_token(key) is None


def test_expressions_and_what_they_match() -> None:
    assert any_type_key(3, "/chair1/cmd_vel") == "3/chair1/cmd_vel/*/*"
    assert nodes_of(0, "/chair1", "golden") == "@ros2_lv/0/*/*/*/NN/%/%chair1/golden"
    assert type_in("0/chair1/cmd_vel/a::b/RIHS01_c") == ("a::b", "RIHS01_c")


def test_ids_differ_and_follow_from_the_token() -> None:
    assert gid_of("a") == gid_of("a") != gid_of("b")
    assert len(gid_of("a")) == 16
