"""Agents and a viewer of the Ciber-Rato simulator in a lab: simulator, `iw-ciber`, and clients that are not ours."""

from __future__ import annotations

import signal
import socket

import pytest

from tests.agents.ciber_gateway.stand_in_clients import GRID, LAB, Agent, Viewer
from tests.e2e.stage import Stage

GATEWAY = "intellwheels_agents.ciber_gateway"
QUIET = ("--obstacle-noise", "0", "--option", "MotorNoise=0", "--option", "Compass.NoiseDeg=0",
         "--option", "Beacon.NoiseDeg=0", "--option", "GPS.Noise=0", "--option", "GPS.Step=0")  # fmt: skip


def lab(stage: Stage, *words: str, pace: str) -> int:
    """Start a simulator with a lab, and a gateway; return the port of registrations."""
    (stage.folder / "MyLab.xml").write_bytes(LAB)
    (stage.folder / "MyGrid.xml").write_bytes(GRID)
    stage.server("--map", str(stage.folder / "MyLab.xml"), "--pace", pace)
    child = stage.start(
        "ciber", GATEWAY, "--port", "0", "--connect", stage.endpoint, "--world", stage.world, *words
    )  # fmt: skip
    line = stage.line(child, "ready")
    assert (line["starts"], line["beacons"], line["targets"]) == ("3", "1", "1")
    return int(line["port"])


@pytest.mark.process
def test_an_agent_drives_in_lockstep_by_the_law_of_its_robot_and_a_viewer_follows(stage: Stage) -> None:
    port = lab(stage, "--gps", "--await", "8", *QUIET, pace="lockstep")
    viewer = Viewer(port)
    agent = Agent("Roland 1", 2, port, [0, 90, -90, 180])
    assert agent.accepted
    assert (agent.parameters["CycleTime"], agent.parameters["NBeacons"]) == ("50", "1")
    first = agent.read()
    # A corner of the wall is 2.7 m ahead, and the border 1.5 m away on the left and behind.
    assert (first.obstacles[0], first.obstacles[1], first.obstacles[3]) == (0.4, 0.7, 0.7)
    assert (first.compass, first.ground, first.collision, first.beacons, first.start) == (0, -1, False, {0: 0}, True)
    assert first.gps == pytest.approx((2.0, 6.0))
    # In place the robot turns by the difference of both powers over its diameter: here 0.1 rad in a cycle, after a lag.
    agent.drive(-0.05, 0.05)
    for _ in range(9):
        agent.read()
        agent.drive(-0.05, 0.05)
    turned = agent.read()
    assert turned.time == first.time + 10
    assert turned.compass == pytest.approx(50.0, abs=6.0)
    # Full power and more: 0.15 in a cycle.
    agent.drive(0.0, 0.0)
    while (sensed := agent.read()).time < turned.time + 15:
        agent.drive(0.0, 0.0)
    began = sensed
    agent.drive(9.0, 9.0)
    for _ in range(9):
        sensed = agent.read()
        agent.drive(9.0, 9.0)
    assert sensed.gps is not None
    assert began.gps is not None
    moved = ((sensed.gps[0] - began.gps[0]) ** 2 + (sensed.gps[1] - began.gps[1]) ** 2) ** 0.5
    assert moved == pytest.approx(0.15 * 9 - 0.15, abs=0.12)
    # Until it meets the border.
    while not sensed.collision:
        sensed = agent.read()
        agent.drive(0.15, 0.15)
    while viewer.robots.get(2, {}).get("Collisions") != "1":
        viewer.read()
    assert viewer.lab is not None
    assert viewer.lab.attrib == {"Name": "Small Lab", "Height": "8", "Width": "12"}
    assert viewer.grid is not None
    assert len(viewer.grid) == 3
    shown = viewer.robots[2]
    assert (shown["Name"], shown["State"]) == ("Roland 1", "Running")
    assert float(shown["Y"]) > 7.0
    # The end: it stands still, and the viewer is told.
    agent.send('<Actions LeftMotor="0.15" RightMotor="0.15" EndLed="On"/>')
    while not agent.read().leds["EndLed"]:
        agent.drive(0.15, 0.15)
    while viewer.robots[2]["State"] != "Finished":
        agent.drive(0.0, 0.0)
        viewer.read()
    agent.close()
    viewer.close()


@pytest.mark.process
def test_two_agents_hear_each_other_and_no_datagram_stops_them(stage: Stage) -> None:
    port = lab(stage, "--silence", "60", "--requestable", "compass", pace="realtime")
    agents = [Agent("Rob", 0, port), Agent("Rob", 0, port)]
    assert [agent.accepted for agent in agents] == [True, True]
    late = Agent("Late", 1, port)
    assert not late.accepted
    late.close()
    hostile = (b"", b"<Actions", b"\0" * 3000, b"x" * 60_000, b'<Actions LeftMotor="NaN"/>',
               b'<!DOCTYPE a [<!ENTITY b "ha"><!ENTITY c "&b;&b;">]><Actions><Say>&c;</Say></Actions>',
               b"<Actions>" + b"<Say>" * 900, b'<Robot Name="\xff"/>')  # fmt: skip
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        for data in hostile * 5:
            stranger.sendto(data, ("127.0.0.1", port))
            stranger.sendto(data, agents[0].address)
            agents[0].send(data)
        for _ in range(500):
            stranger.sendto(b'<Actions LeftMotor="0.15" RightMotor="0.15"/>', agents[1].address)
    # A datagram is lost while others fill the buffer of its port, so it is sent again.
    while not (sensed := agents[1].read()).heard:
        assert sensed.compass is None
        agents[0].send("<Actions><Say><![CDATA[to <all>]]></Say></Actions>")
        agents[1].send("<Actions/>")
    assert sensed.heard[0] == (1, "to <all>")
    while agents[0].read().compass is None:
        agents[0].send("<Actions><SensorRequests Compass='Yes'/></Actions>")
    with stage.peer() as peer:
        # What strangers send moves nobody.
        assert abs(peer.entities()["rob-2"].get("Speed", 0.0)) == 0.0
        while peer.entities()["rob-2"].get("Speed", 0.0) < 0.5:
            agents[1].drive(0.05, 0.05)
            agents[1].read()
        assert peer.ctl("pause")["Code"] == "ok"
        while not (sensed := agents[1].read()).stop:
            pass
        assert not sensed.start
        peer.ctl("resume")
        while agents[1].read().stop:
            pass
    stage.signal("ciber", signal.SIGTERM)
    assert stage.exit("ciber") == 0
    log = stage.log("ciber")
    for what in ("registration", "actions", "datagram of a stranger"):
        assert f"dropped what='{what}' count=1 " in log
    for agent in agents:
        agent.close()
