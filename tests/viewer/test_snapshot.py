"""Derived values of a snapshot."""

import dataclasses

import pytest

from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.wire import clock, entity


def test_stale_are_those_whose_state_says_so() -> None:
    snapshot = Snapshot(entities=(entity("a"), entity("b", state="stale"), entity("c", state="taken")))
    assert snapshot.stale == {"b"}


def test_an_entity_is_found_by_its_name_and_nobody_by_another() -> None:
    snapshot = Snapshot(entities=(entity("a", 1.0), entity("b", 2.0)))
    found = snapshot.entity("b")
    assert found is not None
    assert found.x == 2.0
    assert snapshot.entity("") is None
    assert Snapshot().entity("a") is None


def test_what_is_seen_is_a_value_that_others_may_keep() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Snapshot().tick = 1  # type: ignore[misc]
    assert Snapshot() == Snapshot()


def test_the_period_is_known_from_the_first_tick_on() -> None:
    assert Snapshot().period is None
    assert Snapshot(tick=40, time=4.0).period == pytest.approx(0.1)
    assert Snapshot(tick=40, time=4.0, clock=clock(20)).period == pytest.approx(0.05)
