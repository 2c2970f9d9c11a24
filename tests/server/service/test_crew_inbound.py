from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from intellwheels_schemas.messages import AgentActions, CrewActions, CrewJoined
from intellwheels_server.log.input_log import read_header, read_lines
from intellwheels_server.service.arrival import Put
from tests.server.stage import JSON, NOBODY, Stage

NAMES = ("c1", "c2", "c3")


def crew_at_work(pace: str = "realtime", **more: Any) -> Stage:
    stage = Stage(pace=pace, **more)
    stage.live_run._service.pacing.paused = True  # so that no barrier opens between the joins
    for crew, names in (("c", NAMES), ("d", ("d1",))):
        assert isinstance(stage.join_crew(crew, *names, instance=crew * 16), CrewJoined)
    stage.live_run._service.pacing.paused = False
    stage.work()
    stage.sent.clear()
    return stage


def powers(stage: Stage) -> dict[str, float | None]:
    return {name: actions.left_motor for name, actions in stage.live_run._service.latch.actions.items()}


def complaints(stage: Stage, crew: str = "c") -> list[tuple[str, str | None]]:
    return [(error.code, error.agent) for error in stage.of("crew-error", crew)]


@pytest.mark.parametrize("pace", ["realtime", "lockstep"])
def test_each_agent_of_a_crew_acts(pace: str) -> None:
    stage = crew_at_work(pace)
    tick = stage.tick
    stage.crew_act("c", *NAMES)
    stage.crew_act("d", "d1", left_motor=-1.0)
    if pace == "lockstep":
        assert stage.tick == tick + 1
    else:
        assert powers(stage) == {"c1": 0.5, "c2": 0.5, "c3": 0.5, "d1": -1.0}
        stage.work(0.06)
        assert stage.tick > tick
    assert complaints(stage) == complaints(stage, "d") == []


def test_what_an_agent_of_a_crew_says_is_heard() -> None:
    stage = crew_at_work()
    stage.crew_act("c", "c1", say="hello")
    stage.work(0.06)
    heard = [each for part in stage.of("crew-measures", "c") for each in part.measures if each.message]
    assert {message.sender for each in heard for message in each.message} == {"c1"}
    stage.crew_act("c", "c1", say="x" * 500)
    (error,) = stage.errors("c1")
    assert error.code == "too-long"


def test_log_has_the_actions_as_if_each_agent_were_alone(tmp_path: Path) -> None:
    stage = crew_at_work(log=tmp_path / "run.jsonl")
    stage.crew_act("c", *NAMES)
    stage.work(0.06)
    assert stage.log is not None
    stage.log.close()
    with (tmp_path / "run.jsonl").open("rb") as file:
        read_header(file, "log")
        lines = [line for line in read_lines(file, "log") if line is not None]
    acted = [line.inputs.actions for line in lines if line.inputs.actions]
    assert [set(actions) for actions in acted] == [{*NAMES}]
    assert not any(isinstance(one, AgentActions) for actions in acted for one in actions.values())


def test_crew_acts_only_for_agents_that_joined_with_it() -> None:
    stage = crew_at_work()
    stage.join("alone", instance="e" * 16)
    # Even with the right session: d1 is in another crew, and the other one is in none.
    stage.crew_act("c", "c1", "d1", "alone", "nobody")
    assert powers(stage) == {"c1": 0.5}
    assert complaints(stage) == [("not-joined", "d1"), ("not-joined", "alone"), ("not-joined", "nobody")]
    assert stage.of("crew-error", "c")[0].where == "CrewActions.Actions[1].Agent"
    # Nobody else hears of it.
    assert complaints(stage, "d") == []
    assert [stage.errors(name) for name in ("d1", "alone", "nobody")] == [[], [], []]


def test_agent_of_a_crew_has_no_actions_of_its_own_key_without_its_session() -> None:
    stage = crew_at_work()
    stage.put("c1", b'{"Session":"%s","LeftMotor":1.0}' % NOBODY.encode())
    assert powers(stage) == {}
    assert [error.code for error in stage.errors("c1")] == ["session"]


def test_actions_of_another_session_are_dropped_and_the_rest_acts() -> None:
    stage = crew_at_work()
    stage.sessions["c2"] = NOBODY
    stage.crew_act("c", *NAMES)
    assert powers(stage) == {"c1": 0.5, "c3": 0.5}
    # The agent hears of it like any other, and so does its crew.
    assert [error.code for error in stage.errors("c2")] == ["session"]
    assert complaints(stage) == [("session", "c2")]


def test_late_and_early_actions_have_their_errors() -> None:
    stage = crew_at_work()
    stage.work(2.0)
    stage.crew_act("c", "c1", tick=0)
    stage.crew_act("c", "c2", tick=stage.tick + 5)
    stage.crew_act("c", "c3", run="f" * 16)
    assert powers(stage) == {}
    assert complaints(stage) == [("late", "c1"), ("early", "c2"), ("late", "c3")]


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "encoding"),
        (b"{", "malformed"),
        (b"[]", "encoding"),
        (b'{"Crew":"c","Actions":3}', "value"),
        (b'{"Crew":"d","Actions":[]}', "value"),
        (b'{"Crew":"c","Part":3}', "value"),
        (b'{"Crew":"c","Speed":3}', "field"),
        (b"<CrewActions", "malformed"),
        (b'<Actions Session="0000000000000000"/>', "malformed"),
        (b'{"Crew":"c","Actions":[%s]}' % b",".join([b"{}"] * 251), "too-many"),
    ],
)
def test_wrong_message_has_a_named_error_and_disturbs_nobody(data: bytes, code: str) -> None:
    stage = crew_at_work()
    encoding = "" if code == "encoding" else "application/xml" if data[:1] == b"<" else JSON.value
    stage.live_run.take(Put("c", "crew", data, encoding), stage.now)
    assert complaints(stage) == [(code, None)]
    stage.crew_act("d", "d1")
    stage.crew_act("c", *NAMES)
    assert len(powers(stage)) == 4
    assert complaints(stage, "d") == []


def test_wrong_actions_of_one_agent_do_not_affect_the_others() -> None:
    stage = crew_at_work()
    items = [
        {"Agent": name, "Session": stage.sessions[name], "LeftMotor": power}
        for name, power in (("c1", 0.1), ("c2", 7), ("c3", 0.3))
    ]
    stage.put("c", json.dumps({"Crew": "c", "Actions": [*items, {"Agent": "x", "Nothing": 1}, 3]}).encode(), "crew")
    assert powers(stage) == {"c1": 0.1, "c3": 0.3}
    assert complaints(stage) == [("value", "c2"), ("field", "x"), ("value", None)]
    (error,) = stage.errors("c2")
    assert error.text == "CrewActions.Actions[1].LeftMotor: expected a number in [-1, 1], got 7"


def test_crew_that_did_not_join_is_told_seldom() -> None:
    stage = crew_at_work()
    for _ in range(100):
        stage.live_run.take(Put("x", "crew", b'{"Crew":"x"}', JSON.value), stage.now)
    assert 0 < len(complaints(stage, "x")) <= 10
    assert set(complaints(stage, "x")) == {("not-joined", None)}


def test_flood_of_a_crew_is_limited_and_others_are_not() -> None:
    stage = crew_at_work()
    for _ in range(200):
        stage.live_run.take(Put("c", "crew", b'{"Crew":"c"}', JSON.value), stage.now)
    stage.live_run.take(Put("c", "crew", b"", JSON.value, 2_000_000), stage.now)
    assert ("too-many", None) in complaints(stage)
    stage.crew_act("d", "d1")
    assert powers(stage) == {"d1": 0.5}


def test_too_long_message_is_named() -> None:
    stage = crew_at_work()
    stage.live_run.take(Put("c", "crew", b"", JSON.value, 2_000_000), stage.now)
    assert complaints(stage) == [("too-long", None)]


def test_second_answer_of_an_agent_counts_only_if_it_is_another_one() -> None:
    stage = crew_at_work("lockstep")
    stage.crew_act("c", "c1")
    stage.crew_act("c", "c1")
    assert complaints(stage) == []
    stage.crew_act("c", "c1", left_motor=-1.0)
    assert complaints(stage) == [("answered", "c1")]


def test_deleted_agent_is_told_through_its_crew() -> None:
    stage = crew_at_work()
    assert stage.result("delete", b'{"Agent":"c2"}').code == "ok"
    assert complaints(stage) == [("deleted", "c2")]
    stage.crew_act("c", *NAMES)
    assert powers(stage) == {"c1": 0.5, "c3": 0.5}
    assert complaints(stage)[-1] == ("deleted", "c2")


def test_crew_of_another_name_in_the_message_is_refused() -> None:
    stage = crew_at_work()
    stage.put("c", CrewActions(crew="d", actions=(AgentActions(agent="d1", session=stage.sessions["d1"]),)), "crew")
    assert powers(stage) == {}
    assert complaints(stage) == [("value", None)]


def test_repeated_actions_of_a_crew_are_merged_as_those_of_other_agents() -> None:
    stage = crew_at_work()
    stage.crew_act("c", *NAMES)
    stage.crew_act("c", "c1", left_motor=-0.25)
    assert powers(stage) == {"c1": -0.25, "c2": 0.5, "c3": 0.5}
    assert complaints(stage) == []


def test_lockstep_goes_on_if_a_crew_answers_with_a_message_for_each_agent() -> None:
    stage = crew_at_work("lockstep", strict=False)
    tick = stage.tick
    stage.crew_act("d", "d1")
    for _ in range(63):
        stage.crew_act("c", "c1")
    for name in NAMES:  # as a crew of 66 agents would
        stage.crew_act("c", name)
    assert stage.tick == tick
    (error, *_) = [error for error in stage.of("crew-error", "c") if error.code == "too-many"]
    assert error.text.endswith("; one message can have the actions of all agents of a crew")
    stage.sent.clear()
    stage.work(0.05)
    again = [one.agent for part in stage.of("crew-measures", "c") for one in part.measures]
    assert again == ["c2", "c3"]
    for name in again:
        stage.crew_act("c", name)
    assert stage.tick == tick + 1
