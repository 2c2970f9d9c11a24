from __future__ import annotations

from intellwheels_schemas.codec import encode
from intellwheels_schemas.messages import Event
from intellwheels_server.service.event_buffer import EventBuffer

RUN = "0" * 16


def filled(count: int, kept: int = 10_000) -> EventBuffer:
    ring = EventBuffer(kept)
    for number in range(count):
        ring.add(Event(run=RUN, tick=number, number=number, code="contact", agent="one", other="wall"))
    return ring


def test_events_are_told_from_a_number_on() -> None:
    events = filled(10).since(7, RUN)
    assert [event.number for event in events.event] == [7, 8, 9]
    assert (events.oldest, events.next) == (0, 10)


def test_the_oldest_kept_is_named_when_older_ones_are_asked_for() -> None:
    events = filled(25, kept=10).since(0, RUN)
    assert events.oldest == 15
    assert [event.number for event in events.event] == list(range(15, 25))


def test_a_long_list_is_told_in_replies_below_60_kb_that_lead_to_the_end() -> None:
    ring, told, since = filled(3000), [], 0
    while (reply := ring.since(since, RUN)).event:
        assert len(encode(reply)) < 60_000
        told += [event.number for event in reply.event]
        since = reply.next
    assert told == list(range(3000))


def test_a_new_run_clears_the_ring() -> None:
    ring = filled(5)
    ring.add(Event(run="1" * 16, tick=0, number=0, code="reset"))
    assert [event.code for event in ring.since(0, "1" * 16).event] == ["reset"]
    assert ring.since(0, RUN).event == ()


def test_nothing_is_told_of_nothing() -> None:
    events = EventBuffer().since(0, RUN)
    assert (events.oldest, events.next, events.event) == (0, 0, ())
