"""A node of the Rust crate hiroz, a client of ROS 2 that shares no code with us, in a world of `iw-ros`.

The first build of `tests/e2e/hiroz_peer` compiles Zenoh; see `languages.py` for the cache. The node comes through
`iw-router` with the session that hiroz makes by default, as that of rmw_zenoh.
"""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from intellwheels_agents.ros_gateway.floor_grid import floor_grid
from intellwheels_maps import floor
from tests.agents.ros_gateway.stand_in_node import HASHES
from tests.e2e import languages
from tests.e2e.stage import Stage

SOURCE = Path(__file__).parent / "hiroz_peer"
GATEWAY = "intellwheels_agents.ros_gateway"
PERIOD = 50_000_000
"""Nanoseconds of a tick."""
RESOLUTION = 0.1
CHAIR, WORLD = "/chair_1/intellwheels", "/intellwheels"
PUBLISHERS = {
    "/chair_1/odom": (CHAIR, "nav_msgs/msg/Odometry", "::,10:,:,:,,"),
    "/chair_1/scan": (CHAIR, "sensor_msgs/msg/LaserScan", "2::,5:,:,:,,"),
    "/tf": (CHAIR, "tf2_msgs/msg/TFMessage", "::,100:,:,:,,"),
    "/clock": (WORLD, "rosgraph_msgs/msg/Clock", "2::,1:,:,:,,"),
    "/map": (WORLD, "nav_msgs/msg/OccupancyGrid", ":1:,1:,:,:,,"),
}
SERVERS = ("SetSimulationState", "GetEntityState")


def copied(source: str, copy: str) -> str:
    """Copy a file that is not as the copy; what is unchanged is not built again."""
    if not Path(copy).exists() or Path(copy).read_bytes() != Path(source).read_bytes():
        shutil.copyfile(source, copy)
    return copy


@pytest.fixture(scope="module")
def program() -> Path:
    cargo, folder = languages.tool("cargo"), languages.CACHE / "hiroz_peer"
    found = folder / "target" / "debug" / "hiroz_peer"
    languages.need(found)
    shutil.copytree(SOURCE, folder, copy_function=copied, dirs_exist_ok=True)
    languages.build([cargo, "build", "--jobs", "1"], folder)
    return found


def yaw(pose: list[float]) -> float:
    """Return the heading of a pose: x, y, z and a quaternion about z."""
    assert pose[2:5] == [0.0, 0.0, 0.0]
    return 2.0 * math.atan2(pose[5], pose[6])


@pytest.mark.languages
def test_a_node_of_hiroz_sees_the_graph_reads_the_simulator_s_numbers_and_drives(stage: Stage, program: Path) -> None:
    where = ("--connect", stage.endpoint, "--world", stage.world)
    stage.line(stage.start("router", "intellwheels_server.service.router", "--listen", stage.endpoint), "ready")
    stage.simulator = stage.start("server", "intellwheels_server", *where, "--map", "room", "--pace", "realtime")
    stage.line(stage.simulator, "ready")
    with stage.peer() as peer:
        heard = peer.hear("out/chair-1/measures")
        words = ("--name", "chair-1", "--robot", "lidar-chair", "--domain", "0", "--resolution", str(RESOLUTION))
        stage.line(stage.start("ros", GATEWAY, *where, *words), "joined")
        start = peer.entities()["chair-1"]
        done = subprocess.run(
            [program, stage.endpoint, "chair_1", "chair-1"], capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode == 0, f"{done.stderr}{done.stdout[-4000:]}{stage.report()}"
        # The node paused the run, so this is the tick of its last answer.
        end = peer.entities()["chair-1"]
        measures = [json.loads(data) for _, data in list(heard)]
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    check_graph(lines)
    check_measures(lines, {round(one["Time"] * 1e9): one["Sensors"] for one in measures})
    check_world(lines, start, end)


def check_graph(lines: list[dict[str, Any]]) -> None:
    """Check nodes, types, hashes and qualities of service that hiroz read from the tokens."""
    publishers = {line["publisher"]: line for line in lines if "publisher" in line}
    for topic, (node, of, qos) in PUBLISHERS.items():
        package, folder, name = of.split("/")
        found = publishers[topic]
        assert (found["node"], found["type"]) == (node, f"{package}::{folder}::dds_::{name}_")
        assert (found["hash"], found["qos"]) == (f"RIHS01_{HASHES[of]}", qos)
    servers = {line["type"]: line["node"] for line in lines if "server" in line}
    for name in SERVERS:
        assert servers[f"simulation_interfaces::srv::dds_::{name}_"] == WORLD


def check_measures(lines: list[dict[str, Any]], sensors: dict[int, Any]) -> None:
    """Check odometry, scans and transforms against what the simulator sent, by time stamp in ns."""

    def heard(topic: str) -> list[dict[str, Any]]:
        return [line for line in lines if line.get("topic") == topic]

    poses = {}
    for line in heard("/chair_1/odom"):
        assert (line["frame"], line["child"]) == ("chair_1/odom", "chair_1/base_link")
        (reading,) = sensors[line["nanoseconds"]]["Odometry"]
        pose = poses[line["nanoseconds"]] = line["pose"]
        assert pose[:2] == [reading["X"], reading["Y"]]
        assert yaw(pose) == pytest.approx(reading["Heading"], abs=1e-9)
    assert len(poses) > 10
    scans = heard("/chair_1/scan")
    assert len(scans) > 10
    for line in scans:
        (reading,) = sensors[line["nanoseconds"]]["Lidar"]
        assert line["frame"] == "chair_1/lidar"
        assert math.degrees(line["first"]) == pytest.approx(reading["StartDeg"], abs=1e-4)
        assert math.degrees(line["step"]) == pytest.approx(reading["StepDeg"], abs=1e-6)
        assert line["ranges"] == [None if one is None else float(np.float32(one)) for one in reading["Ranges"]]
    driven = [one for line in heard("/tf") for one in line["transforms"] if one["child"] == "chair_1/base_link"]
    both = [one for one in driven if one["nanoseconds"] in poses]
    assert len(both) > 10
    assert all(one["transform"] == poses[one["nanoseconds"]] for one in both)
    times = [line["nanoseconds"] for line in heard("/clock")]
    assert times
    assert all(later > earlier and (later - earlier) % PERIOD == 0 for earlier, later in pairwise(times))


def check_world(lines: list[dict[str, Any]], start: dict[str, Any], end: dict[str, Any]) -> None:
    """Check the way of the chair, the late map and the answers of the services."""
    assert end["Travelled"] - start["Travelled"] > 0.45
    (grid,) = (line for line in lines if line.get("topic") == "/map")
    expected = floor_grid(floor("room"), RESOLUTION, 0.0)
    assert (grid["frame"], grid["width"], grid["height"]) == ("map", expected.info.width, expected.info.height)
    assert grid["resolution"] == float(np.float32(RESOLUTION))
    assert grid["data"] == expected.data.tolist()
    answers = {line["service"]: line for line in lines if "service" in line}
    assert answers["/set_simulation_state"]["result"] == 1
    state = answers["/get_entity_state"]
    assert (state["result"], state["frame"]) == (1, "map")
    assert state["pose"][:2] == [end["X"], end["Y"]]
    assert yaw(state["pose"]) == pytest.approx(end["Heading"], abs=1e-9)
