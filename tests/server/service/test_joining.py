from __future__ import annotations

from collections.abc import Sequence

import msgspec
import pytest

from intellwheels_maps import floor, robot
from intellwheels_schemas import defaults
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.file_records import Change
from intellwheels_schemas.messages import (
    Actions,
    Joined,
    Leave,
    Load,
    Measures,
    Pose,
    Record,
    Refused,
    Result,
    Robot,
    Spawn,
    Take,
)
from intellwheels_schemas.metal_codes import is_genuine, power_line
from intellwheels_server.service.arrival import Topic
from intellwheels_server.service.joining import MAX_WAITING
from intellwheels_server.world import Outcome
from intellwheels_server.world.kernels import rows
from tests.server.stage import Stage, real


def test_leave_takes_effect_at_the_next_barrier_and_its_reply_names_the_tick() -> None:
    stage = Stage()
    stage.join_two()
    replies = stage.ask("leave", "chair2", Leave(session=stage.sessions["chair2"]))
    assert replies == []
    stage.act("chair1")
    result = replies[0][0]
    assert isinstance(result, Result)
    assert (result.code, result.tick) == ("ok", 1)
    assert stage.live_run.state.names == ("chair1",)


@pytest.mark.parametrize("topic", ["join", "leave"])
def test_invalid_name_is_refused_once_and_a_wildcard_gets_no_reply(topic: Topic) -> None:
    stage = Stage()
    (reply,) = stage.ask(topic, "")
    message, ok = reply
    assert isinstance(message, Refused | Result)
    assert (message.code, ok) == ("name" if topic == "join" else "failed", False)
    assert message.text is not None
    assert message.text.startswith(f"{topic}/<agent>: expected a name")
    assert stage.ask(topic, "", has_wildcards=True) == []


def test_leave_in_the_last_actions_leaves() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1", 1.0, 1.0, leave=True)
    assert stage.live_run.state.names == ()
    assert stage.tick == 1
    assert "left" in stage.events()


def test_second_agent_of_a_name_is_refused() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    refused, ok = stage.try_join("chair1", instance="b" * 16)
    assert not ok
    assert isinstance(refused, Refused)
    assert (refused.code, refused.text) == ("already-here", "agent 'chair1' is already here")


def test_join_waits_a_moment_for_its_token() -> None:
    stage = Stage()
    wanted = msgspec.structs.replace(robot("rear-wheel"), name="chair1", instance="a" * 16, format=None)
    replies = stage.ask("join", "chair1", wanted)
    assert replies == []
    stage.token("chair1")
    assert isinstance(replies[0][0], Joined)


def test_join_without_token_is_refused() -> None:
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
def test_robot_that_cannot_be_read_is_refused_with_place_and_code(data: bytes, code: str) -> None:
    stage = Stage()
    stage.token("chair1")
    refused, ok = stage.ask("join", "chair1", data)[0]
    assert not ok
    assert isinstance(refused, Refused)
    assert refused.code == code
    assert refused.text.startswith("Robot")


def test_successor_within_the_grace_time_gets_the_body_where_it_is() -> None:
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


def test_replaced_agent_gets_an_error_about_its_session() -> None:
    stage = Stage()
    old = stage.join("chair1").session
    stage.token("chair1", present=False)
    stage.result("pause")
    stage.join("chair1", instance="b" * 16)
    stage.put("chair1", Actions(session=old, left_motor=1.0, right_motor=1.0))
    assert [e.code for e in stage.errors("chair1")] == ["session"]


def test_lost_token_removes_the_body_after_the_grace_time() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(2.9)
    assert stage.live_run.state.names == ("chair1",)
    stage.work(0.2)
    assert len(stage.live_run.state.names) == 0
    assert [code for code in stage.events() if code != "timeout"] == ["joined", "lost", "left"]


def test_token_that_returns_within_the_grace_time_changes_nothing() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(1.0)
    stage.token("chair1")
    stage.work(5.0)
    assert stage.live_run.state.names == ("chair1",)
    assert "returned" in stage.events()


def test_body_stays_while_a_router_is_away_for_a_restart() -> None:
    stage = Stage(strict=False, pace="realtime", grace=defaults.GRACE)
    stage.join("chair1")
    for seconds in (3.0, 14.5):
        stage.token("chair1", present=False)
        stage.work(seconds)
        stage.token("chair1")
    assert "left" not in stage.events()
    stage.token("chair1", present=False)
    stage.work(15.1)
    assert stage.events()[-1] == "left"


def test_member_lost_for_the_grace_time_ends_a_strict_run() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(3.1)
    assert stage.live_run.exit == 1


def test_mind_joins_the_body_of_another_process() -> None:
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


@pytest.mark.parametrize("how", ["leaves", "is lost"])
def test_mind_whose_body_goes_is_told(how: str) -> None:
    stage = Stage(pace="realtime")
    body = stage.join("chair1", msgspec.structs.replace(robot("rear-wheel"), role="body"))
    stage.join("chair1", Robot(role="mind"), "b" * 16)
    if how == "leaves":
        stage.ask("leave", "chair1", Leave(session=body.session))
    else:
        stage.token("chair1", "body", present=False)
        stage.work(3.1)
    (error,) = stage.errors("chair1")
    assert (error.code, error.text) == ("not-joined", "agent 'chair1' has no body any more, so its mind has left too")


def test_body_whose_mind_leaves_is_not_told_that_it_left() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1", msgspec.structs.replace(robot("rear-wheel"), role="body"))
    mind = stage.join("chair1", Robot(role="mind"), "b" * 16)
    stage.ask("leave", "chair1", Leave(session=mind.session))
    assert stage.errors("chair1") == []


def test_reserved_name_and_crews_are_refused() -> None:
    stage = Stage()
    for agent, more, code in (("operator", {}, "name"), ("chair1", {"crew": "many"}, "value")):
        refused, ok = stage.try_join(agent, **more)
        assert not ok
        assert isinstance(refused, Refused)
        assert refused.code == code


def test_real_hardware_is_refused_unless_time_is_real() -> None:
    for options in ({"pace": "lockstep"}, {"pace": "realtime", "speed": 2.0}):
        stage = Stage(**options)
        refused, ok = stage.try_join("chair1", real())
        assert not ok
        assert isinstance(refused, Refused)
        assert refused.code == "real-in-lockstep"
    assert Stage().try_join("chair1", real(hardware="simulated"))[1]


def test_successor_moves_a_body_at_rest_again() -> None:
    stage = Stage(strict=False)
    stage.join("chair1")
    stage.work(3.5)
    assert "rested" in stage.events()
    stage.token("chair1", present=False)
    stage.result("pause")
    start = stage.join("chair1", instance="b" * 16).position
    stage.result("resume")
    for _ in range(20):
        stage.act("chair1", 0.5, 0.5)
    assert stage.events()[-1] == "back"
    assert stage.live_run.state.numbers[rows.X, 0] > start.x + 0.1


def test_new_mind_moves_a_body_at_rest_again() -> None:
    stage = Stage(strict=False)
    stage.join("chair1", role="body", barrier=False)
    stage.result("pause")
    start = stage.join("chair1", Robot(role="mind"), "b" * 16).position
    stage.result("resume")
    stage.work(3.5)
    assert "rested" in stage.events()
    stage.token("chair1", "mind", "b" * 16, present=False)
    stage.work(5.0)
    assert "left" in stage.events()
    stage.result("pause")
    stage.join("chair1", Robot(role="mind"), "c" * 16)
    stage.result("resume")
    for _ in range(20):
        stage.act("chair1", 0.5, 0.5)
    assert stage.events()[-2:] == ["resumed", "back"]
    assert stage.live_run.state.numbers[rows.X, 0] > start.x + 0.1


def test_stale_bridge_that_joins_again_is_fresh_with_its_first_pose() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1", real(), role="body")
    stage.work(1.0)
    session = stage.join("chair1", real(), role="body").session
    stage.work(0.2)
    assert [code for code in stage.events() if code in ("stale", "fresh")] == ["stale"]
    stage.put("chair1", Pose(session=session, x=2.0, y=2.0, heading=0.0), "pose")
    stage.work(0.2)
    assert [code for code in stage.events() if code in ("stale", "fresh")] == ["stale", "fresh"]


def test_simulated_successor_of_a_real_chair_has_no_bridge() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1", real())
    stage.token("chair1", present=False)
    stage.join("chair1", instance="b" * 16)
    stage.work(1.0)
    assert "stale" not in stage.events()


def test_lease_ends_with_its_body() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1")
    lease = stage.result("take", Take(agent="chair1", seconds=10.0)).lease
    stage.token("chair1", present=False)
    stage.join("chair1", "mid-wheel", "b" * 16)
    assert stage.result("take", Take(agent="chair1", lease=lease, seconds=10.0)).code == "incorrect-state"


def test_leave_of_a_body_is_answered_when_its_mind_is_gone_too() -> None:
    stage = Stage(strict=False, pace="realtime")
    body = stage.join("chair1", role="body").session
    stage.join("chair1", Robot(role="mind"), "b" * 16)
    result = stage.ask("leave", "chair1", Leave(session=body))[0][0]
    assert isinstance(result, Result)
    assert stage.live_run.state.names == ()
    assert result.hash == stage.live_run.digest()


def test_only_the_first_reply_to_the_body_of_a_real_robot_has_a_key() -> None:
    stage = Stage(pace="realtime", strict=False)
    first = stage.join("chair1", real())
    assert first.key is not None
    again = stage.join("chair1", real())
    assert (again.session, again.key) == (first.session, None), "its instance is in its token, for anybody to read"
    refused, ok = stage.try_join("chair1", real(), "b" * 16, parameters={"session": first.session})
    assert (ok, isinstance(refused, Refused) and refused.code) == (False, "already-here"), (
        "and its session in its poses"
    )
    stage.token("chair1", present=False)
    successor = stage.join("chair1", real(), "c" * 16)
    assert successor.key not in (None, first.key)
    assert stage.join("chair2").key is None


def test_powers_for_a_real_robot_are_numbered_and_coded() -> None:
    stage = Stage(pace="realtime", strict=False)
    key = stage.join("chair1", real()).key
    for _ in range(5):
        stage.put("chair1", Pose(x=2.0, y=2.0, heading=0.0), "pose")
        stage.work(0.0501)
    powers = stage.of("power", "chair1")
    assert [power.seq for power in powers] == sorted({power.seq for power in powers})
    assert len(powers) > 3
    assert all(is_genuine(key, power_line(power), power.code) for power in powers)


@pytest.mark.parametrize("data", [b"", b"{}", b'{"Session":"ffffffffffffffff"}'])
def test_nobody_leaves_for_a_stranger(data: bytes) -> None:
    stage = Stage()
    stage.join("chair1")
    reply, ok = stage.ask("leave", "chair1", data)[0]
    assert not ok
    assert isinstance(reply, Result)
    assert "ession" in (reply.text or "")
    assert stage.live_run.state.names == ("chair1",)


def test_joins_without_token_are_refused_while_a_barrier_is_open() -> None:
    stage = Stage()
    stage.join("chair1")
    wanted = msgspec.structs.replace(robot("rear-wheel"), instance="a" * 16, format=None)
    replies = [stage.ask("join", f"n{number}", wanted) for number in range(MAX_WAITING + 5)]
    assert [bool(reply) for reply in replies] == [False] * MAX_WAITING + [True] * 5
    stage.work(0.5)
    assert stage.tick == 0
    assert {reply.code for ((reply, _),) in replies if isinstance(reply, Refused)} == {"no-token"}


CAST = {"chair1": "start1", "chair2": "start2"}


def place_of(stage: Stage, agent: str) -> tuple[float, float]:
    position = stage.join(agent).position
    return position.x, position.y


def test_guest_gets_a_spare_place_and_the_cast_its_own_whoever_comes_first() -> None:
    stage = Stage(expect=("chair1", "chair2"), reserved=CAST)
    guest = place_of(stage, "guest")
    assert place_of(stage, "chair2") == (7.6, 6.8)
    assert place_of(stage, "chair1") == (1.2, 2.6)
    assert guest == (7.6, 0.95)  # start3, the first that is nobody's


def test_guest_at_a_place_of_the_cast_is_refused_also_while_it_is_empty() -> None:
    stage = Stage(reserved=CAST)
    refused, ok = stage.try_join("guest", place="start1")
    assert not ok
    assert isinstance(refused, Refused)
    words = "agent 'guest' would be in the way at place 'start1', which is kept for another agent"
    assert (refused.code, refused.text) == ("overlaps", words)


def test_guest_is_refused_in_words_when_only_places_of_the_cast_are_left() -> None:
    places = [spot.name for spot in floor("room").grid.position if "wheelchair" in spot.kinds]  # type: ignore[union-attr]
    stage = Stage(reserved={f"chair{number}": place for number, place in enumerate(places)})
    refused, ok = stage.try_join("guest")
    assert not ok
    assert isinstance(refused, Refused)
    assert refused.code == "no-place"
    assert f"besides those kept for other agents ({', '.join(places)})" in refused.text


def test_spawned_body_leaves_the_places_of_the_cast_free_unless_an_operator_says_where() -> None:
    stage = Stage(pace="realtime", reserved=CAST)
    crate = msgspec.structs.replace(robot("rear-wheel"), name="crate", format=None)
    assert stage.result("spawn", Spawn(robot=crate)).code == "ok"
    assert place_of(stage, "chair1") == (1.2, 2.6)
    other = msgspec.structs.replace(crate, name="other", place="start2")
    assert stage.result("spawn", Spawn(robot=other)).code == "ok"


def test_places_of_the_cast_are_nobodys_on_another_map() -> None:
    stage = Stage(pace="realtime", reserved={"chair1": "start1", "chair2": "no-such-place"})
    stage.join("guest")
    assert stage.result("load", Load(name="corner")).code == "ok"
    stage.join("chair1", instance="b" * 16)


def queued(stage: Stage, monkeypatch: pytest.MonkeyPatch, wanted: list[tuple[str, Robot]]) -> list[Record]:
    """Return the answers to joins that arrived before anything was done about them."""
    with monkeypatch.context() as patch:
        patch.setattr(stage, "work", lambda *_: None)
        replies = []
        for number, (agent, one) in enumerate(wanted):
            one = msgspec.structs.replace(one, instance=f"{number:016x}", format=None)  # noqa: PLW2901 - its own
            stage.token(agent, one.role, f"{number:016x}")
            replies.append(stage.ask("join", agent, one))
    stage.work()
    assert all(len(each) == 1 for each in replies)
    return [each[0][0] for each in replies]


def test_joins_that_wait_change_the_bodies_once_and_as_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    chair = robot("rear-wheel")
    names = [f"chair{k}" for k in range(1, 4)]
    single, together = Stage(pace="realtime"), Stage(pace="realtime")
    changes = []
    apply = together.live_run._service.apply_all

    def counted(some: Sequence[Change]) -> tuple[Outcome, ...]:
        changes.append(some)
        return apply(some)

    monkeypatch.setattr(together.live_run._service, "apply_all", counted)
    answers = queued(together, monkeypatch, [(name, chair) for name in names])
    for number, name in enumerate(names):
        single.try_join(name, chair, f"{number:016x}")
    assert [len(some) for some in changes] == [3]
    assert all(isinstance(answer, Joined) for answer in answers)
    positions = [answer.position for answer in answers if isinstance(answer, Joined)]
    assert positions == [single.live_run.state.body_set.models[name].start for name in names]
    assert together.events() == single.events() == ["joined"] * 3
    assert [len(stage.of("body", "chair3")) for stage in (together, single)] == [1, 1]
    bare = {name: msgspec.structs.replace(chair, name=name) for name in names}
    for state in (together.live_run.state, single.live_run.state):
        models = state.body_set.models
        assert [msgspec.structs.replace(models[n].robot, instance=None, format=None) for n in names] == [
            msgspec.structs.replace(one, format=None) for one in bare.values()
        ]
    assert together.live_run.digest() == single.live_run.digest()


def test_each_of_the_joins_that_wait_is_refused_for_its_own_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    chair = robot("rear-wheel")
    stage = Stage(pace="realtime")
    nowhere = msgspec.structs.replace(chair, place="nowhere")
    mind = Robot(role="mind")
    wanted = [
        ("chair1", chair), ("chair2", nowhere), ("chair3", msgspec.structs.replace(chair, format="iw.v1", name="x")),
        ("chair1", chair), ("chair4", chair), ("chair5", mind), ("chair1", mind),
    ]  # fmt: skip
    answers = queued(stage, monkeypatch, wanted)
    codes = [answer.code if isinstance(answer, Refused) else "" for answer in answers]
    assert codes == ["", "no-place", "name", "already-here", "", "no-body", "already-here"]
    assert stage.live_run.state.names == ("chair1", "chair4")
