"""A robot whose agent speaks in datagrams: the mind, and when it leaves."""

from __future__ import annotations

import socket
import threading

import pytest

from intellwheels_agents.ciber_gateway.ciber_robot import TOP_SPEED
from intellwheels_agents.ciber_gateway.client_socket import ClientSocket, Reports
from intellwheels_agents.ciber_gateway.robot_client import MOST_A_TICK, CiberMind, Waits
from intellwheels_agents.ciber_gateway.robot_state import RobotState
from intellwheels_agents.ciber_gateway.simulator_messages import Settings
from intellwheels_schemas.messages import Measures, Robot
from tests.agents.ciber_gateway.stand_in_clients import cut
from tests.agents.ciber_gateway.test_robot_state import FLOOR, RUN

pytestmark = pytest.mark.process


class Pair:
    """A mind and the agent at the other end of its port."""

    def __init__(self, waits: Waits) -> None:
        self.lines: list[str] = []
        self.agent = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.agent.bind(("127.0.0.1", 0))
        self.agent.settimeout(25.0)
        reports = Reports(self.lines.append)
        self.client = ClientSocket("127.0.0.1", self.agent.getsockname(), reports)
        self.state = RobotState(1, "R", "r", Settings())
        self.state.begin(Robot(top_speed=TOP_SPEED), 0.05, RUN, FLOOR)
        self.stop = threading.Event()
        self.mind = CiberMind(self.state, self.client, reports, waits, dict, self.stop)

    def decide(self, tick: int) -> float:
        left = self.mind.decide(Measures(run=RUN, tick=tick, time=tick * 0.05)).left_motor
        assert left is not None
        return left * TOP_SPEED * 0.05

    def send(self, data: bytes) -> None:
        self.agent.sendto(data, ("127.0.0.1", self.client._socket.getsockname()[1]))

    def close(self) -> None:
        self.agent.close()
        self.client.close()


def test_the_answer_to_measures_counts_for_their_tick() -> None:
    pair = Pair(Waits(answer=25.0))

    def answer() -> None:
        for power in ("0.1", "0.05"):
            assert cut(pair.agent.recv(4096)).tag == "Measures"
            pair.send(f'<Actions LeftMotor="{power}"/>'.encode())

    thread = threading.Thread(target=answer)
    thread.start()
    assert [pair.decide(1), pair.decide(2)] == pytest.approx([0.1, 0.05])
    thread.join()
    pair.close()


def test_wrong_actions_are_reported_and_the_last_powers_count() -> None:
    pair = Pair(Waits(answer=0.0))
    pair.send(b'<Actions LeftMotor="0.1"/>')
    for data in (b"", b"<", b'<Actions LeftMotor="nan"/>', b"x" * 5000, b"\0", b'<Actions LeftMotor="'):
        pair.send(data)
    pair.send(b'<Actions><SensorRequests Wings="Yes"/></Actions>')
    pair.send(b"<Actions><Say>" + b"x" * 101 + b"</Say></Actions>")
    assert pair.decide(1) == pytest.approx(0.1)
    assert [line.partition(" from")[0] for line in pair.lines] == [
        "dropped what='actions' count=1", "dropped what='sensor requests' count=1",
        "dropped what='message of a robot' count=1",
    ]  # fmt: skip
    pair.close()


def test_a_flood_does_not_hold_up_a_tick() -> None:
    pair = Pair(Waits(answer=0.0))
    for _ in range(3 * MOST_A_TICK):
        pair.send(b'<Actions LeftMotor="0.1"/>')
    assert pair.decide(1) == pytest.approx(0.1)
    assert pair.client.receive() is not None
    pair.close()


def test_a_silent_agent_leaves() -> None:
    pair = Pair(Waits(answer=0.0, silence=-1.0))
    pair.decide(1)
    assert pair.stop.is_set()
    assert "silent agent" in pair.lines[0]
    pair.close()


def test_whatever_an_agent_sends_it_is_not_silent_then() -> None:
    pair = Pair(Waits(answer=0.0, silence=0.0))
    for data in (b"<Actions/>", b"<"):
        pair.send(data)
        pair.decide(1)
        assert not pair.stop.is_set()
    pair.decide(2)
    assert pair.stop.is_set()
    pair.close()


def test_a_pause_of_the_world_is_no_silence(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = Pair(Waits(answer=0.0, silence=60.0))
    monkeypatch.setattr(pair.mind, "_last", pair.mind._last - 3600.0)
    pair.decide(1)
    assert not pair.stop.is_set()
    pair.close()
