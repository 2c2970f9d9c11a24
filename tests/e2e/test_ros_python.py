"""Messages of the gateway, read by the Python packages of ROS 2 itself. They need a Python 3.12 of their own:

    python3.12 -m venv /tmp/ros && /tmp/ros/bin/pip install 'ros-rclpy[fastrtps]' ros-nav-msgs ros-sensor-msgs \
        ros-diagnostic-msgs ros-rosgraph-msgs
    ROS_PYTHON=/tmp/ros/bin/python pytest -m languages tests/e2e/test_ros_python.py
"""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import pytest

from intellwheels_agents.ros_gateway.chair_messages import ChairMessages
from intellwheels_agents.ros_gateway.floor_grid import floor_grid
from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.ros_types import decode_message, encode_message, ros_type
from intellwheels_maps import floor, robot
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Actions
from intellwheels_server.world import Setup, advance, apply, begin, measures
from tests.agents.ros_gateway.stand_in_node import pose_stamped, twist, twist_stamped

READER = """
import glob, importlib, json, sys
from rclpy.serialization import deserialize_message, serialize_message
given = json.load(sys.stdin)
found, hashes = [], {}
for name, data in given:
    package, _, kind = name.split("/")
    module = importlib.import_module(package + ".msg")
    message = deserialize_message(bytes.fromhex(data), getattr(module, kind))
    found.append(serialize_message(message).hex())
    root = module.__file__.rsplit("/site-packages/", 1)[0].rsplit("/lib/", 1)[0]
    for file in glob.glob(f"{root}/**/{package}/msg/{kind}.json", recursive=True)[:1]:
        hashes[name] = {one["type_name"]: one["hash_string"] for one in json.load(open(file))["type_hashes"]}[name]
json.dump([found, hashes], sys.stdout)
"""
"""Reads messages, writes them again, and looks up their hashes."""

TF = "tf2_msgs/msg/TFMessage"
"""No package of it is on the index."""


def written() -> list[tuple[str, bytes]]:
    """Return messages of two chairs that drive, and those of the world."""
    found = [
        twist(0.5, 0.1),
        twist_stamped(0.5, 0.1, 1.25, "x"),
        pose_stamped(1.0, 2.0, 0.5),
        floor_grid(floor("room"), 0.1, 3.0),
    ]
    for name in ("lidar-chair", "intellwheels"):
        state = begin(Setup(floor=floor("room"), seed="1"), run="0123456789abcdef")
        state, _ = apply(state, [Join(agent="c", robot=robot(name))])
        chair = ChairMessages("c", robot(name), 0.05, PlanePose(1.0, 2.0, 0.5))
        for _ in range(5):
            state, _ = advance(state, Inputs(actions={"c": Actions(left_motor=0.5, right_motor=0.6)}))
            found += [one.message for one in chair.messages(measures(state, "c"))]
    return [(message.__msgtype__, encode_message(message)) for message in found if message.__msgtype__ != TF]


@pytest.mark.languages
def test_ros_reads_every_message_and_has_the_same_hashes() -> None:
    python = os.environ.get("ROS_PYTHON")
    if python is None or not Path(python).exists():
        pytest.skip("ROS_PYTHON names no Python with the packages of ROS 2")
    given = written()
    done = subprocess.run(
        [python, "-c", READER], input=json.dumps([(name, data.hex()) for name, data in given]), capture_output=True,
        text=True, timeout=120, check=False, cwd="/",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    again, hashes = json.loads(done.stdout)
    for (name, data), back in zip(given, again, strict=True):
        # ROS leaves what was in memory in padding bytes, and may add some at the end. So what ROS wrote is read and
        # written here.
        assert encode_message(decode_message(name, bytes.fromhex(back)[: len(data)])) == data, name
    assert hashes == {name: ros_type(name).hash for name in {name for name, _ in given}}
