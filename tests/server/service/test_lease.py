from __future__ import annotations

from intellwheels_schemas.messages import UserInput
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.service.lease import Leases


def test_inputs_without_a_lease_count_while_none_runs() -> None:
    assert Leases().judge("one", UserInput(forward=1.0), 0.0) is True


def test_while_a_lease_runs_only_its_holder_steers() -> None:
    leases = Leases()
    leases.grant("one", "a" * 16, 2.0, 0.0)
    fault = leases.judge("one", UserInput(), 0.1)
    assert isinstance(fault, Fault)
    assert (fault.code, fault.where) == ("lease", "UserInput.Lease")
    assert isinstance(leases.judge("one", UserInput(lease="b" * 16), 0.1), Fault)
    assert leases.judge("one", UserInput(lease="a" * 16), 0.1) is True


def test_a_lease_that_is_not_renewed_ends() -> None:
    leases = Leases()
    leases.grant("one", "a" * 16, 2.0, 0.0)
    assert leases.due() == 2.0
    leases.grant("one", "a" * 16, 2.0, 1.5)
    assert leases.expired(2.0) == ()
    assert leases.expired(3.5) == ("one",)
    assert leases.holder("one") is None
    assert isinstance(leases.judge("one", UserInput(lease="a" * 16), 3.6), Fault)


def test_the_newest_number_wins_and_counts_anew_after_a_silence() -> None:
    leases = Leases()
    assert leases.judge("one", UserInput(seq=5), 0.0) is True
    assert leases.judge("one", UserInput(seq=4), 0.1) is False
    assert leases.judge("one", UserInput(seq=6), 0.1) is True
    assert leases.judge("one", UserInput(seq=0), 0.5) is True


def test_a_user_becomes_silent_once() -> None:
    leases = Leases()
    leases.judge("one", UserInput(), 0.0)
    assert leases.silent(0.29) == ()
    assert leases.silent(0.31) == ("one",)
    assert leases.silent(0.4) == ()
    leases.judge("one", UserInput(), 0.5)
    assert leases.silent(0.9) == ("one",)
