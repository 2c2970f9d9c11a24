from __future__ import annotations

from intellwheels_schemas.messages import Event
from tests.server.stage import RUN, Stage

CONTACT = Event(run=RUN, tick=1, number=0, code="contact", agent="chair1", other="wall", x=1.0, y=2.0, speed=0.5)


def test_event_is_kept_and_published() -> None:
    stage = Stage()
    publisher = stage.live_run._service.publisher
    publisher.put_event(CONTACT)
    assert stage.of("event") == [CONTACT]
    assert publisher.events.since(0, RUN).event == (CONTACT,)


def test_laboratory_publishes_no_positions_and_its_observer_gets_them() -> None:
    stage = Stage(hide_truth=True)
    observed: list[Event] = []
    stage.live_run.observe_events(observed.append)
    stage.live_run._service.publisher.put_event(CONTACT)
    assert observed == [CONTACT]
    assert [(event.agent, event.x, event.y, event.speed) for event in stage.of("event")] == [
        ("chair1", None, None, None)
    ]
