"""A mind that a ROS node drives, without a network."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from intellwheels_agents.ros_gateway.chair_messages import Topic
from intellwheels_agents.ros_gateway.ros_mind import RosMind
from intellwheels_agents.ros_gateway.velocity_command import TWIST, TWIST_STAMPED
from intellwheels_schemas.errors import WireError
from tests.agents.ros_gateway.made_up import PERIOD, RUN, context, measured, readings
from tests.agents.ros_gateway.stand_in_node import twist, twist_stamped


class Node:
    """Keeps what is published, and answers with velocities."""

    def __init__(self) -> None:
        self.topics: list[str] = []
        self.sent: list[tuple[str, Any]] = []
        self.arrived: deque[tuple[str, Any]] = deque()
        self.answers: Callable[[], list[tuple[str, Any]]] = list
        self.refused: list[str] = []
        self.clocks: list[tuple[str, float]] = []
        self.stop = threading.Event()

    def advertise(self, topics: Sequence[Topic]) -> None:
        self.topics += [topic.name for topic in topics]

    def publish(self, topic: str, message: Any) -> None:
        assert topic in self.topics
        self.sent.append((topic, message))

    def take(self) -> list[tuple[str, Any]]:
        found = list(self.arrived)
        self.arrived.clear()
        return found

    def wait(self, seconds: float) -> bool:
        self.arrived += self.answers()
        return bool(self.arrived)

    def refuse(self, error: WireError) -> None:
        self.refused.append(error.text)

    def tell(self, run: str, seconds: float, _now: float) -> None:
        self.clocks.append((run, seconds))


def mind_of(node: Node, pace: str = "realtime", await_command: float = 0.0) -> RosMind:
    return RosMind(
        context(pace=pace), node, node, localisation="start", await_command=await_command, tell_clock=node.tell,
        stop=node.stop,
    )  # fmt: skip


def test_a_run_begins_with_topics_and_fixed_frames() -> None:
    node = Node()
    node.arrived.append((TWIST, twist(1.0, 0.0)))
    mind = mind_of(node)
    assert {"/chair_1/odom", "/chair_1/scan", "/tf", "/tf_static"} <= set(node.topics)
    assert [topic for topic, _ in node.sent] == ["/tf_static"]
    # A velocity of the last run does not count.
    assert mind.decide(measured(1)).left_motor == 0.0


def test_velocity_drives_until_the_dead_man() -> None:
    node = Node()
    mind = mind_of(node)
    node.arrived.append((TWIST, twist(0.5, 0.0)))
    powers = [mind.decide(measured(tick, readings(0.0))).left_motor for tick in range(1, 14)]
    assert powers == [0.5] * 11 + [0.0] * 2
    assert node.clocks[:2] == [(RUN, PERIOD), (RUN, 2 * PERIOD)]


def test_refused_velocity_is_told_and_the_last_one_counts() -> None:
    node = Node()
    mind = mind_of(node)
    node.arrived += [(TWIST, twist(0.5, 0.0)), (TWIST, twist(float("nan"), 0.0))]
    assert mind.decide(measured(1)).left_motor == 0.5
    assert node.refused == ["cmd_vel: expected finite numbers, got nan or inf"]


def test_in_lockstep_a_tick_waits_for_the_velocity_of_its_stamp() -> None:
    node = Node()
    mind = mind_of(node, "lockstep", 5.0)
    late = iter(
        [[(TWIST_STAMPED, twist_stamped(0.1, 0.0, PERIOD))], [(TWIST_STAMPED, twist_stamped(0.2, 0.0, 2 * PERIOD))]]
    )
    node.answers = lambda: next(late)
    # The velocity of tick 1 comes first, and is no answer to tick 2.
    assert mind.decide(measured(2)).left_motor == pytest.approx(0.2)


def test_without_an_answer_a_tick_goes_on() -> None:
    node = Node()
    assert mind_of(node, "lockstep", 0.01).decide(measured(1)).left_motor == 0.0


def test_the_end_of_the_process_ends_a_wait() -> None:
    node = Node()
    node.stop.set()
    node.answers = lambda: pytest.fail("waited")
    mind_of(node, "lockstep", 3600.0).decide(measured(1))


def test_in_real_time_no_tick_waits() -> None:
    node = Node()
    node.answers = lambda: pytest.fail("waited")
    mind_of(node, "realtime", 5.0).decide(measured(1))
