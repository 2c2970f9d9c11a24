from __future__ import annotations

from intellwheels_agents.bridge.fault_notes import MAX_KINDS, MAX_TEXT, FaultNotes
from intellwheels_schemas.errors import WireError


def test_every_fault_is_counted_and_each_kind_told_once() -> None:
    told: list[str] = []
    notes = FaultNotes(told.append)
    for value in range(3):
        notes.add(WireError("value", f"speed: expected less, got {value}", "speed"))
    notes.add(WireError("value", "battery: " + "x" * 1000, "battery"))
    assert notes.count == 4
    assert told[0] == "speed: expected less, got 0"
    assert [len(text) for text in told[1:]] == [MAX_TEXT]


def test_no_more_kinds_are_told_than_fit_on_a_page() -> None:
    told: list[str] = []
    notes = FaultNotes(told.append)
    for kind in range(1000):
        notes.add(WireError("value", "wrong", str(kind)))
    assert (notes.count, len(told)) == (1000, MAX_KINDS)
