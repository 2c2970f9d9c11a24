from __future__ import annotations

import msgspec
import pytest

from intellwheels_maps import robot
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import (
    Actions,
    Joined,
    Leave,
    Measures,
    Refused,
    Result,
    Robot,
)
from tests.server.stage import Stage, real


def test_a_leave_takes_effect_at_the_next_barrier_and_names_its_tick() -> None:
    stage = Stage()
    stage.join_two()
    replies = stage.ask("leave", "chair2", Leave(session=stage.sessions["chair2"]))
    assert replies == []
    stage.act("chair1")
    result = replies[0][0]
    assert isinstance(result, Result)
    assert (result.code, result.tick) == ("ok", 1)
    assert stage.conductor.state.names == ("chair1",)


def test_leave_in_the_last_actions_leaves() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1", 1.0, 1.0, leave=True)
    assert stage.conductor.state.names == ()
    assert stage.tick == 1
    assert "left" in stage.events()


def test_two_of_one_name_are_refused_in_words() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    refused, ok = stage.try_join("chair1", instance="b" * 16)
    assert not ok
    assert isinstance(refused, Refused)
    assert (refused.code, refused.text) == ("already-here", "agent 'chair1' is already here")


def test_a_join_waits_a_moment_for_its_token() -> None:
    stage = Stage()
    wanted = msgspec.structs.replace(robot("rear-wheel"), name="chair1", instance="a" * 16, format=None)
    replies = stage.ask("join", "chair1", wanted)
    assert replies == []
    stage.token("chair1")
    assert isinstance(replies[0][0], Joined)


def test_a_join_without_token_is_refused() -> None:
    stage = Stage()
    wanted = msgspec.structs.replace(robot("rear-wheel"), name="chair1", instance="a" * 16, format=None)
    replies = stage.ask("join", "chair1", wanted)
    stage.work(0.5)
    refused, ok = replies[0]
    assert not ok
    assert isinstance(refused, Refused)
    assert refused.code == "no-token"


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"<Robot", "value"),
        (b'{"Instance":"aaaaaaaaaaaaaaaa","Wheels":3}', "field"),
        (b'{"Instance":"aaaaaaaaaaaaaaaa","TopSpeed":"fast"}', "value"),
        (b"{" + b" " * 70_000 + b"}", "limit"),
    ],
)
def test_a_robot_that_cannot_be_read_is_refused_with_place_and_code(data: bytes, code: str) -> None:
    stage = Stage()
    stage.token("chair1")
    refused, ok = stage.ask("join", "chair1", data)[0]
    assert not ok
    assert isinstance(refused, Refused)
    assert refused.code == code
    assert refused.text.startswith("Robot")


def test_a_successor_within_the_grace_time_gets_the_body_where_it_is() -> None:
    stage = Stage()
    first = stage.join("chair1")
    for _ in range(20):
        stage.act("chair1", 0.5, 0.5)
    stage.token("chair1", present=False)
    stage.result("pause")
    second = stage.join("chair1", instance="b" * 16)
    assert second.session != first.session
    assert second.position.x > first.position.x + 0.1
    assert [code for code in stage.events() if code in ("lost", "returned", "left", "joined")] == [
        "joined",
        "lost",
        "returned",
    ]


def test_the_old_twin_is_told_that_its_session_is_over() -> None:
    stage = Stage()
    old = stage.join("chair1").session
    stage.token("chair1", present=False)
    stage.result("pause")
    stage.join("chair1", instance="b" * 16)
    stage.put("chair1", Actions(session=old, left_motor=1.0, right_motor=1.0))
    assert [e.code for e in stage.errors("chair1")] == ["session"]


def test_a_lost_token_removes_the_body_after_the_grace_time() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(2.9)
    assert stage.conductor.state.names == ("chair1",)
    stage.work(0.2)
    assert len(stage.conductor.state.names) == 0
    assert [code for code in stage.events() if code != "timeout"] == ["joined", "lost", "left"]


def test_a_token_that_returns_within_the_grace_time_is_as_if_nothing_was() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(1.0)
    stage.token("chair1")
    stage.work(5.0)
    assert stage.conductor.state.names == ("chair1",)
    assert "returned" in stage.events()


def test_in_strict_lockstep_a_member_lost_for_the_grace_time_is_a_miss() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(3.1)
    assert stage.conductor.exit == 1


def test_a_mind_joins_the_body_of_another_process() -> None:
    stage = Stage()
    mind = Robot(role="mind")
    refused, ok = stage.try_join("chair1", mind, "b" * 16)
    assert not ok
    assert isinstance(refused, Refused)
    assert refused.code == "no-body"
    stage.join("chair1", msgspec.structs.replace(robot("rear-wheel"), role="body"))
    joined = stage.join("chair1", mind, "b" * 16, encoding=Encoding.XML)
    assert joined.robot.top_speed > 0.0
    assert [(e, m.tick) for a, k, m, e in stage.sent if k == "measures" and isinstance(m, Measures)][-1] == (
        Encoding.XML,
        0,
    )
    stage.act("chair1", 0.5, 0.5)
    assert stage.tick == 1


def test_the_reserved_name_and_crews_are_refused() -> None:
    stage = Stage()
    for agent, more, code in (("operator", {}, "name"), ("chair1", {"crew": "many"}, "value")):
        refused, ok = stage.try_join(agent, **more)
        assert not ok
        assert isinstance(refused, Refused)
        assert refused.code == code


def test_real_hardware_is_refused_where_time_is_not_real() -> None:
    for options in ({"pace": "lockstep"}, {"pace": "realtime", "speed": 2.0}):
        stage = Stage(**options)
        refused, ok = stage.try_join("chair1", real())
        assert not ok
        assert isinstance(refused, Refused)
        assert refused.code == "real-in-lockstep"
    assert Stage().try_join("chair1", real(hardware="simulated"))[1]
