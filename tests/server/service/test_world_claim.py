from __future__ import annotations

from intellwheels_schemas.keys import Claim
from intellwheels_server.service.world_claim import SUSPENDED, YIELD_AFTER, WorldClaim

EARLY, OWN, LATE = Claim(1, "a" * 16), Claim(2, "b" * 16), Claim(3, "c" * 16)
EARLIER = "another simulator started earlier"


def test_of_two_that_start_together_the_earlier_claim_serves() -> None:
    one, other = WorldClaim(OWN, 0.0), WorldClaim(EARLY, 0.0)
    one.add(EARLY, 0.05)
    other.add(OWN, 0.05)
    assert one.is_contested
    assert one.yields(0.05) is None
    assert not other.is_contested
    assert one.yields(0.05 + YIELD_AFTER) == EARLIER
    assert other.yields(0.05 + YIELD_AFTER) is None


def test_claims_of_one_nanosecond_are_told_apart() -> None:
    same = Claim(OWN.since, "c" * 16)
    one, other = WorldClaim(OWN, 0.0), WorldClaim(same, 0.0)
    one.add(same, 0.0)
    other.add(OWN, 0.0)
    assert one.yields(YIELD_AFTER) is None
    assert other.yields(YIELD_AFTER) == EARLIER


def test_exactly_one_serves_also_after_the_wall_clock_was_set_back() -> None:
    # The newcomer started while the network was away, an hour later, with a clock that is two hours behind.
    old, new = Claim(7200, "a" * 16), Claim(3600, "b" * 16)
    one, other = WorldClaim(old, 3600.0), WorldClaim(new, 3600.0)
    one.add(new, 3600.0)
    other.add(old, 3600.0)
    assert [claim.yields(3600.0 + YIELD_AFTER) for claim in (one, other)] == [EARLIER, None]


def test_a_start_that_takes_long_is_no_suspension() -> None:
    one, other = WorldClaim(EARLY, 0.0), WorldClaim(LATE, 1.0)
    one.add(LATE, 1.1)
    other.add(EARLY, 1.1)
    one.begin(SUSPENDED + 1.5)
    assert one.yields(SUSPENDED + 1.6) is None
    assert other.yields(1.2 + YIELD_AFTER) == EARLIER


def test_own_claim_is_nobody_else_s() -> None:
    claim = WorldClaim(OWN, 0.0)
    claim.add(OWN, 0.0)
    assert claim.yields(0.1) is None


def served(until: float) -> WorldClaim:
    claim = WorldClaim(OWN, 0.0)
    for tick in range(int(until)):
        assert claim.yields(float(tick)) is None
    return claim


def test_a_suspended_simulator_yields_to_its_successor_and_the_successor_serves_on() -> None:
    woken, successor = served(20.0), WorldClaim(LATE, 22.0)
    for tick in range(23, 41):
        assert successor.yields(float(tick)) is None
    # It wakes at 40 s. The network brings each the claim of the other half a second later.
    assert woken.yields(40.0) is None
    woken.add(LATE, 40.5)
    successor.add(OWN, 40.5)
    assert successor.yields(40.6) is None
    assert woken.is_in_doubt(40.6)
    assert woken.yields(40.6) == "another simulator took over while this one was suspended"
    successor.remove(OWN)
    assert successor.yields(41.0 + YIELD_AFTER) is None


def test_a_suspended_simulator_without_a_successor_serves_on() -> None:
    woken = served(20.0)
    assert woken.yields(20.0 + 10.0 * SUSPENDED) is None


def test_of_two_networks_that_are_joined_the_later_simulator_ends_within_two_seconds() -> None:
    late = served(12.0)
    late.add(EARLY, 12.0)
    assert late.yields(12.0) is None
    assert late.yields(12.0 + YIELD_AFTER) == EARLIER
    early = served(12.0)
    early.add(LATE, 12.0)
    assert early.yields(13.0) is None
    assert early.yields(14.0) is None
