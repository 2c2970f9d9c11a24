"""Latency from inputs and motor outputs at times that the test chooses."""

from __future__ import annotations

import pytest

from intellwheels_agents.joystick.input_latency import InputLatency
from intellwheels_agents.joystick.input_state import NEUTRAL, InputState


def test_a_start_and_a_stop_are_measured_from_the_device_to_the_motors() -> None:
    latency = InputLatency()
    latency.saw(0.0, 0.0, 9.9)
    latency.sent(InputState(1.0, at=10.0), 10.01)
    latency.saw(0.0, 0.0, 10.02)
    latency.saw(0.5, 0.5, 10.07)
    latency.saw(0.8, 0.8, 10.12)
    latency.sent(NEUTRAL, 11.0)
    latency.saw(0.8, 0.8, 11.01)
    latency.saw(0.4, 0.4, 11.06)
    assert latency.times["put"] == pytest.approx([0.01, 0.0])
    assert latency.times["start"] == pytest.approx([0.07])
    assert latency.times["stop"] == pytest.approx([0.06])
    assert latency.summary().startswith("puts=2 put_median=0.0050 put_max=0.0100 starts=1 start_median=0.0700 ")


def test_repetitions_and_changes_while_driving_are_no_starts() -> None:
    latency = InputLatency()
    latency.saw(0.0, 0.0, 9.9)
    for now in (10.0, 10.05):
        latency.sent(InputState(1.0), now)
    latency.sent(InputState(0.5), 10.1)
    latency.saw(0.5, 0.5, 10.2)
    assert len(latency.times["put"]) == 2
    assert latency.times["start"] == []


def test_motors_that_are_not_known_or_run_already_measure_nothing() -> None:
    latency = InputLatency()
    latency.sent(InputState(1.0), 10.0)
    latency.saw(0.5, 0.5, 10.1)
    latency.sent(NEUTRAL, 10.15)
    latency.sent(InputState(1.0), 10.2)
    latency.saw(0.4, 0.4, 10.3)
    assert latency.times["start"] == latency.times["stop"] == []
    assert latency.summary() == "puts=3 put_median=0.0000 put_max=0.0000 starts=0 stops=0"


def test_a_device_time_in_the_future_counts_as_now() -> None:
    latency = InputLatency()
    latency.sent(InputState(1.0, at=99.0), 10.0)
    assert latency.times["put"] == [0.0]
