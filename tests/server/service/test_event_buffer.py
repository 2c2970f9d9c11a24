from __future__ import annotations

from intellwheels_schemas.codec import encode
from intellwheels_schemas.messages import Event
from intellwheels_server.service.event_buffer import EventBuffer

RUN = "0" * 16


def filled(count: int, capacity: int = 10_000) -> EventBuffer:
    buffer = EventBuffer(capacity)
    for number in range(count):
        buffer.add(Event(run=RUN, tick=number, number=number, code="contact", agent="one", other="wall"))
    return buffer


def test_reply_has_the_events_from_a_number_on() -> None:
    events = filled(10).since(7, RUN)
    assert [event.number for event in events.event] == [7, 8, 9]
    assert (events.oldest, events.next) == (0, 10)


def test_reply_names_the_oldest_event_when_older_ones_are_asked_for() -> None:
    events = filled(25, capacity=10).since(0, RUN)
    assert events.oldest == 15
    assert [event.number for event in events.event] == list(range(15, 25))


def test_long_list_comes_in_replies_below_60_kb_that_lead_to_its_end() -> None:
    buffer, received, since = filled(3000), [], 0
    while (reply := buffer.since(since, RUN)).event:
        assert len(encode(reply)) < 60_000
        received += [event.number for event in reply.event]
        since = reply.next
    assert received == list(range(3000))


def test_new_run_clears_the_buffer() -> None:
    buffer = filled(5)
    buffer.add(Event(run="1" * 16, tick=0, number=0, code="reset"))
    assert [event.code for event in buffer.since(0, "1" * 16).event] == ["reset"]
    assert buffer.since(0, RUN).event == ()


def test_empty_buffer_gives_an_empty_reply() -> None:
    events = EventBuffer().since(0, RUN)
    assert (events.oldest, events.next, events.event) == (0, 0, ())
