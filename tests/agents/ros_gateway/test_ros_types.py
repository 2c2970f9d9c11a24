"""Hashes and bytes of messages, against those of a real node and of the C code of `simulation_interfaces`."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.ros_gateway.ros_types import blank, decode_message, encode_message, ros_type
from intellwheels_agents.ros_gateway.simulation_types import SERVICES
from intellwheels_schemas.errors import WireError
from tests.agents.ros_gateway.stand_in_node import HASHES
from tests.every_case import every_case

OF_THE_C_CODE = {
    "SpawnEntity": "66860313e11009faddbfc8568e5d410d1a11607fe75eeb1308671dc0406fe3a7",
    "ResetSimulation": "4ce285d7ff9b8ac70dcc95161f32bf54c05a6f4b13427990e41ab40c36c39646",
    "StepSimulation": "913fe0653690ce6bf8f09f316e6a626747012e9fca31e26719910d417aa8565c",
    "GetNamedPoses": "c3d12ab920115bfd4733f6d20516adc3968fb438538540997c37e200e02b04e3",
    "GetSpawnables": "3e25fd827d8bcbd9db5e36ccb190efa22d6f6313897861268ab923bf091a992a",
    "LoadWorld": "87d0ded1bfddb40a74d0bedb963fdd592fbedb14d0057d597850404b73c338af",
    "GetEntitiesStates": "0a76170d0c1c90e1eaf805cfab78ea801d1f82df309a28c1f0fae4b570f19754",
    "GetAvailableWorlds": "ce5589b5523f2732d1969a3c5a7e6b17a387091df8190c62f78d7fdd1109e3e3",
    "GetCurrentWorld": "79ed4e910e1b7a1c9f7950ff758bfba3535bf0dec669054e8af115a099724ddd",
    "GetEntities": "cb90004c48cd50f37732fb008e22c34c261dd680a723bf0f85d8437ea4498bf7",
    "GetSimulationState": "3362dcebee4b1afebbf9c4beee5c79c1455385aded62092a892d61fde8644f30",
}
"""Hashes in the C code that ROS generated for the package."""

PAYLOADS = {
    "sensor_msgs/msg/LaserScan": (
        "000100000c000000404890140d0000006368616972312f6c69646172000000000000c0bf0000c03f0000c03f0000000000000000cdcccc3d"
        "00008040030000000000803f0000807f0000204000000000"
    ),
    "sensor_msgs/msg/Range": (
        "000100000c000000404890140d0000006368616972312f66726f6e74000000000000003fcdcc4c3d000080400000a03f00000000"
    ),
    "geometry_msgs/msg/Twist": (
        "000100009a9999999999d93f00000000000000000000000000000000000000000000000000000000000000009a9999999999c9bf"
    ),
    "geometry_msgs/msg/TwistStamped": (
        "000100000c00000040489014110000006368616972312f626173655f6c696e6b000000009a9999999999d93f000000000000000000000000"
        "00000000000000000000000000000000000000009a9999999999c9bf"
    ),
    "rosgraph_msgs/msg/Clock": "000100000c00000040489014",
}
"""Messages of the real node."""


@every_case("name", [name for name, known in HASHES.items() if known])
def test_hash_of_a_message_is_that_of_the_real_node(name: str) -> None:
    assert ros_type(name).hash == f"RIHS01_{HASHES[name]}"


@every_case("name", OF_THE_C_CODE)
def test_hash_of_a_service_is_that_of_its_package(name: str) -> None:
    assert ros_type(f"simulation_interfaces/srv/{name}").hash == f"RIHS01_{OF_THE_C_CODE[name]}"


@pytest.mark.parametrize("name", PAYLOADS)
def test_message_of_the_real_node_is_read_and_written_to_the_byte(name: str) -> None:
    data = bytes.fromhex(PAYLOADS[name])
    assert encode_message(decode_message(name, data)) == data


def test_values_of_the_real_node_are_read() -> None:
    scan = decode_message("sensor_msgs/msg/LaserScan", bytes.fromhex(PAYLOADS["sensor_msgs/msg/LaserScan"]))
    assert (scan.header.stamp.sec, scan.header.stamp.nanosec, scan.header.frame_id) == (12, 345_000_000, "chair1/lidar")
    assert (scan.angle_min, scan.angle_increment, scan.ranges.tolist()) == (-1.5, 1.5, [1.0, math.inf, 2.5])


def test_dds_name() -> None:
    assert ros_type("simulation_interfaces/srv/SpawnEntity").dds == "simulation_interfaces::srv::dds_::SpawnEntity_"


@every_case("name", SERVICES)
def test_every_service_has_blank_messages_that_can_be_sent(name: str) -> None:
    for part in ("Request", "Response"):
        message = blank(f"simulation_interfaces/srv/{name}_{part}")
        data = encode_message(message)
        assert encode_message(decode_message(message.__msgtype__, data)) == data


def test_empty_request_is_one_padding_byte() -> None:
    assert encode_message(blank("simulation_interfaces/srv/GetCurrentWorld_Request")) == b"\0\1\0\0\0"


@every_case("cut", range(0, 50, 7))
def test_truncated_bytes_are_refused(cut: int) -> None:
    data = bytes.fromhex(PAYLOADS["geometry_msgs/msg/Twist"])[:cut]
    with pytest.raises(WireError, match=r"geometry_msgs/msg/Twist: expected a message in CDR, got \d+ bytes"):
        decode_message("geometry_msgs/msg/Twist", data)


@every_case("data", [
    b"\0\1\0\0" + b"\xff" * 64, b"\0\1\0\0" + b"\xff\xff\xff\x7f" * 30, b"\0\1\0\0\x05\0\0\0\xff\xfe\xfd\xfc\0",
    b"\0\x03\0\0" + bytes(60), bytes(4000), b"\0\1\0\0" + b"\x01\0\0\0" * 500,
])  # fmt: skip
@every_case("name", ["SpawnEntity", "GetEntities", "SetEntityState", "LoadWorld"])
def test_other_bytes_are_refused(name: str, data: bytes) -> None:
    with pytest.raises(WireError):
        decode_message(f"simulation_interfaces/srv/{name}_Request", data)
