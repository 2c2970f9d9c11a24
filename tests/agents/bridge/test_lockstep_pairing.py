from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from intellwheels_agents.bridge.lockstep_pairing import LockstepPairing

DEADLINE = 10.0
A, B = "a" * 16, "b" * 16


class Waiting:
    """A wait on a thread of its own."""

    def __init__(self, wait: Callable[[], bool]) -> None:
        self.found: list[bool] = []
        self._thread = threading.Thread(target=lambda: self.found.append(wait()))
        self._thread.start()

    def is_over(self, within: float = DEADLINE) -> bool:
        self._thread.join(timeout=within)
        return not self._thread.is_alive()


@pytest.fixture
def pairing() -> LockstepPairing:
    made = LockstepPairing(threading.Event())
    made.laboratory_measured(A, 0)
    made.simulation_run_began(B)
    return made


def test_measures_of_the_same_tick_are_waited_for(pairing: LockstepPairing) -> None:
    waiting = Waiting(lambda: pairing.await_measures(1))
    assert not waiting.is_over(0.05)
    pairing.laboratory_measured(A, 1)
    assert waiting.is_over()
    assert waiting.found == [True]


def test_the_power_of_the_tick_before_is_waited_for(pairing: LockstepPairing) -> None:
    waiting = Waiting(lambda: pairing.await_power(0))
    assert not waiting.is_over(0.05)
    pairing.simulation_powered(A, 0)  # of a run that is not on
    assert not waiting.is_over(0.05)
    pairing.simulation_powered(B, 0)
    assert waiting.is_over()
    assert waiting.found == [True]


def test_a_side_that_is_a_run_behind_does_not_wait(pairing: LockstepPairing) -> None:
    behind = Waiting(lambda: pairing.await_power(7))
    pairing.simulation_run_began("c" * 16)
    assert behind.is_over()
    assert behind.found == [False]
    ahead = Waiting(lambda: pairing.await_measures(0))
    assert not ahead.is_over(0.05)
    pairing.laboratory_measured("d" * 16, 0)
    assert ahead.is_over()
    assert ahead.found == [True]


def test_stopping_ends_every_wait() -> None:
    stop = threading.Event()
    made = LockstepPairing(stop)
    waiting = Waiting(lambda: made.await_power(0))
    stop.set()
    assert waiting.is_over()
    assert waiting.found == [False]
