"""The process `iw-ros`: what it waits for, and what it refuses to be twice."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from intellwheels_agents.ros_gateway.gateway_process import OTHER_ROUTER
from intellwheels_schemas.files import write_file
from intellwheels_schemas.link import START_ONE
from intellwheels_schemas.messages import Identity, Lab, May
from intellwheels_server.service import lab_keys
from tests.agents.ros_gateway.stand_in_node import StandInNode
from tests.e2e.stage import Stage, run

pytestmark = pytest.mark.process
GATEWAY = "intellwheels_agents.ros_gateway"


def test_without_a_router_it_gives_up_in_time() -> None:
    done = run(GATEWAY, "--name", "c", "--connect", "tcp/127.0.0.1:1", "--retry-for", "0.5")
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        f"iw-ros: waiting why='nobody answers at tcp/127.0.0.1:1; {START_ONE}'",
        "iw-ros: nobody answers at tcp/127.0.0.1:1",
    ]


def test_second_gateway_of_a_world_or_a_chair_is_refused(tmp_path: Path) -> None:
    with Stage(tmp_path, "twice") as stage:
        stage.start("router", "intellwheels_server.service.router", "--listen", stage.endpoint)
        stage.line("router", "ready")
        where = ("--connect", stage.endpoint, "--world", stage.world)
        first = stage.start("first", GATEWAY, "--name", "chair-1", *where)
        stage.line(first, "ready")
        second = run(GATEWAY, *where)
        assert second.returncode == 1
        assert (
            second.stderr == "iw-ros: expected --no-world, as another iw-ros has the node /intellwheels, got a world\n"
        )
        third = run(GATEWAY, "--name", "chair_1", "--no-world", *where)
        assert third.returncode == 1
        assert "--name: expected a chair that no other iw-ros has, got /chair_1/intellwheels" in third.stderr
        stage.signal(first, signal.SIGTERM)
        assert stage.exit(first) == 0


def test_router_of_a_lab_is_no_router_of_ros_nodes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lab, own = tmp_path / "lab.xml", str(tmp_path / "student1.iwid")
    student = Identity(name="student1", may=(May(role="agent", agents=("st1-*",)),))
    lab.write_text(write_file(Lab(format="iw.v1", name="lab", identity=(student,))))
    with Stage(tmp_path, "main") as stage:
        invite = ["invite", "student1", "--lab", str(lab), "--connect", stage.endpoint, "--out", own]
        assert lab_keys.main(invite) == 0
        assert capsys.readouterr()
        stage.start("router", "intellwheels_server.service.router", "--lab", str(lab), "--listen", stage.endpoint)
        stage.line("router", "ready")
        done = run(GATEWAY, "--name", "st1-a", "--identity", own)
        assert (done.returncode, done.stdout, done.stderr) == (1, "", f"iw-ros: {OTHER_ROUTER}\n")
        # With a router for the nodes, it goes on.
        with Stage(tmp_path / "nodes", "main") as nodes:
            nodes.start("router", "intellwheels_server.service.router", "--listen", nodes.endpoint)
            nodes.line("router", "ready")
            child = stage.start("ros", GATEWAY, "--name", "st1-a", "--identity", own, "--ros-connect", nodes.endpoint)
            stage.line(child, "ready")


def test_simulator_and_nodes_may_meet_at_the_gateway(tmp_path: Path) -> None:
    with Stage(tmp_path, "meet") as stage:
        child = stage.start(
            "ros", GATEWAY, "--name", "c", "--robot", "lidar-chair", "--listen", stage.endpoint, "--world", stage.world
        )
        stage.line(child, "ready")
        stage.start(
            "server", "intellwheels_server", "--connect", stage.endpoint, "--world", stage.world, "--map", "room"
        )
        stage.line(child, "joined")
        with StandInNode(stage.endpoint) as node:
            odometry = node.hear("/c/odom", "nav_msgs/msg/Odometry")
            grid = node.hear("/map", "nav_msgs/msg/OccupancyGrid", latched=True)
            node.wait(lambda: odometry and grid, "odometry and the map")
        stage.signal(child, signal.SIGTERM)
        assert stage.exit(child) == 0
