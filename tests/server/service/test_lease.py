from __future__ import annotations

from intellwheels_schemas.messages import UserInput
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.service.lease import Leases


def test_inputs_without_a_lease_count_while_the_body_is_not_taken() -> None:
    assert Leases().check_input("one", UserInput(forward=1.0), 0.0) is True


def test_only_the_holder_of_the_lease_steers() -> None:
    leases = Leases()
    leases.grant("one", "a" * 16, 2.0, 0.0)
    fault = leases.check_input("one", UserInput(), 0.1)
    assert isinstance(fault, Fault)
    assert (fault.code, fault.where) == ("lease", "UserInput.Lease")
    assert isinstance(leases.check_input("one", UserInput(lease="b" * 16), 0.1), Fault)
    assert leases.check_input("one", UserInput(lease="a" * 16), 0.1) is True


def test_lease_ends_unless_it_is_renewed() -> None:
    leases = Leases()
    leases.grant("one", "a" * 16, 2.0, 0.0)
    assert leases.due() == 2.0
    leases.grant("one", "a" * 16, 2.0, 1.5)
    assert leases.take_expired(2.0) == ()
    assert leases.take_expired(3.5) == ("one",)
    assert leases.active("one") is None
    assert isinstance(leases.check_input("one", UserInput(lease="a" * 16), 3.6), Fault)


def test_newest_number_wins_and_any_number_counts_after_a_silence() -> None:
    leases = Leases()
    assert leases.check_input("one", UserInput(seq=5), 0.0) is True
    assert leases.check_input("one", UserInput(seq=4), 0.1) is False
    assert leases.check_input("one", UserInput(seq=6), 0.1) is True
    assert leases.check_input("one", UserInput(seq=0), 0.5) is True


def test_user_is_reported_silent_once() -> None:
    leases = Leases()
    leases.check_input("one", UserInput(), 0.0)
    assert leases.newly_silent(0.29) == ()
    assert leases.newly_silent(0.31) == ("one",)
    assert leases.newly_silent(0.4) == ()
    leases.check_input("one", UserInput(), 0.5)
    assert leases.newly_silent(0.9) == ("one",)
