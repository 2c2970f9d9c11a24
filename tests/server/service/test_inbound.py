from __future__ import annotations

import pytest

from intellwheels_schemas.messages import (
    Actions,
    Pose,
    Say,
    Take,
    UserInput,
)
from intellwheels_schemas.metal_codes import code_of, pose_line
from intellwheels_server.service.arrival import Put
from tests.server.stage import Stage, real


def test_answer_counts_once_and_repeated_bytes_give_no_error() -> None:
    stage = Stage()
    stage.join_two()
    stage.act("chair1", 0.1, 0.1, seq=1)
    stage.act("chair1", 0.1, 0.1, seq=1)
    assert stage.errors("chair1") == []
    stage.act("chair1", 0.2, 0.2, seq=2)
    assert [(e.code, e.seq) for e in stage.errors("chair1")] == [("answered", 2)]


def test_late_repetition_of_an_answer_gives_no_error() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1", tick=0)
    stage.act("chair1", tick=0)
    assert stage.tick == 1
    assert stage.errors("chair1") == []


def test_wrong_ticks_and_runs_give_an_error() -> None:
    stage = Stage()
    stage.join("chair1")
    for _ in range(3):
        stage.act("chair1", 0.1, 0.1)
    stage.act("chair1", 0.2, 0.2, tick=1)
    stage.act("chair1", 0.2, 0.2, tick=7)
    stage.put("chair1", Actions(run="f" * 16, tick=3))
    assert [e.code for e in stage.errors("chair1")] == ["late", "early", "late"]
    assert stage.tick == 3


def test_actions_in_the_form_of_the_paper_count_for_the_current_tick() -> None:
    stage = Stage()
    stage.join("chair1")
    session = stage.sessions["chair1"].encode()
    form = b'<Actions Session="%s" LeftMotor="0.5" RightMotor="0.4"><Say><![CDATA[follow me]]></Say></Actions>'
    stage.put("chair1", form % session, encoding="")
    assert stage.tick == 1


def test_agent_that_has_not_joined_gets_a_few_errors() -> None:
    stage = Stage()
    for number in range(50):
        stage.put("ghost", Actions(seq=number))
    assert {e.code for e in stage.errors("ghost")} == {"not-joined"}
    assert len(stage.errors("ghost")) <= 10


def test_flood_is_limited_and_gives_an_error() -> None:
    stage = Stage()
    stage.join_two()
    for number in range(5000):
        stage.put("chair1", Actions(seq=number))
    assert len(stage.errors("chair1")) <= 20
    stage.work(1.0)
    stage.put("chair1", b"rubbish")
    assert stage.errors("chair1")[-1].suppressed > 4000


def test_flood_of_user_input_does_not_use_up_the_limit_of_the_agent() -> None:
    stage = Stage()
    stage.join("chair1")
    for number in range(1000):
        stage.put("chair1", UserInput(seq=number), "user")
    stage.act("chair1", 0.5, 0.5)
    assert stage.tick == 1


def test_newest_actions_win_where_no_answer_is_expected() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1")
    stage.act("chair1", 1.0, 1.0, seq=2)
    stage.act("chair1", -1.0, -1.0, seq=1)
    stage.work(0.3)
    assert stage.of("state")[-1].entity[0].speed > 0.0


def test_measures_carry_the_user_input_that_a_robot_declares() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1", user_input=("drive",))
    stage.put("chair1", UserInput(forward=0.5, turn=0.1, seq=3), "user")
    stage.work(0.06)
    heard = stage.measures("chair1")[-1].user_input
    assert heard is not None
    assert (heard.forward, heard.turn) == (0.5, 0.1)
    stage.work(0.5)
    heard = stage.measures("chair1")[-1].user_input
    assert heard is None or heard.forward == 0.0


def test_say_is_in_the_next_measures_in_any_encoding() -> None:
    stage = Stage()
    stage.join_two()
    session = stage.sessions["chair1"].encode()
    for data, encoding in (
        (b'{"Session":"%s","Text":"hello"}' % session, "application/json"),
        (b'<Say Session="%s" Seq="2"><![CDATA[hello]]></Say>' % session, "application/xml"),
    ):
        stage.put("chair1", data, "say", encoding)
        stage.act("chair1", seq=stage.tick)
        stage.act("chair2", seq=stage.tick)
        assert [(h.sender, h.text) for h in stage.measures("chair2")[-1].message] == [("chair1", "hello")]


def test_say_that_is_too_long_gives_an_error_and_the_motors_count() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1", 0.5, 0.5, say="x" * 101)
    assert stage.errors("chair1")[-1].code == "too-long"
    assert stage.tick == 1
    stage.put("chair1", Say(text="y" * 101), "say")
    assert stage.errors("chair1")[-1].where == "Say"


def test_say_beside_actions_with_a_say_gives_an_error() -> None:
    stage = Stage()
    stage.join_two()
    stage.put("chair1", Say(text="beside", seq=7), "say")
    stage.act("chair1", say="heard")
    stage.act("chair2")
    assert [(e.code, e.where, e.seq) for e in stage.errors("chair1")] == [("too-many", "Say", 7)]
    assert [h.text for h in stage.measures("chair2")[-1].message] == ["heard"]


@pytest.mark.parametrize(
    ("session", "code"), [(b"", "field"), (b'"Session":"ffffffffffffffff",', "session"), (None, "")]
)
def test_message_counts_only_with_the_session_of_the_join(session: bytes | None, code: str) -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1", real())
    shown = b'"Session":"%s",' % stage.sessions["chair1"].encode() if session is None else session
    code_of_pose = code_of(stage.keys["chair1"], pose_line(Pose(x=2.0, y=2.0, heading=0.0))).encode()
    stage.put("chair1", b'{%s"X":2.0,"Y":2.0,"Heading":0.0,"Code":"%s"}' % (shown, code_of_pose), "pose")
    stage.put("chair1", b'{%s"LeftMotor":1.0}' % shown)
    stage.put("chair1", b'{%s"Text":"hello"}' % shown, "say")
    assert [e.code for e in stage.errors("chair1")] == ([code] * 3 if code else [])


@pytest.mark.parametrize("code", [None, "0" * 32])
def test_pose_without_the_code_of_the_bridge_is_forged(code: str | None) -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1", real())
    del stage.keys["chair1"]
    stage.put("chair1", Pose(x=9.0, y=2.0, heading=0.0, code=code), "pose")
    (error,) = stage.errors("chair1")
    assert (error.code, error.where) == ("forged", "Pose.Code")


def test_pose_of_a_simulated_chair_gives_an_error() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    stage.put("chair1", Pose(x=2.0, y=2.0, heading=0.0), "pose")
    assert [e.code for e in stage.errors("chair1")] == ["role"]


@pytest.mark.parametrize(
    "data",
    [
        b'{"Session":"%s","LeftMotor":0.5,"RightMotor":0.4}',
        b'<Actions Session="%s" LeftMotor="0.5" RightMotor="0.4"/>',
    ],
)
def test_same_bytes_without_a_tick_answer_one_tick_after_the_other(data: bytes) -> None:
    stage = Stage()
    stage.join("chair1")
    for tick in range(5):
        assert stage.tick == tick
        stage.put("chair1", data % stage.sessions["chair1"].encode(), encoding="")
    assert stage.tick == 5
    assert stage.errors("chair1") == []


@pytest.mark.parametrize(
    ("key", "hint"),
    [("in/chair1/action", "in/chair1/actions"), ("in/chair1/Say", "in/chair1/say"), ("user/chair1/x", "user/chair1")],
)
def test_mistyped_key_is_reported_to_its_agent(key: str, hint: str) -> None:
    stage = Stage()
    stage.join("chair1")
    stage.live_run.take(Put("chair1", "stray", b"", "", key=key), stage.now)
    (error,) = stage.errors("chair1")
    assert (error.code, error.where) == ("field", key)
    assert error.text.startswith("key: expected ")
    assert error.text.endswith(f"got {key!r}; did you mean {hint}?")


def test_key_without_a_name_is_reported_in_the_log_and_seldom() -> None:
    stage = Stage()
    for _ in range(100):
        stage.live_run.take(Put("", "stray", b"", "", key="in/Chair1/actions"), stage.now)
    lines = [line for line in stage.notes if "in/Chair1/actions" in line]
    assert 1 <= len(lines) <= 3


def test_user_input_that_nobody_asked_for_is_reported_seldom_and_not_obeyed() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    for number in range(120):
        stage.put("chair1", UserInput(forward=1.0, seq=number), "user")
        stage.work(0.05)
    errors = stage.errors("chair1")
    assert 2 <= len(errors) <= 4
    assert {(error.code, error.where) for error in errors} == {("role", "UserInput")}
    assert "got 'chair1'" in errors[0].text
    assert errors[-1].suppressed > 10
    assert stage.live_run.state.user == {}


def test_user_input_for_nobody_is_reported_to_whoever_listens_there() -> None:
    stage = Stage()
    stage.put("ghost", UserInput(forward=1.0), "user")
    (error,) = stage.errors("ghost")
    assert (error.code, error.text) == (
        "not-joined",
        "UserInput: expected the name of an agent that is here, got 'ghost'",
    )


def test_user_input_under_a_lease_is_not_reported() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    lease = stage.result("take", Take(agent="chair1")).lease
    stage.put("chair1", UserInput(lease=lease, forward=1.0), "user")
    stage.work(0.2)
    assert stage.errors("chair1") == []
    assert stage.of("state")[-1].entity[0].speed > 0.0
