"""Events in words."""

from __future__ import annotations

from intellwheels_schemas.messages import EVENT_CODES, Event
from intellwheels_viewer.panels.sentences import SENTENCES, sentence
from tests.every_case import every_case
from tests.viewer.panels import made_up


def event(code: str, **changes: object) -> Event:
    return Event(run=made_up.RUN, tick=1, number=1, code=code, **changes)  # type: ignore[arg-type]


def test_every_code_of_the_contract_has_a_sentence() -> None:
    assert SENTENCES.keys() == set(EVENT_CODES)


@every_case("code", EVENT_CODES)
def test_no_sentence_has_a_gap_when_the_event_says_little(code: str) -> None:
    said = sentence(event(code))
    assert said[0].isupper()
    assert not {"None", "{", "  "} & {*said.split(" "), *said}


def test_a_contact_says_who_hit_whom_how_fast() -> None:
    assert sentence(event("contact", agent="chair1", other="wall", speed=0.416)) == "chair1 hit a wall at 0.42 m/s"
    assert sentence(event("contact", agent="chair1", other="chair2")) == "chair1 hit chair2"


def test_a_mind_that_joins_is_told_from_a_body() -> None:
    assert sentence(event("joined", agent="chair1", text="mind")) == "chair1 joined as a mind"


def test_a_text_is_told_once() -> None:
    assert sentence(event("loaded", text="ward")) == "Map loaded: ward"
    assert sentence(event("ended", text="chair1 arrived")) == "The run ended: chair1 arrived"
