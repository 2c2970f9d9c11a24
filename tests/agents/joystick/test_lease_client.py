"""A lease is taken, renewed in time, taken anew when it ended, given up when it is somebody else's, given back."""

from __future__ import annotations

from intellwheels_agents.joystick.lease_client import RENEW, RETRY, SECONDS, LeaseClient
from intellwheels_schemas.messages import Result, Take

LEASE = "0123456789abcdef"
OTHER = "fedcba9876543210"


def ok(lease: str = LEASE) -> Result:
    return Result(code="ok", lease=lease)


def held() -> LeaseClient:
    lease = LeaseClient("chair1")
    assert lease.ask(0.0) == Take(agent="chair1", lease=None, seconds=SECONDS)
    assert lease.ask(0.1) is None
    assert lease.answered(ok(), 0.2)
    return lease


def test_it_is_renewed_with_the_lease_before_it_ends_twice_over() -> None:
    lease = held()
    assert lease.lease == LEASE
    assert lease.ask(0.2 + RENEW - 0.01) is None
    assert lease.ask(0.2 + RENEW) == Take(agent="chair1", lease=LEASE, seconds=SECONDS)
    assert not lease.answered(ok(), 1.0)
    assert 2.0 * RENEW < SECONDS


def test_it_is_given_back_once_and_only_if_there_is_one() -> None:
    lease = held()
    assert lease.back() == Take(agent="chair1", lease=LEASE, seconds=0.0)
    assert lease.back() is None
    assert LeaseClient("chair1").back() is None


def test_who_never_had_it_is_lost_with_the_simulators_words() -> None:
    for result, words in (
        (Result(code="not-found", text="no agent 'chair1' here"), "no agent 'chair1' here"),
        (Result(code="incorrect-state", text="agent 'chair1' is taken by somebody else"), "agent 'chair1' is taken"),
        (None, "no simulator answers, or not allowed"),
    ):
        lease = LeaseClient("chair1")
        lease.ask(0.0)
        lease.answered(result, 0.1)
        assert words in lease.lost
        assert lease.ask(9.0) is None


def test_silence_of_a_simulator_that_answered_before_is_borne() -> None:
    lease = held()
    lease.ask(1.0)
    lease.answered(None, 2.0)
    assert not lease.lost
    assert lease.ask(2.0) is None
    assert lease.ask(2.0 + RETRY) is not None


def test_a_lease_that_ended_is_taken_anew_and_inputs_wait_for_it() -> None:
    lease = held()
    lease.ask(1.0)
    lease.answered(Result(code="incorrect-state", text="this lease is over; take it anew"), 1.1)
    assert lease.lease is None
    assert lease.ask(1.1) == Take(agent="chair1", lease=None, seconds=SECONDS)
    assert lease.answered(ok(OTHER), 1.2)
    assert lease.lease == OTHER


def test_a_lease_that_became_somebody_elses_is_lost() -> None:
    lease = held()
    refused = Result(code="incorrect-state", text="agent 'chair1' is taken by somebody else")
    for now in (1.0, 1.1):
        lease.ask(now)
        lease.answered(refused, now)
    assert "somebody else" in lease.lost
