"""The topic `/clock`."""

from __future__ import annotations

from typing import Any

from intellwheels_agents.ros_gateway.clock_topic import ClockTopic


def heard(*told: tuple[str, float, float]) -> list[float]:
    messages: list[Any] = []
    topic = ClockTopic(messages.append)
    for run, seconds, now in told:
        topic.tell(run, seconds, now)
    return [message.clock.sec + message.clock.nanosec * 1e-9 for message in messages]


def test_each_time_is_published_once() -> None:
    assert heard(("a", 0.05, 0.0), ("a", 0.05, 0.01), ("a", 0.1, 0.02), ("a", 0.05, 0.03)) == [0.05, 0.1]


def test_time_that_stands_still_is_repeated() -> None:
    assert heard(("a", 0.5, 0.0), ("a", 0.5, 0.5)) == [0.5, 0.5]


def test_a_new_run_begins_again_and_the_old_one_never_returns() -> None:
    assert heard(("a", 5.0, 0.0), ("b", 0.0, 0.1), ("a", 5.05, 0.2), ("b", 0.05, 0.3)) == [5.0, 0.0, 0.05]
