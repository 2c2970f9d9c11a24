"""The kept result of the sonar trials holds, and their random part at a small size."""

from __future__ import annotations

from intellwheels_schemas.sonar_devices import DEVICES
from tests.server.world.sonar_trials import KEPT, Check, bounces, crosstalk, edges, pillars, read


def test_kept_trials_hold_for_every_device() -> None:
    kept = read(KEPT)
    assert [one for one in kept if not one.holds] == []
    shares = [one for one in kept if one.check == "direct return"]
    assert {one.case.split()[0] for one in shares} == set(DEVICES)
    assert all(one.pings >= 20_000 for one in shares)
    assert len({one.check for one in kept}) == 8  # each part of the trials


def test_random_part_agrees_with_its_closed_forms() -> None:
    for found in (bounces(1500), crosstalk(1500), edges(6000), pillars(6000)):
        (check,) = found
        assert check.pings == 15
        assert check.holds


def test_check_that_is_beyond_its_bound_does_not_hold() -> None:
    assert Check("a", "b", 1.0, 1.1, 0.2, 5).holds
    assert not Check("a", "b", 1.0, 1.3, 0.2, 5).holds
