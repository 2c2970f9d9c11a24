from __future__ import annotations

import random

import pytest

from intellwheels_agents.bridge.clock_offset import ClockOffset


def test_the_quickest_message_says_the_offset_of_an_uneven_line() -> None:
    offset, rng = ClockOffset(), random.Random(1)
    for i in range(400):
        sent = 0.02 * i
        offset.hear(sent, sent + 1234.5 + 0.002 + rng.expovariate(1 / 0.05))
    assert offset.ours(8.0) == pytest.approx(8.0 + 1234.5 + 0.002, abs=0.002)


def test_clocks_that_run_differently_are_followed() -> None:
    offset = ClockOffset()
    for i in range(100_000):
        offset.hear(0.02 * i * 1.0001, 0.02 * i)
    assert offset.ours(2000.2) == pytest.approx(2000.0, abs=0.002)


def test_a_clock_that_began_anew_is_learnt_anew() -> None:
    offset = ClockOffset()
    offset.hear(500.0, 1000.0)
    offset.hear(0.1, 1001.0)
    assert offset.ours(0.1) == 1001.0
    offset.renew()
    offset.hear(3.0, 2000.0)
    assert offset.ours(4.0) == 2001.0
