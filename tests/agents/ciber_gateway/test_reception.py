"""Registrations, and what viewers ask for, without a world."""

from __future__ import annotations

import re
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest

from intellwheels_agents.ciber_gateway.client_messages import Registration, ViewCommand
from intellwheels_agents.ciber_gateway.client_socket import Reports
from intellwheels_agents.ciber_gateway.lab_frame import lab_of
from intellwheels_agents.ciber_gateway.reception import MOST_COMMANDS, MOST_VIEWERS, Reception
from intellwheels_agents.ciber_gateway.robot_client import Waits
from intellwheels_agents.ciber_gateway.simulator_messages import Settings
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import NAME_PATTERN, Corner, Map, Robot, Wall
from tests.agents.ciber_gateway.stand_in_clients import TIMEOUT, Viewer, cut
from tests.agents.ciber_gateway.test_robot_state import FLOOR

pytestmark = pytest.mark.process


@contextmanager
def opened(lines: list[str]) -> Iterator[Reception]:
    reception = Reception(
        "127.0.0.1", 0, where=Link("nobody", connect=("tcp/127.0.0.1:1",)), lab=FLOOR, settings=Settings(),
        waits=Waits(), gps=False, beacons=True, beacon_height=2.0, changes={}, reports=Reports(lines.append),
        tell=lambda _line: None,
    )  # fmt: skip
    stop = threading.Event()
    thread = threading.Thread(target=reception.run, args=(stop,))
    thread.start()
    try:
        yield reception
    finally:
        stop.set()
        thread.join()
        reception.close()


def refusal(port: int, data: bytes) -> dict[str, str]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(TIMEOUT)
        client.sendto(data, ("127.0.0.1", port))
        return dict(cut(client.recvfrom(1024)[0]).attrib)


def test_what_is_no_registration_is_refused_and_reported() -> None:
    lines: list[str] = []
    with opened(lines) as reception:
        hostile = (b"", b"<Robot", b"x" * 60_000, b"<Panel/>", b'<Robot Name="r" Id="9"/>',
                   b'<!DOCTYPE a [<!ENTITY b "c">]><View/>')  # fmt: skip
        assert all(refusal(reception.port, data) == {"Status": "Refused"} for data in hostile)
        assert reception.robots == {}
    assert len(lines) == 1
    assert "registration" in lines[0]


def test_a_refusal_is_not_answered() -> None:
    lines: list[str] = []
    with opened(lines) as reception, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(TIMEOUT)
        client.sendto(b'<Reply Status="Refused"></Reply>', ("127.0.0.1", reception.port))
        client.sendto(b"<View/>", ("127.0.0.1", reception.port))
        assert cut(client.recvfrom(1024)[0]).attrib == {"Status": "Ok"}
    assert "got 'Reply'" in lines[0]


def test_viewers_get_lab_grid_and_what_is_shown_and_their_commands_wait() -> None:
    lines: list[str] = []
    with opened(lines) as reception:
        viewer = Viewer(reception.port)
        assert [viewer.read(), viewer.read()] == ["Lab", "Grid"]
        for data in (b"<Start/>\0", b"<", b'<Robot Id="2" Removed="Yes"/>'):
            viewer.send(data)
        assert reception.commands.get(timeout=TIMEOUT) == ViewCommand("start")
        assert reception.commands.get(timeout=TIMEOUT) == ViewCommand("remove", 2)
        reception.show([b"<Restart/>\0"])
        assert viewer.read() == "Restart"
        reception.change_lab(FLOOR)
        corners = tuple(Corner(x=x, y=y) for x, y in ((0, 0), (9, 0), (9, 7)))
        reception.change_lab(lab_of(Map(format="iw.v1", name="other", wall=(Wall(corner=corners),))))
        assert [viewer.read(), viewer.read()] == ["Lab", "Grid"]
        viewer.close()
    assert "command of a viewer" in lines[0]


def test_commands_that_nobody_obeys_do_not_pile_up() -> None:
    lines: list[str] = []
    with opened(lines) as reception:
        viewer = Viewer(reception.port)
        assert [viewer.read(), viewer.read()] == ["Lab", "Grid"]
        for _ in range(MOST_COMMANDS + 1):
            viewer.send(b"<Start/>")
        # It is answered after all that came before it.
        viewer.send(b"<GridReq/>")
        assert viewer.read() == "Grid"
        assert reception.commands.qsize() == MOST_COMMANDS
        viewer.close()
    assert "expected at most 64 that wait" in lines[0]


def test_the_oldest_viewer_goes_for_another() -> None:
    lines: list[str] = []
    with opened(lines) as reception:
        viewers = [Viewer(reception.port) for _ in range(MOST_VIEWERS + 1)]
        reception.show([b"<Restart/>\0"])
        while viewers[-1].read() != "Restart":
            pass
        for viewer in viewers:
            viewer.close()
    assert "at most 8 viewers" in lines[0]


def test_a_lab_that_no_datagram_holds_is_reported() -> None:
    lines: list[str] = []
    wall = Wall(corner=tuple(Corner(x=x, y=y) for x, y in ((0, 0), (9, 0), (9, 7))))
    with opened(lines) as reception:
        reception.change_lab(lab_of(Map(format="iw.v1", name="huge", wall=(wall,) * 2000)))
        viewer = Viewer(reception.port)
        assert viewer.read() == "Grid"
        viewer.close()
    assert "expected a lab of at most 65507 bytes" in lines[0]


def test_every_robot_has_a_name_of_its_own_that_the_contract_allows() -> None:
    names = ["x-2", "x", "x", "4" * 64, "4" * 64, "-Ação-"]
    with opened([]) as reception:
        agents = []
        for name in names:
            agents.append(reception._agent_of(name, 2))
            reception.robots["127.0.0.1", len(agents)] = SimpleNamespace(  # type: ignore[assignment]
                state=SimpleNamespace(agent=agents[-1]), stop=list, join=list
            )
    assert agents == ["x-2", "x", "x-3", "robot-" + "4" * 18, "robot-" + "4" * 18 + "-2", "a-o"]
    assert all(re.match(NAME_PATTERN, agent) for agent in agents)


def test_an_agent_that_registers_again_gets_its_reply_again() -> None:
    sent: list[bytes] = []
    robot: Any = SimpleNamespace(
        reply=b"reply", client=SimpleNamespace(send=sent.append), stop=list, join=list,
        state=SimpleNamespace(agent="r", number=1),
    )  # fmt: skip
    with opened([]) as reception:
        reception.robots["127.0.0.1", 1] = robot
        for _ in range(2):
            reception._admit_robot(Registration("robot", "r", 1), ("127.0.0.1", 1))
        assert list(reception.robots.values()) == [robot]
    assert sent == [b"reply"] * 2


def test_motors_too_slow_for_short_ticks_are_reported() -> None:
    lines: list[str] = []
    sent: list[bytes] = []
    robot: Any = SimpleNamespace(client=SimpleNamespace(client=("127.0.0.1", 1), send=sent.append))
    with opened(lines) as reception:
        reception._joined(robot, Robot(top_speed=3.3), 0.05)
        assert lines == []
        reception._joined(robot, Robot(top_speed=3.3), 0.02)
    assert "expected --option TopSpeed=7.5 or more at ticks of 0.02 s, got 3.3: powers above 0.066" in lines[0]
    assert len(sent) == 2


def test_a_port_in_use_is_an_error() -> None:
    with opened([]) as reception, pytest.raises(OSError, match=r"--port: expected a free port"):
        Reception(
            "127.0.0.1", reception.port, where=Link("x"), lab=FLOOR, settings=Settings(), waits=Waits(), gps=False,
            beacons=True, beacon_height=2.0, changes={}, reports=Reports(print), tell=print,
        )  # fmt: skip
