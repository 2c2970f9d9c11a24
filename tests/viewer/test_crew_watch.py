from __future__ import annotations

from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import AgentMeasures, Body, CrewMeasures, Robot
from intellwheels_viewer.crew_watch import measures_in, subscriptions

RUN = "a" * 16
KEYS = Keys("main")


def body(name: str, crew: str | None = None) -> Body:
    return Body(run=RUN, tick=0, robot=Robot(name=name, crew=crew, length=1.0, width=1.0))


BODIES = {"a1": body("a1", "c"), "a2": body("a2", "c"), "b": body("b")}


def test_agents_of_a_crew_are_watched_with_one_subscription() -> None:
    assert subscriptions(KEYS, BODIES, ["a1", "a2", "b", "unknown"], 32) == {
        "b": "iw/v1/main/out/b/measures",
        "unknown": "iw/v1/main/out/unknown/measures",
        "crew/c": "iw/v1/main/crew/c/measures",
    }


def test_many_agents_are_watched_with_one_subscription_for_each_kind_of_key() -> None:
    assert subscriptions(KEYS, BODIES, ["a1", "b"], 1) == {
        "*": "iw/v1/main/out/*/measures", "crew/*": "iw/v1/main/crew/*/measures",
    }  # fmt: skip
    assert set(subscriptions(KEYS, BODIES, ["b", "d"], 1)) == {"*"}


def test_measures_of_watched_agents_are_found_in_those_of_their_crew() -> None:
    measures = tuple(AgentMeasures(agent=name, run=RUN, tick=1, time=0.05) for name in ("a1", "a2"))
    for encoding in Encoding:
        data = encode(CrewMeasures(crew="c", measures=measures), encoding)
        ((agent, own),) = measures_in(data, encoding.value, {"a2", "b"})
        assert agent == "a2"
        assert decode(AgentMeasures, own, encoding, strict=False) == measures[1]


def test_what_is_no_message_of_a_crew_is_ignored() -> None:
    for data in (b"", b"?", b"{}", b"<x/>"):
        assert list(measures_in(data, "", {"a"})) == []
