"""Which events are a line, and which are one line together."""

from __future__ import annotations

from typing import Any

from intellwheels_schemas.messages import EVENT_CODES, Event
from intellwheels_viewer.panels.event_lines import event_lines, kind_of
from tests.viewer.wire import OTHER, event

PERIOD = 0.05


def hit(number: int, tick: int, agent: str = "a", other: str = "b", **more: Any) -> Event:
    return event(number, "contact", tick=tick, agent=agent, other=other, **more)


def test_contacts_of_a_pair_within_five_seconds_are_one_line_with_their_number() -> None:
    found = event_lines([hit(0, 0, speed=0.2), hit(1, 100, "b", "a", speed=0.5), hit(2, 180)], PERIOD)
    assert [(line.event.number, line.count, line.text) for line in found] == [
        (2, 3, "a hit b 3 times, at most 0.50 m/s")
    ]


def test_contacts_further_apart_or_of_others_or_of_another_run_are_lines_of_their_own() -> None:
    found = event_lines([hit(0, 0), hit(1, 101), hit(2, 102, "a", "wall"), hit(3, 103, run=OTHER)], PERIOD)
    assert [line.count for line in found] == [1, 1, 1, 1]


def test_that_the_pair_parted_between_its_contacts_is_left_out_and_afterwards_it_is_told() -> None:
    def parted(number: int, tick: int) -> Event:
        return event(number, "parted", tick=tick, agent="a", other="b")

    found = event_lines([hit(0, 0), parted(1, 2), event(2, "paused", tick=3), hit(3, 4), parted(4, 6)], PERIOD)
    assert [line.event.number for line in found] == [4, 3, 2]


def test_nothing_is_joined_while_the_period_is_unknown() -> None:
    assert len(event_lines([hit(0, 0), hit(1, 1)], 0.0)) == 2


def test_every_event_has_a_kind() -> None:
    assert {kind_of(event(0, code)) for code in EVENT_CODES} == {"Contacts", "Agents", "Run"}
