from __future__ import annotations

import random

import pytest

from intellwheels_agents.bridge.clock_offset import ClockOffset


def test_the_fastest_message_gives_the_offset_on_a_line_with_jitter() -> None:
    offset, rng = ClockOffset(), random.Random(1)
    for i in range(400):
        sent = 0.02 * i
        offset.add(sent, sent + 1234.5 + 0.002 + rng.expovariate(1 / 0.05))
    assert offset.to_ours(8.0) == pytest.approx(8.0 + 1234.5 + 0.002, abs=0.002)


def test_clock_drift_is_followed() -> None:
    offset = ClockOffset()
    for i in range(100_000):
        offset.add(0.02 * i * 1.0001, 0.02 * i)
    assert offset.to_ours(2000.2) == pytest.approx(2000.0, abs=0.002)


def test_a_restarted_clock_gets_a_new_offset() -> None:
    offset = ClockOffset()
    offset.add(500.0, 1000.0)
    offset.add(0.1, 1001.0)
    assert offset.to_ours(0.1) == 1001.0
    offset.reset()
    offset.add(3.0, 2000.0)
    assert offset.to_ours(4.0) == 2001.0
