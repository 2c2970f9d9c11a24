"""A lease is taken, renewed in time, taken anew when it ended, given up when it is somebody else's, given back."""

from __future__ import annotations

from intellwheels_agents.joystick.grip import RENEW, RETRY, SECONDS, Grip
from intellwheels_schemas.messages import Result, Take

LEASE = "0123456789abcdef"
OTHER = "fedcba9876543210"


def ok(lease: str = LEASE) -> Result:
    return Result(code="ok", lease=lease)


def held() -> Grip:
    grip = Grip("chair1")
    assert grip.ask(0.0) == Take(agent="chair1", lease=None, seconds=SECONDS)
    assert grip.ask(0.1) is None
    assert grip.answered(ok(), 0.2)
    return grip


def test_it_is_renewed_with_the_lease_before_it_ends_twice_over() -> None:
    grip = held()
    assert grip.lease == LEASE
    assert grip.ask(0.2 + RENEW - 0.01) is None
    assert grip.ask(0.2 + RENEW) == Take(agent="chair1", lease=LEASE, seconds=SECONDS)
    assert not grip.answered(ok(), 1.0)
    assert 2.0 * RENEW < SECONDS


def test_it_is_given_back_once_and_only_if_there_is_one() -> None:
    grip = held()
    assert grip.back() == Take(agent="chair1", lease=LEASE, seconds=0.0)
    assert grip.back() is None
    assert Grip("chair1").back() is None


def test_who_never_had_it_is_lost_with_the_simulators_words() -> None:
    for result, words in (
        (Result(code="not-found", text="no agent 'chair1' here"), "no agent 'chair1' here"),
        (Result(code="incorrect-state", text="agent 'chair1' is taken by somebody else"), "agent 'chair1' is taken"),
        (None, "no simulator answers, or not allowed"),
    ):
        grip = Grip("chair1")
        grip.ask(0.0)
        grip.answered(result, 0.1)
        assert words in grip.lost
        assert grip.ask(9.0) is None


def test_silence_of_a_simulator_that_answered_before_is_borne() -> None:
    grip = held()
    grip.ask(1.0)
    grip.answered(None, 2.0)
    assert not grip.lost
    assert grip.ask(2.0) is None
    assert grip.ask(2.0 + RETRY) is not None


def test_a_lease_that_ended_is_taken_anew_and_inputs_wait_for_it() -> None:
    grip = held()
    grip.ask(1.0)
    grip.answered(Result(code="incorrect-state", text="this lease is over; take it anew"), 1.1)
    assert grip.lease is None
    assert grip.ask(1.1) == Take(agent="chair1", lease=None, seconds=SECONDS)
    assert grip.answered(ok(OTHER), 1.2)
    assert grip.lease == OTHER


def test_a_lease_that_became_somebody_elses_is_lost() -> None:
    grip = held()
    refused = Result(code="incorrect-state", text="agent 'chair1' is taken by somebody else")
    for now in (1.0, 1.1):
        grip.ask(now)
        grip.answered(refused, now)
    assert "somebody else" in grip.lost
