from __future__ import annotations

from typing import Any

import msgspec
import pytest

from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.messages import (
    AgentLeave,
    CrewJoin,
    CrewJoined,
    CrewLeave,
    Refused,
    Result,
    Robot,
)
from intellwheels_server.service.crew_joining import TOKENS_WAIT
from intellwheels_server.service.roster import presence_of
from tests.server.stage import Stage

NAMES = ("c1", "c2", "c3")
INSTANCE = "c" * 16


def accepted(reply: object) -> CrewJoined:
    assert isinstance(reply, CrewJoined), reply
    return reply


def codes(reply: object) -> dict[str, str]:
    return {each.agent: each.code for each in accepted(reply).refused}


def test_agents_join_with_one_query_and_get_one_message() -> None:
    stage = Stage(pace="realtime")
    reply = accepted(stage.join_crew("c", *NAMES))
    assert [each.agent for each in reply.joined] == [*NAMES]
    assert reply.refused == ()
    assert len({each.session for each in reply.joined}) == 3
    assert {each.robot.crew for each in reply.joined} == {"c"}
    assert reply.parameters.world == "main"
    (first,) = stage.of("crew-measures", "c")[-1:]
    assert [each.agent for each in first.measures] == [*NAMES]
    # Each is an agent like any other.
    assert stage.events().count("joined") == 3
    assert [body.robot.crew for name in NAMES for body in stage.of("body", name)[-1:]] == ["c"] * 3
    assert stage.measures("c1") == []
    before = stage.tick
    stage.work(0.5)
    assert stage.tick - before == 10
    assert len(stage.of("crew-measures", "c")) == 11


def test_measures_come_in_the_encoding_of_the_join() -> None:
    stage = Stage(pace="realtime")
    accepted(stage.join_crew("c", *NAMES, encoding=Encoding.XML))
    stage.work(0.2)
    sent = [encoding for to, what, _, encoding in stage.sent if (to, what) == ("c", "crew-measures")]
    assert len(sent) == 5
    assert set(sent) == {Encoding.XML}


def test_lockstep_waits_for_each_agent_and_asks_again_only_those_that_lack() -> None:
    stage = Stage()
    accepted(stage.join_crew("c", *NAMES))
    stage.crew_act("c", "c1", "c3")
    assert stage.tick == 0
    stage.sent.clear()
    stage.work(0.025)
    (again,) = stage.of("crew-measures", "c")
    assert [each.agent for each in again.measures] == ["c2"]
    stage.crew_act("c", "c2")
    assert stage.tick == 1


def test_join_waits_for_its_tokens_and_refuses_agents_without_one() -> None:
    stage = Stage(pace="realtime")
    robots = tuple(Robot(name=name, kind="wheelchair", length=1.0, width=0.6) for name in NAMES)
    replies = stage.ask("crew-join", "c", CrewJoin(crew="c", instance=INSTANCE, robot=robots))
    for name in NAMES[:2]:
        stage.token(name, "both", presence_of(INSTANCE, "c"))
    # A token of the same process that lets no crew act, or another crew, does not count.
    stage.token("c3", "both", INSTANCE)
    stage.token("c3", "both", presence_of(INSTANCE, "d"))
    assert replies == []
    stage.work(TOKENS_WAIT)
    ((reply, ok),) = replies
    assert ok
    assert codes(reply) == {"c3": "no-token"}
    assert f"in/c3/alive/both/{INSTANCE}/c before the join" in accepted(reply).refused[0].text
    replies = stage.ask("crew-join", "c", CrewJoin(crew="c", instance=INSTANCE, robot=robots[2:]))
    stage.token("c3", "both", presence_of(INSTANCE, "c"))
    assert [each.agent for each in accepted(replies[0][0]).joined] == ["c3"]


def test_agent_that_cannot_join_does_not_prevent_the_others() -> None:
    stage = Stage(pace="realtime")
    stage.join("c2", instance="b" * 16)
    assert codes(stage.join_crew("c", *NAMES)) == {"c2": "already-here"}
    assert codes(stage.join_crew("c", "operator", "c4")) == {"operator": "name"}
    assert set(stage.live_run.state.names) == {"c1", "c2", "c3", "c4"}
    assert stage.live_run._service.agents.crews.named["c"].names == ("c1", "c3", "c4")


@pytest.mark.parametrize(
    ("fields", "code", "text"),
    [
        ({"role": "body"}, "value", "expected both or mind in a crew, got body"),
        ({"type": "real"}, "value", "expected simulated in a crew, got real"),
        ({"crew": "d"}, "value", "expected 'c' as in the key, got 'd'"),
    ],
)
def test_what_no_crew_can_have_is_refused(fields: dict[str, Any], code: str, text: str) -> None:
    stage = Stage(pace="realtime")
    reply = accepted(stage.join_crew("c", "c1", **fields))
    assert codes(reply) == {"c1": code}
    assert text in reply.refused[0].text


def test_robot_of_another_process_than_the_crew_is_refused() -> None:
    stage = Stage(pace="realtime")
    other = Robot(name="c1", instance="d" * 16, length=1.0, width=0.6)
    stage.token("c1", "both", presence_of(INSTANCE, "c"))
    ((reply, _),) = stage.ask("crew-join", "c", CrewJoin(crew="c", instance=INSTANCE, robot=(other,)))
    assert codes(reply) == {"c1": "value"}
    assert "as in the CrewJoin" in accepted(reply).refused[0].text


def test_crew_has_at_most_250_agents() -> None:
    stage = Stage(pace="realtime")
    accepted(stage.join_crew("c", "c0"))
    crew = stage.live_run._service.agents.crews.named["c"]
    crew.members |= {f"x{k}": crew.members["c0"] for k in range(249)}
    assert codes(stage.join_crew("c", "c1")) == {"c1": "limit"}


def test_agent_that_joins_alone_cannot_name_a_crew() -> None:
    stage = Stage(pace="realtime")
    reply, ok = stage.try_join("c1", crew="c")
    assert not ok
    assert isinstance(reply, Refused)
    assert "crews join at crew/<crew>/join" in reply.text


def test_crew_belongs_to_one_process_until_that_is_gone() -> None:
    stage = Stage(pace="realtime")
    accepted(stage.join_crew("c", "c1", "c2"))
    other = stage.join_crew("c", "c1", "c3", instance="d" * 16)
    assert isinstance(other, Refused)
    assert other.code == "already-here"
    first = stage.sessions["c1"]
    for name in ("c1", "c2"):
        stage.token(name, "both", presence_of(INSTANCE, "c"), present=False)
    reply = accepted(stage.join_crew("c", "c1", "c3", instance="d" * 16))
    assert [each.agent for each in reply.joined] == ["c1", "c3"]
    assert stage.sessions["c1"] != first
    # c2 is lost like any agent.
    stage.work(3.0)
    assert set(stage.live_run.state.names) == {"c1", "c3"}


def test_same_process_joins_again_with_the_same_sessions() -> None:
    stage = Stage(pace="realtime")
    accepted(stage.join_crew("c", *NAMES))
    sessions = dict(stage.sessions)
    accepted(stage.join_crew("c", *NAMES))
    assert stage.sessions == sessions
    assert stage.events().count("joined") == 3


def test_dead_crew_is_many_lost_agents_that_may_return_within_the_grace_time() -> None:
    stage = Stage(pace="realtime")
    accepted(stage.join_crew("c", *NAMES))
    for name in NAMES:
        stage.token(name, "both", presence_of(INSTANCE, "c"), present=False)
    stage.work(2.0)
    assert stage.events().count("lost") == 3
    stage.token("c1", "both", presence_of(INSTANCE, "c"))
    stage.work(1.5)
    assert list(stage.live_run.state.names) == ["c1"]
    assert stage.events().count("returned") == 1
    stage.token("c1", "both", presence_of(INSTANCE, "c"), present=False)
    stage.work(3.1)
    assert not stage.live_run.state.names
    assert ("c", "undeclare-crew") in [(to, what) for to, what, *_ in stage.sent]
    stage.sent.clear()
    stage.work(0.5)
    assert stage.of("crew-measures", "c") == []


def test_crew_leaves_with_one_query_and_only_with_its_sessions() -> None:
    stage = Stage(pace="realtime")
    accepted(stage.join_crew("c", *NAMES))
    leave = tuple(AgentLeave(agent=name, session=stage.sessions[name]) for name in NAMES[:2])
    wrong = (AgentLeave(agent="c3", session="0" * 16), AgentLeave(agent="c9", session="0" * 16))
    ((reply, ok),) = stage.ask("crew-leave", "c", CrewLeave(crew="c", leave=leave + wrong))
    assert isinstance(reply, Result)
    assert not ok
    assert reply.code == "not-found"
    assert reply.text is not None
    assert "got 2 others" in reply.text
    assert list(stage.live_run.state.names) == ["c3"]
    last = CrewLeave(crew="c", leave=(AgentLeave(agent="c3", session=stage.sessions["c3"]),))
    ((_, ok),) = stage.ask("crew-leave", "c", last)
    assert ok
    assert not stage.live_run.state.names


def test_agent_of_a_crew_leaves_by_itself_like_any_other() -> None:
    stage = Stage(pace="realtime")
    accepted(stage.join_crew("c", *NAMES))
    stage.crew_act("c", "c1", leave=True)
    stage.work(0.1)
    assert list(stage.live_run.state.names) == ["c2", "c3"]
    stage.ask("leave", "c2", b'{"Session":"%s"}' % stage.sessions["c2"].encode())
    assert list(stage.live_run.state.names) == ["c3"]


@pytest.mark.parametrize("topic", ["crew-join", "crew-leave"])
@pytest.mark.parametrize("data", [b"", b"?", b"{}", b"<x/>", b'{"Crew":"d","Instance":"cccccccccccccccc"}'])
def test_wrong_requests_are_refused(topic: str, data: bytes) -> None:
    stage = Stage(pace="realtime")
    ((_, ok),) = stage.ask(topic, "c", data)  # type: ignore[arg-type]
    assert not ok
    ((_, ok),) = stage.ask(topic, "", encode(CrewLeave(crew="c")))  # type: ignore[arg-type]
    assert not ok
    assert not stage.live_run.state.names


def test_run_ends_while_a_crew_waits() -> None:
    stage = Stage(pace="realtime")
    stage.ask("crew-join", "c", CrewJoin(crew="c", instance=INSTANCE, robot=(Robot(name="a", length=1.0, width=1.0),)))
    assert stage.live_run._service.agents.waiting_crews
    stage.live_run.finish(stage.now)
    assert not stage.live_run._service.agents.waiting_crews


def test_leave_names_the_crew_of_its_key() -> None:
    stage = Stage(pace="realtime")
    (joined,) = accepted(stage.join_crew("c", "c1")).joined
    leave = AgentLeave(agent="c1", session=joined.session)
    ((reply, ok),) = stage.ask("crew-leave", "c", CrewLeave(crew="d", leave=(leave,)))
    assert isinstance(reply, Result)
    assert (ok, reply.text) == (False, "CrewLeave.Crew: expected 'c' as in the key, got 'd'")
    assert stage.live_run.state.names == ("c1",)


def test_body_names_the_crew_that_has_the_agent_now() -> None:
    stage = Stage(pace="realtime")
    chair = accepted(stage.join_crew("c", "c1", "c2")).joined[0].robot
    stage.token("c1", "both", presence_of(INSTANCE, "c"), present=False)
    # Another process takes the body, alone.
    alone = msgspec.structs.replace(chair, crew=None)
    assert stage.join("c1", alone, instance="d" * 16).robot.crew is None
    assert stage.of("body", "c1")[-1].robot.crew is None
    # A mind may be in a crew though its body joined alone.
    stage.join("b1", role="body", instance="d" * 16)
    stage.token("b1", "mind", presence_of(INSTANCE, "c"))
    mind = Robot(name="b1", role="mind")
    ((reply, _),) = stage.ask("crew-join", "c", CrewJoin(crew="c", instance=INSTANCE, robot=(mind,)))
    assert [each.robot.crew for each in accepted(reply).joined] == ["c"]
    assert stage.of("body", "b1")[-1].robot.crew == "c"


def test_nothing_is_kept_of_crews_that_ended() -> None:
    stage = Stage(pace="realtime")
    for name in ("c", "d"):
        stage.join_crew(name, "c1")
        stage.put(name, b"?", "crew")
        assert [error.code for error in stage.of("crew-error", name)] == ["malformed"]
        leave = AgentLeave(agent="c1", session=stage.sessions["c1"])
        stage.ask("crew-leave", name, CrewLeave(crew=name, leave=(leave,)))
    assert stage.live_run._service.error_limit._known == {}
