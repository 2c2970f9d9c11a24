"""A lease is taken, renewed in time, replaced when it has ended, given up when somebody else has it, given back."""

from __future__ import annotations

from intellwheels_agents.joystick.lease_client import LEASE_SECONDS, RENEW_PERIOD, RETRY_PERIOD, LeaseClient
from intellwheels_schemas.messages import Result, Take

LEASE = "0123456789abcdef"
OTHER = "fedcba9876543210"


def ok(lease: str = LEASE) -> Result:
    return Result(code="ok", lease=lease)


def held() -> LeaseClient:
    lease = LeaseClient("chair1")
    assert lease.request(0.0) == Take(agent="chair1", lease=None, seconds=LEASE_SECONDS)
    assert lease.request(0.1) is None
    assert lease.answered(ok(), 0.2)
    return lease


def test_it_is_renewed_with_the_lease_before_it_ends_twice_over() -> None:
    lease = held()
    assert lease.lease == LEASE
    assert lease.request(0.2 + RENEW_PERIOD - 0.01) is None
    assert lease.request(0.2 + RENEW_PERIOD) == Take(agent="chair1", lease=LEASE, seconds=LEASE_SECONDS)
    assert not lease.answered(ok(), 1.0)
    assert 2.0 * RENEW_PERIOD < LEASE_SECONDS


def test_it_is_given_back_once_and_only_if_there_is_one() -> None:
    lease = held()
    assert lease.release() == Take(agent="chair1", lease=LEASE, seconds=0.0)
    assert lease.release() is None
    assert LeaseClient("chair1").release() is None


def test_a_first_refusal_fails_with_the_simulators_text() -> None:
    for result, words in (
        (Result(code="not-found", text="no agent 'chair1' here"), "no agent 'chair1' here"),
        (Result(code="incorrect-state", text="agent 'chair1' is taken by somebody else"), "agent 'chair1' is taken"),
        (None, "no simulator answers"),
    ):
        lease = LeaseClient("chair1")
        lease.request(0.0)
        lease.answered(result, 0.1)
        assert words in lease.failure
        assert lease.request(9.0) is None


def test_a_held_lease_survives_a_silent_simulator() -> None:
    lease = held()
    lease.request(1.0)
    lease.answered(None, 2.0)
    assert not lease.failure
    assert lease.request(2.0) is None
    assert lease.request(2.0 + RETRY_PERIOD) is not None


def test_after_the_end_of_a_lease_a_new_one_is_asked_for_at_once() -> None:
    lease = held()
    lease.request(1.0)
    lease.answered(Result(code="incorrect-state", text="this lease is over; take it anew"), 1.1)
    assert lease.lease is None
    assert lease.request(1.1) == Take(agent="chair1", lease=None, seconds=LEASE_SECONDS)
    assert lease.answered(ok(OTHER), 1.2)
    assert lease.lease == OTHER


def test_a_lease_taken_by_somebody_else_fails() -> None:
    lease = held()
    refused = Result(code="incorrect-state", text="agent 'chair1' is taken by somebody else")
    for now in (1.0, 1.1):
        lease.request(now)
        lease.answered(refused, now)
    assert "somebody else" in lease.failure
