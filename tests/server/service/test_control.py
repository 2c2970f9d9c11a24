from __future__ import annotations

import msgspec
import pytest

from intellwheels_maps import robot
from intellwheels_schemas.channels import VERB_CLASSES
from intellwheels_schemas.messages import (
    Actions,
    Delete,
    Load,
    Map,
    Pace,
    Pose,
    Position,
    Record,
    Reset,
    Result,
    Robot,
    Spawn,
    Speed,
    Step,
    Take,
    Teleport,
    UserInput,
)
from intellwheels_server.service.control import change, handle
from tests.server.stage import RUN, Stage, real


def test_pause_stops_and_resume_continues_and_both_replies_have_tick_and_hash() -> None:
    stage = Stage(pace="realtime")
    stage.work(1.0)
    paused = stage.result("pause")
    tick = stage.tick
    assert (paused.code, paused.tick, paused.hash) == ("ok", tick, stage.live_run.digest())
    stage.work(5.0)
    assert stage.tick == tick
    assert stage.result("resume").code == "ok"
    stage.work(1.01)
    assert stage.tick == tick + 20
    assert stage.of("clock")[-1].late == 0
    assert stage.events() == ["paused", "resumed"]


def test_steps_are_made_while_paused_and_answered_when_made() -> None:
    stage = Stage(pace="realtime")
    assert stage.result("step", Step(count=3)).code == "incorrect-state"
    stage.result("pause")
    replies = stage.ask("ctl", "step", Step(count=3))
    stage.work(0.5)
    result = replies[0][0]
    assert isinstance(result, Result)
    assert (result.code, result.tick) == ("ok", stage.tick)
    assert stage.tick == 3


def test_pause_ends_running_steps_and_the_motors_of_a_real_chair_stand_at_once() -> None:
    stage = Stage(pace="realtime")
    session = stage.join("chair1", real()).session
    stage.result("pause")
    replies = stage.ask("ctl", "step", Step(count=1_000_000))
    for _ in range(10):
        stage.put("chair1", Pose(session=session, x=2.0, y=2.0, heading=0.0), "pose")
        stage.act("chair1", 0.5, 0.5)
        stage.work(0.05)
    assert stage.tick > 5
    assert stage.of("power", "chair1")[-1].left_motor == 0.5
    assert replies == []
    assert stage.result("pause").code == "ok"
    tick = stage.tick
    stage.work(0.0)
    assert (stage.of("power", "chair1")[-1].left_motor, stage.of("power", "chair1")[-1].state) == (0.0, "paused")
    ended = replies[0][0]
    assert isinstance(ended, Result)
    assert (ended.code, ended.text) == ("incorrect-state", "paused before all steps were made")
    stage.work(5.0)
    assert stage.tick == tick
    assert stage.of("clock")[-1].state == "paused"
    assert stage.ask("ctl", "step", Step(count=1)) == []


@pytest.mark.parametrize("pace", ["lockstep", "free"])
def test_pause_ends_running_steps_at_every_pace(pace: Pace) -> None:
    stage = Stage(pace=pace)
    stage.join("chair1", barrier=pace == "lockstep")
    stage.result("pause")
    replies = stage.ask("ctl", "step", Step(count=1_000_000))
    stage.act("chair1", 0.5, 0.5)
    stage.act("chair1", 0.5, 0.5)
    assert stage.result("pause").code == "ok"
    tick = stage.tick
    assert len(replies) == 1
    stage.act("chair1", 0.5, 0.5)
    stage.work(2.0)
    assert stage.tick == tick > 0


def test_steps_in_lockstep_wait_for_answers() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    replies = stage.ask("ctl", "step", Step(count=2))
    stage.act("chair1")
    stage.act("chair1")
    assert (stage.tick, len(replies)) == (2, 1)
    stage.act("chair1")
    assert stage.tick == 2


def test_no_answer_is_missed_while_a_strict_run_is_paused() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    stage.work(60.0)
    assert stage.live_run.exit is None
    stage.result("resume")
    stage.work(9.0)
    assert stage.live_run.exit is None


def test_reset_begins_a_new_run_with_the_same_members_and_sessions() -> None:
    stage = Stage()
    stage.join("chair1")
    for _ in range(10):
        stage.act("chair1", 0.5, 0.5)
    result_later = stage.ask("ctl", "reset", Reset(seed="2"))
    stage.act("chair1", 0.5, 0.5)
    result = result_later[0][0]
    assert isinstance(result, Result)
    assert (result.code, result.tick) == ("ok", 0)
    assert result.run not in (None, RUN)
    assert stage.measures("chair1")[-1].run == result.run
    stage.act("chair1", 0.5, 0.5)
    assert stage.tick == 1
    assert stage.of("map")[-1].run == result.run


def test_load_replaces_the_floor_or_says_why_not() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    assert stage.result("load", Load(name="nowhere")).code == "not-found"
    assert stage.live_run.state.run == RUN
    assert stage.result("load", Load(name="corner")).code == "ok"
    info = stage.of("map")[-1]
    assert (info.name, info.revision) == ("corner", 1)
    assert isinstance(stage.ask("map", "")[0][0], Map)


def test_speed_is_for_real_time() -> None:
    assert Stage().result("speed", Speed(factor=2.0)).code == "incorrect-state"
    stage = Stage(pace="realtime")
    assert stage.result("speed", Speed(factor=10.0)).code == "ok"
    stage.work(1.001)
    assert stage.tick == 200


def test_bodies_are_spawned_teleported_and_deleted() -> None:
    stage = Stage(pace="realtime")
    spawned = msgspec.structs.replace(robot("table"), name="table9", format=None)
    assert stage.result("spawn", Spawn(robot=spawned)).code == "ok"
    body = stage.of("body", "table9")[-1]
    assert (body.owner, body.roles) == (None, ())
    at = stage.live_run.state
    x, y = float(at.numbers[0, 0]), float(at.numbers[1, 0])
    teleport = Teleport(agent="table9", position=Position(x=x + 0.2, y=y, heading=0.0))
    assert stage.result("teleport", teleport).code == "ok"
    assert stage.result("delete", b'{"Agent":"table9"}').code == "ok"
    assert stage.result("delete", b'{"Agent":"table9"}').code == "not-found"


def test_agent_whose_body_is_deleted_is_told_at_once_and_when_it_goes_on_sending() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1")
    assert stage.result("delete", Delete(agent="chair1")).code == "ok"
    assert [error.code for error in stage.errors("chair1")] == ["deleted"]
    stage.act("chair1", 0.5, 0.5)
    stage.put("chair1", Actions(session="f" * 16, left_motor=0.5))
    assert [error.code for error in stage.errors("chair1")] == ["deleted", "deleted", "not-joined"]
    # Whoever starts it again wants it back.
    old = stage.sessions["chair1"]
    stage.join("chair1", instance="b" * 16)
    stage.put("chair1", Actions(session=old, left_motor=0.5))
    assert stage.errors("chair1")[-1].code == "session"


def test_deleted_body_that_an_operator_placed_tells_nobody() -> None:
    stage = Stage(pace="realtime")
    stage.result("spawn", Spawn(robot=msgspec.structs.replace(robot("table"), name="table9", format=None)))
    stage.result("delete", Delete(agent="table9"))
    assert stage.errors("table9") == []


def test_live_run_refuses_to_seek() -> None:
    result = Stage().result("seek", b'{"Tick":3}')
    assert (result.code, result.text) == ("unsupported", "this run is live; only a playback can seek")


def test_operator_is_heard_at_the_next_tick() -> None:
    stage = Stage()
    stage.join("chair1")
    replies = stage.ask("ctl", "say", b'{"Text":"stop please"}')
    stage.act("chair1")
    stage.act("chair1")
    assert isinstance(replies[0][0], Result)
    assert [(h.sender, h.text) for h in stage.measures("chair1")[-1].message] == [("operator", "stop please")]


def test_operator_is_heard_once_in_real_time_too() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1")
    stage.work(0.2)
    stage.result("say", b'{"Text":"stop please"}')
    stage.work(0.2)
    heard = [h.text for told in stage.measures("chair1") for h in told.message]
    assert heard == ["stop please"]


def test_quit_ends_with_0() -> None:
    stage = Stage()
    assert stage.result("quit").code == "ok"
    assert stage.live_run.exit == 0


def test_faulty_control_message_is_refused_with_the_reason() -> None:
    stage = Stage()
    reply, ok = stage.ask("ctl", "speed", b'{"Factor":0}')[0]
    assert not ok
    assert isinstance(reply, Result)
    assert reply.text is not None
    assert reply.text.startswith("Speed.Factor: ")
    reply, ok = stage.ask("ctl", "")[0]
    assert isinstance(reply, Result)
    assert reply.code == "unsupported"


def test_taken_chair_obeys_its_user_until_the_lease_ends() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    taken = stage.result("take", Take(agent="chair1"))
    assert taken.lease is not None
    stage.put("chair1", UserInput(lease=taken.lease, forward=1.0, seq=1), "user")
    stage.work(0.25)
    assert stage.of("state")[-1].entity[0].speed > 0.1
    assert stage.of("state")[-1].entity[0].state == "taken"
    stage.put("chair1", UserInput(forward=-1.0), "user")
    assert stage.errors("chair1")[-1].code == "lease"
    stage.work(2.0)
    assert stage.of("state")[-1].entity[0].speed == pytest.approx(0.0, abs=1e-3)
    assert [code for code in stage.events() if code in ("taken", "released")] == ["taken", "released"]


def test_only_the_holder_renews_and_releases_a_lease() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    lease = stage.result("take", Take(agent="chair1")).lease
    assert stage.result("take", Take(agent="chair1")).code == "incorrect-state"
    stage.work(1.5)
    assert stage.result("take", Take(agent="chair1", lease=lease)).lease == lease
    stage.work(1.5)
    assert stage.result("take", Take(agent="chair1", lease=lease, seconds=0.0)).code == "ok"
    assert stage.events().count("released") == 1
    assert stage.result("take", Take(agent="chair9")).code == "not-found"


def test_nothing_is_kept_for_a_spawned_body_that_was_deleted() -> None:
    stage = Stage()
    stage.result("pause")
    box = Robot(name="box1", length=0.5, width=0.5, top=1.0)
    assert stage.result("spawn", Spawn(robot=box, position=Position(x=2.0, y=2.0, heading=0.0))).code == "ok"
    assert stage.result("delete", Delete(agent="box1")).code == "ok"
    assert stage.sent[-1][:2] == ("box1", "undeclare")


def test_every_control_message_has_one_handler() -> None:
    at_once = handle.registry.keys() - {object, Record}
    queued = change.registry.keys() - {object, Record}
    assert set(VERB_CLASSES.values()) == at_once | queued | {Load}
    assert at_once & queued == set()


@pytest.mark.parametrize(
    ("verb", "message", "code"),
    [
        ("fly", b"", "unsupported"),
        ("seek", b'{"Tick":1}', "unsupported"),
        ("speed", b"{}", "failed"),
        ("delete", b'{"Agent":"ghost"}', "not-found"),
        ("take", b'{"Agent":"ghost"}', "not-found"),
        ("step", b'{"Count":1}', "incorrect-state"),
        ("pause", b"", "ok"),
    ],
)
def test_every_failure_is_an_error_reply(verb: str, message: bytes, code: str) -> None:
    ((reply, ok),) = Stage(pace="realtime").ask("ctl", verb, message)
    assert isinstance(reply, Result)
    assert (reply.code, ok) == (code, code == "ok")


@pytest.mark.parametrize(
    ("verb", "data", "text"),
    [
        ("take", b"{}", "ctl/take: expected ctl/take/<agent>, got no name of an agent in the key"),
        (
            "delete",
            b'{"Agent":"chair1"}',
            "ctl/delete: expected ctl/delete/<agent>, got no name of an agent in the key",
        ),
    ],
)
def test_verb_about_an_agent_needs_its_name_in_the_key(verb: str, data: bytes, text: str) -> None:
    stage = Stage()
    stage.join("chair1")
    ((reply, ok),) = stage.ask("ctl", verb, data, agent="")
    assert isinstance(reply, Result)
    assert (reply.code, reply.text, ok) == ("failed", text, False)
    assert stage.live_run.state.names == ("chair1",)


def test_payload_may_not_name_another_agent_than_the_key() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1")
    stage.join("chair2", instance="b" * 16)
    ((reply, _),) = stage.ask("ctl", "delete", b'{"Agent":"chair2"}', agent="chair1")
    assert isinstance(reply, Result)
    assert reply.text == "Delete.Agent: expected 'chair1' as in the key, got 'chair2'"
    ((reply, _),) = stage.ask("ctl", "take", b"", agent="chair1")
    assert isinstance(reply, Result)
    assert (reply.code, reply.lease is not None) == ("ok", True)


def test_query_with_wildcards_gets_no_verb_and_no_refusal() -> None:
    stage = Stage(pace="realtime")
    assert stage.ask("ctl", "", has_wildcards=True) == []
    assert stage.events() == []
