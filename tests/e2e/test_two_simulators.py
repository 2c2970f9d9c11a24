"""Two simulators never share a world: exactly one goes on, and the other ends in words."""

from __future__ import annotations

import signal
from collections.abc import Callable

import pytest
import zenoh

from tests.e2e.stage import Stage

SERVER = "intellwheels_server"


def router(stage: Stage) -> None:
    """Start a router at the stage's endpoint."""
    stage.line(stage.start("router", f"{SERVER}.service.router", "--listen", stage.endpoint), "ready")


def simulator(stage: Stage) -> str:
    """Start a simulator that joins the router, and do not wait for it."""
    return stage.start("server", SERVER, "--connect", stage.endpoint, "--world", stage.world, "--pace", "realtime")


def on_gone(gone: list[str]) -> Callable[[zenoh.Sample], None]:
    """Return a callback that notes the tokens that disappear."""

    def note(sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.DELETE:
            gone.append(str(sample.key_expr))

    return note


def one_serves_of_two_started_together(stage: Stage) -> None:
    both = [simulator(stage), simulator(stage)]
    (loser,) = stage.wait(lambda: [child for child in both if stage.exited(child)] or None, "end of one of two")
    (winner,) = set(both) - {loser}
    stage.simulator = winner
    assert stage.exit(loser) == 1
    log = stage.log(loser)
    assert "another simulator started earlier, so this one ends" in log or "has a simulator already" in log
    stage.line(winner, "ready")
    with stage.peer() as peer:
        # All of the two seconds in which the second one must have ended.
        peer.ticks_on(40)
    assert stage.exited(winner) is None
    stage.signal(winner, signal.SIGTERM)
    assert stage.exit(winner) == 0


def the_successor_of_a_suspended_simulator_serves_on(stage: Stage) -> None:
    first = simulator(stage)
    stage.line(first, "ready")
    with stage.peer() as peer:
        gone: list[str] = []
        with peer.session.liveliness().declare_subscriber(f"{peer.prefix}alive/**", on_gone(gone), history=True):
            stage.signal(first, signal.SIGSTOP)
            # The router drops the session of a stopped process after 10 s: its token and its claim.
            stage.wait(lambda: True if len(gone) == 2 else None, "end of the stopped simulator's tokens", 5.0 * 10.0)
    second = simulator(stage)
    stage.simulator = second
    stage.line(second, "ready")
    stage.signal(first, signal.SIGCONT)
    assert stage.exit(first, timeout=5.0 * 2.0) == 1
    assert "another simulator took over while this one was suspended" in stage.log(first)
    with stage.peer() as peer:
        peer.ticks_on(40)
    assert stage.exited(second) is None
    stage.signal(second, signal.SIGTERM)
    assert stage.exit(second) == 0


def test_of_two_simulators_started_together_exactly_one_serves(stage: Stage) -> None:
    router(stage)
    one_serves_of_two_started_together(stage)


def test_a_simulator_that_wakes_up_beside_its_successor_ends(stage: Stage) -> None:
    router(stage)
    the_successor_of_a_suspended_simulator_serves_on(stage)


@pytest.mark.soak
@pytest.mark.parametrize("number", range(30))
def test_of_thirty_pairs_started_together_exactly_one_serves(stage: Stage, number: int) -> None:
    router(stage)
    one_serves_of_two_started_together(stage)


@pytest.mark.soak
@pytest.mark.parametrize("number", range(10))
def test_ten_simulators_that_wake_up_beside_their_successors_end(stage: Stage, number: int) -> None:
    router(stage)
    the_successor_of_a_suspended_simulator_serves_on(stage)
