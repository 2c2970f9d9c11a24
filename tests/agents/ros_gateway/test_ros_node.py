"""Nodes on the network: what an inbox lets through, and two sessions that meet."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any, cast

import pytest

from intellwheels_agents.ros_gateway.chair_messages import Topic
from intellwheels_agents.ros_gateway.rmw_wire import NO_HASH, Attachment
from intellwheels_agents.ros_gateway.ros_node import LONGEST_MESSAGE, DropLog, RosSession, TopicInbox
from intellwheels_agents.ros_gateway.ros_types import blank, encode_message, ros_type
from intellwheels_agents.ros_gateway.velocity_command import TWIST, TWIST_STAMPED
from intellwheels_experiments.run.endpoints import free_port
from intellwheels_schemas import link
from intellwheels_schemas.router_link import open_router
from tests.agents.ros_gateway.stand_in_node import StandInNode, twist
from tests.every_case import every_case

ATTACHED = Attachment(1, 2, bytes(16)).encoded()
OF_TWIST = ros_type(TWIST)


class Bytes:
    """A payload of Zenoh."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    def __len__(self) -> int:
        return len(self._data)

    def to_bytes(self) -> bytes:
        return self._data


def arrival(key: str, data: bytes, attachment: bytes | None = ATTACHED) -> Any:
    return SimpleNamespace(
        key_expr=key, payload=Bytes(data), attachment=None if attachment is None else Bytes(attachment)
    )


def key(type_hash: str = OF_TWIST.hash, dds: str = OF_TWIST.dds) -> str:
    return f"0/c/cmd_vel/{dds}/{type_hash}"


DATA = encode_message(twist(0.5, 0.1))


def heard(*arrivals: Any) -> tuple[list[tuple[str, Any]], list[str]]:
    """Return what an inbox lets through, and its log."""
    log: list[str] = []
    inbox = TopicInbox("/c/cmd_vel", [OF_TWIST, ros_type(TWIST_STAMPED)], DropLog(log.append))
    for one in arrivals:
        inbox.on_sample(one)
    assert inbox.wait(0.0) == bool(arrivals)
    return inbox.take(), log


@pytest.mark.parametrize("type_hash", [OF_TWIST.hash, NO_HASH])
def test_message_of_a_known_type_passes(type_hash: str) -> None:
    (found,), log = heard(arrival(key(type_hash), DATA))
    assert (found[0], found[1].linear.x, log) == (TWIST, 0.5, [])


@every_case(("one", "text"), [
    (arrival(key(), DATA, None), "attachment: expected 33 bytes, got none"),
    (arrival(key(), DATA, b"x"), "attachment: expected 33 bytes, got 1 bytes"),
    (arrival(key(), DATA, bytes(33)), "attachment: expected an id of 16 bytes"),
    (arrival(key(), DATA, bytes(10**6)), "attachment: expected 33 bytes"),
    (arrival(key("RIHS01_00"), DATA), "/c/cmd_vel: expected the type geometry_msgs::msg::dds_::Twist_/RIHS01_9c45"),
    (arrival(key(dds="a"), DATA), "/c/cmd_vel: expected the type"),
    (arrival(key(), DATA[:-1]), "geometry_msgs/msg/Twist: expected a message in CDR, got 51 bytes"),
    (arrival(key(), b""), "geometry_msgs/msg/Twist: expected a message in CDR, got 0 bytes"),
    (arrival(key(), bytes(LONGEST_MESSAGE + 1)), "/c/cmd_vel: expected at most 4096 bytes, got more"),
])  # fmt: skip
def test_other_bytes_are_dropped_with_a_reason(one: Any, text: str) -> None:
    found, log = heard(one, arrival(key(), DATA))
    assert len(found) == 1
    assert len(log) == 1
    assert text in log[0]


def test_humble_has_no_hashes() -> None:
    nothing: Any = None
    graph = RosSession(nothing, 7, humble=True, log=list[str]().append)
    assert graph.key_of("/c/cmd_vel", graph.type_of(TWIST)) == f"7/c/cmd_vel/{OF_TWIST.dds}/TypeHashNotSupported"


def test_a_flood_is_told_ten_times_less_often_each_time() -> None:
    log: list[str] = []
    drops = DropLog(log.append)
    for _ in range(1000):
        drops.dropped("topic=/c/cmd_vel", "why")
    assert [line.split("count=")[1].split()[0] for line in log] == ["1", "10", "100", "1000"]


def test_a_flood_leaves_the_newest() -> None:
    messages, _ = heard(*(arrival(key(), encode_message(twist(speed, 0.0))) for speed in range(1000)))
    assert messages[-1][1].linear.x == 999.0
    assert len(messages) == 256


@pytest.mark.process
def test_a_node_sees_topics_and_services_gets_latched_messages_late_and_is_answered() -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    log: list[str] = []
    with open_router([endpoint]):
        session = link.open_session(link.Link(connect=(endpoint,)), threading.Event())
        kind = "simulation_interfaces/srv/StepSimulation"

        def answer(request: Any) -> Any:
            if request.steps == 13:
                raise ValueError("a fault")
            response = blank(f"{kind}_Response")
            response.result.result = request.steps
            return response

        with RosSession(cast(Any, session), 0, humble=False, log=log.append) as graph:
            node = graph.node("/", "gateway")
            node.advertise([Topic("/c/cmd_vel", TWIST), *[Topic("/late", TWIST, Topic("", "").qos._replace(
                depth=1, transient_local=True))]])  # fmt: skip
            node.publish("/late", twist(0.25, 0.0))
            node.serve({"/step": (kind, answer)})
            inbox = node.subscribe("/c/other", [TWIST])
            with StandInNode(endpoint) as other:
                # A reader that comes late gets the last message.
                late = other.hear("/late", TWIST, latched=True)
                other.wait(lambda: late, "the latched message")
                assert late[0].linear.x == 0.25
                topics = other.wait(lambda: other.entities("MP").get("/late"), "the topic in the graph")
                assert topics == ("%/gateway", OF_TWIST.dds, OF_TWIST.hash, ":1:,1:,:,:,,")
                assert other.entities("MS")["/c/other"][3] == "::,10:,:,:,,"
                request = b"\0\1\0\0" + (7).to_bytes(8, "little")
                assert other.call("/step", request) == b"\0\1\0\0\7\0\0\0\1\0\0\0\0"
                # Wrong requests get no answer, and the next one does.
                assert other.call("/step", request[:-1], timeout=0.3) is None
                assert other.call("/step", b"\0\1\0\0" + (13).to_bytes(8, "little"), timeout=0.3) is None
                assert other.call("/step", request) is not None
                other.put("/c/other", TWIST, twist(0.5, 0.0))
                other.wait(lambda: inbox.wait(0.0), "the velocity")
                assert inbox.take()[0][1].linear.x == 0.5
                assert graph.has_node("/", "stand_in")
                assert not graph.has_node("/", "nobody")
            assert any("service=/step" in line for line in log)
