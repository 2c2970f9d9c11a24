"""What is seen: who is there, and who is old."""

import dataclasses

import pytest

from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.wire import entity


def test_stale_are_those_whose_state_says_so() -> None:
    seen = Snapshot(entities=(entity("a"), entity("b", state="stale"), entity("c", state="taken")))
    assert seen.stale == {"b"}


def test_an_entity_is_found_by_its_name_and_nobody_by_another() -> None:
    seen = Snapshot(entities=(entity("a", 1.0), entity("b", 2.0)))
    found = seen.entity("b")
    assert found is not None
    assert found.x == 2.0
    assert seen.entity("") is None
    assert Snapshot().entity("a") is None


def test_what_is_seen_is_a_value_that_others_may_keep() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Snapshot().tick = 1  # type: ignore[misc]
    assert Snapshot() == Snapshot()
