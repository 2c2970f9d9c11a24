"""ROS 2 nodes in a world: simulator, `iw-ros` and a stand-in node that behaves as rmw_zenoh does. Real processes.

The stand-in shares no code with the gateway. It drives as a navigation stack does: it reads scan and odometry and
writes `cmd_vel`.
"""

from __future__ import annotations

import json
import math
import signal
import struct
import threading
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from tests.agents.ros_gateway.stand_in_node import (
    StandInNode,
    header,
    pose_stamped,
    seconds_of,
    twist,
    twist_stamped,
)
from tests.e2e.stage import Stage

GATEWAY = "intellwheels_agents.ros_gateway"
ODOMETRY, SCAN = "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan"
TWIST, TWIST_STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
PERIOD = 0.05


def gateway(stage: Stage, *words: str, ready: str = "joined") -> str:
    child = stage.start("ros", GATEWAY, "--connect", stage.endpoint, "--world", stage.world, *words)
    stage.line(child, "ready")
    stage.line(child, ready)
    return child


def steered(scan: Any) -> tuple[float, float]:
    """Return speed and turn rate: ahead where it is free, else towards the side that is."""
    near = [
        (scan.angle_min + index * scan.angle_increment, value)
        for index, value in enumerate(scan.ranges.tolist())
        if math.isfinite(value)
    ]
    ahead = min((value for angle, value in near if abs(angle) < 0.5), default=math.inf)
    left, right = (
        min((value for angle, value in near if 0.3 < side * angle < 1.6), default=math.inf) for side in (1.0, -1.0)
    )
    if ahead > 1.0:
        return 0.6, 0.4 if left > right + 0.3 else -0.4 if right > left + 0.3 else 0.0
    return 0.0, 0.8 if left > right else -0.8


def moved(odometry: Any) -> float:
    """Return the distance from the start, m."""
    position = odometry.pose.pose.position
    return math.hypot(position.x, position.y)


def request(*parts: bytes) -> bytes:
    return b"\0\1\0\0" + b"".join(parts)


def text(word: str, then: int = 4) -> bytes:
    """Return a string of CDR and the padding before what follows."""
    data = (len(word) + 1).to_bytes(4, "little") + word.encode() + b"\0"
    return data + bytes(-len(data) % then)


def test_a_node_drives_the_ward_in_real_time_and_nothing_that_it_sends_stops_the_gateway(stage: Stage) -> None:
    stage.server("--map", "ward", "--pace", "realtime")
    stage.agent("chair-1", "drive", "--role", "body", robot="lidar-chair")
    child = gateway(stage, "--name", "chair-1", "--role", "mind")
    with stage.peer() as peer, StandInNode(stage.endpoint) as node:
        events = peer.hear("event")
        odometry, scans = node.hear("/chair_1/odom", ODOMETRY), node.hear("/chair_1/scan", SCAN)
        clock = node.hear("/clock", "rosgraph_msgs/msg/Clock")
        frames = node.hear("/tf_static", "tf2_msgs/msg/TFMessage", latched=True)
        grid = node.hear("/map", "nav_msgs/msg/OccupancyGrid", latched=True)
        node.wait(lambda: odometry and scans and clock and frames and grid, "all topics")
        assert (grid[0].info.width, grid[0].info.height, grid[0].header.frame_id) == (849, 308, "map")
        assert {one.child_frame_id for one in frames[0].transforms} == {"chair_1/lidar", "chair_1/imu"}
        topics = node.wait(lambda: node.entities("MP"), "topics")
        assert topics["/chair_1/scan"][1:] == (*node.key("/s", SCAN).split("/")[2:], "2::,5:,:,:,,")

        began = len(scans)

        def drives() -> bool:
            node.put("/chair_1/cmd_vel", TWIST, twist(*steered(scans[-1])))
            return bool(len(scans) > began + 20 and moved(odometry[-1]) > 1.0)

        node.wait(drives, "a chair that has driven a metre")
        stamps = [seconds_of(one.header.stamp) for one in list(odometry)]
        assert all(round((later - earlier) / PERIOD, 6) >= 1.0 for earlier, later in pairwise(stamps))
        # Silence stops the chair, and so do velocities that are none.
        key = node.key("/chair_1/cmd_vel", TWIST)
        good = request(bytes(48))
        hostile = [
            (key, b"", node.attachment()), (key, b"\xff" * 60, node.attachment()),
            (key, bytes(100_000), node.attachment()), (key, good, None), (key, good, b"short"),
            (key + "0", good, node.attachment()),
            (key, request(bytes.fromhex("000000000000f87f") * 6), node.attachment()),
        ]  # fmt: skip

        def stands() -> bool:
            for one in hostile:
                node.raw(*one)
            return bool(abs(odometry[-1].twist.twist.linear.x) < 1e-3)

        node.wait(stands, "a chair that stands")

        def drives_again() -> bool:
            stamp = seconds_of(clock[-1].clock)
            node.put("/chair_1/cmd_vel", TWIST_STAMPED, twist_stamped(0.3, 0.0, stamp, "chair_1/base_link"))
            return bool(odometry[-1].twist.twist.linear.x > 0.05)

        node.wait(drives_again, "a chair that drives again")
        assert not [event for event in list(events) if json.loads(event[1])["Code"] == "contact"]
        stage.signal(child, signal.SIGTERM)
        assert stage.exit(child) == 0
        node.wait(lambda: not [token for token in node.graph if "chair_1" in token], "a graph without the chair")


def test_services_control_the_world(stage: Stage) -> None:
    stage.server("--map", "room", "--pace", "realtime")
    child = stage.start("ros", GATEWAY, "--connect", stage.endpoint, "--world", stage.world)
    stage.line(child, "ready")
    with StandInNode(stage.endpoint) as node:
        clock = node.hear("/clock", "rosgraph_msgs/msg/Clock")
        ok = request(b"\1\0\0\0" + text("", 1))
        for state in (2, 1, 2):  # paused, playing, paused
            assert node.call("/set_simulation_state", request(bytes([state]))) == ok
        assert node.call("/get_simulation_state", request(b"\0")) == request(b"\2\1\0\0" + text("", 1))
        node.wait(lambda: len(clock) > 1, "the clock")
        node.wait(lambda: seconds_of(clock[-1].clock) == seconds_of(clock[-2].clock), "a clock that stands")
        before = seconds_of(clock[-1].clock)
        assert node.call("/step_simulation", request((5).to_bytes(8, "little"))) == ok
        node.wait(lambda: seconds_of(clock[-1].clock) == pytest.approx(before + 5 * PERIOD), "five steps")
        pose = struct.pack("<7d", 3.0, 3.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        names = text("crate1", 1) + b"\0" + bytes(-(4 + 7 + 1) % 4) + text("crate") + text("") + text("") + bytes(8)
        spawn = names + text("map")
        spawned = node.call("/spawn_entity", request(spawn + bytes(-len(spawn) % 8) + pose))
        assert spawned is not None
        assert spawned[4] == 1, spawned
        assert b"crate1" in spawned
        listed = node.call("/get_entities", request(text("") + bytes(4) + bytes(4) + bytes(4) + bytes(4)))
        assert listed is not None
        assert b"crate1" in listed
        again = node.call("/spawn_entity", request(spawn + bytes(-len(spawn) % 8) + pose))
        assert again is not None
        assert again[4] == 101
        assert node.call("/delete_entity", request(text("crate1", 1))) == ok
        gone = node.call("/delete_entity", request(text("crate1", 1)))
        assert gone is not None
        assert gone[4] == 2
        # Bytes that are no request get no answer, and the next request does.
        for wrong in (b"", b"\xff" * 40, request(b"\xff\xff\xff\x7f"), bytes(3)):
            assert node.call("/spawn_entity", wrong, timeout=0.3) is None
        assert node.call("/delete_entity", request(text("x", 1)), attachment=b"", timeout=0.3) is None
        assert node.call("/get_simulation_state", request(b"\0")) is not None


def test_in_lockstep_the_clock_paces_a_node_and_the_run_can_be_repeated(stage: Stage) -> None:
    stage.server("--map", "ward", "--pace", "lockstep", "--expect", "chair1")
    with StandInNode(stage.endpoint) as node:
        scans, odometry = node.hear("/chair1/scan", SCAN), node.hear("/chair1/odom", ODOMETRY)
        clock = node.hear("/clock", "rosgraph_msgs/msg/Clock")
        gateway(stage, "--name", "chair1", "--robot", "lidar-chair", "--place", "lobby1", "--await", "30")
        stamps = [0.0]

        def drive(over: Callable[[], bool]) -> None:
            """Answer each scan with the velocity of its stamp."""
            while not over():
                node.wait(lambda: len(scans) >= len(stamps), "a scan")
                scan = scans[len(stamps) - 1]
                stamps.append(seconds_of(scan.header.stamp))
                command = twist_stamped(*steered(scan), stamps[-1], "chair1/base_link")
                node.put("/chair1/cmd_vel", TWIST_STAMPED, command)

        drive(lambda: stamps[-1] >= 4.0)
        reply: list[bytes | None] = []
        asking = threading.Thread(target=lambda: reply.append(node.call("/reset_simulation", request(b"\0"))))
        asking.start()
        # A tick is never left half done, so the run begins again after an answer.
        drive(lambda: stamps[-1] < stamps[-2])
        asking.join(node.deadline)
        assert reply == [request(b"\1\0\0\0" + text("", 1))]
        drive(lambda: stamps[-1] >= 4.0)

        def path(run: int) -> list[tuple[float, float, float]]:
            """Return time and place by the odometry of the first or the second run."""
            places = [(seconds_of(one.header.stamp), one.pose.pose.position) for one in list(odometry)]
            (second,) = [index for index in range(1, len(places)) if places[index][0] < places[index - 1][0]]
            part = places[second:] if run == 2 else places[:second]
            return [(time, place.x, place.y) for time, place in part if time < 4.0]

        node.wait(lambda: len(path(2)) == len(path(1)), "the odometry of both runs")
        assert path(2) == path(1)
        assert math.hypot(*path(1)[-1][1:]) > 1.0
        times = [seconds_of(one.clock) for one in list(clock)]
        steps = {round(b - a, 6) for a, b in pairwise(times)}
        assert {step for step in steps if step > 0.0} == {PERIOD}


def test_goal_of_ros_is_that_of_the_mind_that_drives(stage: Stage) -> None:
    stage.server("--map", "room", "--pace", "realtime")
    stage.agent("chair1", "waypoints", "--option", "points=6 1", robot="lidar-chair")
    child = gateway(stage, "--name", "chair1", "--role", "watch", "--no-world", ready="watching")
    with stage.peer() as peer, StandInNode(stage.endpoint) as node:
        states = peer.hear("state/*")
        odometry = node.hear("/chair1/odom", ODOMETRY)
        node.wait(lambda: odometry, "odometry")
        wrong = pose_stamped(2.0, 1.0, 0.0)
        wrong.header = header("elsewhere", 0.0)
        node.put("/chair1/goal_pose", "geometry_msgs/msg/PoseStamped", wrong)
        node.put("/chair1/goal_pose", "geometry_msgs/msg/PoseStamped", pose_stamped(4.5, 3.5, 0.5))

        def goal() -> Any:
            (entity,) = json.loads(states[-1][1])["Entity"] if states else [{}]
            return entity.get("Goal")

        node.wait(lambda: (found := goal()) and (found["X"], found["Y"]) == (4.5, 3.5), "the goal of the mind")
        stage.signal(child, signal.SIGTERM)
        assert stage.exit(child) == 0
