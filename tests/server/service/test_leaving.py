from __future__ import annotations

from typing import Any

import pytest

from intellwheels_schemas.messages import AgentLeave, CrewJoined, CrewLeave, Leave, Result, Robot
from intellwheels_server.service.arrival import Token
from intellwheels_server.service.roster import presence_of
from tests.server.stage import Stage, real

NAMES = ("c1", "c2", "c3")


@pytest.fixture
def stage() -> Stage:
    stage = Stage(pace="realtime")
    assert isinstance(stage.join_crew("c", *NAMES), CrewJoined)
    return stage


def counted(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that grows with each change of the world, by how much is changed at once."""
    run, found = stage.live_run._service.run, list[int]()
    apply_all = run.apply_all

    def apply(changes: Any, *more: Any) -> Any:
        found.append(len(changes))
        return apply_all(changes, *more)

    monkeypatch.setattr(run, "apply_all", apply)
    return found


def test_crew_leaves_with_one_change_of_the_bodies(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    changes = counted(stage, monkeypatch)
    leave = tuple(AgentLeave(agent=name, session=stage.sessions[name]) for name in NAMES)
    ((reply, ok),) = stage.ask("crew-leave", "c", CrewLeave(crew="c", leave=(*leave, leave[0])))
    assert isinstance(reply, Result)
    assert (ok, reply.code, changes) == (True, "ok", [3])
    assert stage.live_run.state.names == ()
    assert stage.events().count("left") == 3
    assert [note for note in stage.notes if note.startswith("left")] == [
        f"left agent={name} role=both tick={stage.tick}" for name in NAMES
    ]
    assert stage.of("undeclare-crew", "c") != []


def test_killed_crew_is_lost_and_gone_with_one_change_each(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    changes = counted(stage, monkeypatch)
    for name in NAMES:
        stage.live_run.take(Token(name, "both", presence_of("c" * 16, "c"), present=False), stage.now)
    stage.work()
    assert changes == [3]
    assert stage.events().count("lost") == 3
    stage.work(4.0)
    assert changes == [3, 3]
    assert stage.live_run.state.names == ()


def test_body_and_its_mind_leave_one_after_the_other() -> None:
    stage = Stage(pace="realtime")
    body = stage.join("b", real(role="body", hardware="simulated"), instance="b" * 16)
    mind = stage.join("b", Robot(role="mind"), instance="a" * 16)
    stage.live_run._service.pacing.paused = True
    asked = [stage.ask("leave", "b", Leave(session=one.session)) for one in (mind, body)]
    assert [reply.code for ((reply, _),) in asked if isinstance(reply, Result)] == ["ok", "ok"]
    assert stage.live_run.state.names == ()
    assert stage.errors("b") == []
