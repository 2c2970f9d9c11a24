from __future__ import annotations

from intellwheels_agents.bridge.event_notices import EventNotices
from intellwheels_schemas.messages import Body, Event, EventCode, Robot
from tests.every_case import every_case

RUN, OWN, OTHER = "a" * 16, "b" * 16, "c" * 16


def event(code: EventCode, agent: str = "chair1", text: str | None = None) -> Event:
    return Event(run=RUN, tick=7, number=1, code=code, agent=agent, text=text)


@every_case(
    ("code", "text", "line"),
    [
        ("deleted", None, "removed agent=chair1 tick=7 reason=deleted"),
        ("lost", None, "removed agent=chair1 tick=7 reason=lost"),
        ("left", None, "removed agent=chair1 tick=7 reason=left"),
        ("taken", None, "taken agent=chair1 tick=7"),
        ("released", None, "released agent=chair1 tick=7"),
        ("joined", "mind", "mind-joined agent=chair1 tick=7"),
        ("left", "mind", "mind-left agent=chair1 tick=7"),
        ("lost", "mind", "mind-lost agent=chair1 tick=7"),
        ("lost", "body", "body-lost agent=chair1 tick=7"),
        ("joined", "body", None),
        ("contact", None, None),
    ],
)
def test_an_event_of_the_chair_has_a_line(code: EventCode, text: str | None, line: str | None) -> None:
    assert EventNotices("chair1", OWN).event(event(code, text=text)) == line


def test_events_of_others_have_none() -> None:
    assert EventNotices("chair1", OWN).event(event("deleted", agent="chair2")) is None


def test_the_simulator_s_going_and_return_have_a_line_and_its_first_coming_has_none() -> None:
    notices = EventNotices("chair1", OWN)
    lines = [notices.presence(alive) for alive in (True, False, False, True)]
    assert lines == [None, "simulator-gone agent=chair1", None, "simulator-back agent=chair1"]


def test_another_owner_of_the_body_is_reported_once() -> None:
    notices = EventNotices("chair1", OWN)

    def owned(owner: str | None) -> Body:
        return Body(run=RUN, tick=7, owner=owner, robot=Robot(name="chair1"))

    lines = [notices.body(owned(owner)) for owner in (OWN, None, OTHER, OTHER, OWN)]
    assert lines == [None, None, f"replaced agent=chair1 owner={OTHER}", None, None]
