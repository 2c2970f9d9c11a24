from __future__ import annotations

import math

import pytest

from intellwheels_maps import floor
from intellwheels_schemas.messages import (
    Body,
    Pose,
    Position,
    PowerInForce,
    Result,
    Robot,
    Speed,
    WorldState,
)
from tests.server.stage import Stage, real


def test_state_and_clock_are_published_at_most_sixty_times_a_second() -> None:
    stage = Stage(pace="realtime", speed=50.0)
    stage.work(1.0)
    assert stage.tick >= 999
    assert 50 <= len(stage.of("clock")) <= 62


def test_last_state_before_a_pause_is_published() -> None:
    stage = Stage(pace="realtime", speed=50.0)
    stage.work(0.503)
    stage.result("pause")
    assert stage.of("state")[-1].tick == stage.tick
    assert stage.of("clock")[-1].state == "paused"


def test_events_are_numbered_and_can_be_asked_for() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    events = stage.ask("event", "", parameters={"since": "1"})[0][0]
    assert [event.code for event in events.event] == ["paused"]  # type: ignore[attr-defined]
    assert not stage.ask("event", "", parameters={"since": "x"})[0][1]


def test_late_viewer_can_ask_for_state_and_bodies() -> None:
    stage = Stage()
    stage.join("chair1")
    assert [type(reply) for reply, _ in stage.ask("state", "")] == [WorldState]
    assert [type(reply) for reply, _ in stage.ask("body", "")] == [Body]
    assert stage.ask("body", "", matches=lambda name: name == "chair2") == []


def test_real_chair_is_where_its_bridge_says_and_gets_power_each_tick() -> None:
    stage = Stage(pace="realtime", strict=False)
    session = stage.join("chair1", real()).session
    for tick in range(10):
        stage.put("chair1", Pose(session=session, x=2.0, y=2.0 + 0.01 * tick, heading=0.0), "pose")
        stage.act("chair1", 0.5, 0.5)
        stage.work(0.0501)
    assert stage.of("state")[-1].entity[0].y == pytest.approx(2.09, abs=0.011)
    powers = stage.of("power", "chair1")
    assert [p.tick for p in powers] == list(range(len(powers)))
    assert (powers[-1].left_motor, powers[-1].state) == (0.5, "drive")


def test_pause_and_speed_stop_real_chairs() -> None:
    stage = Stage(pace="realtime", strict=False)
    session = stage.join("chair1", real()).session

    def drive() -> PowerInForce:
        stage.put("chair1", Pose(session=session, x=2.0, y=2.0, heading=0.0), "pose")
        stage.act("chair1", 0.5, 0.5)
        stage.work(0.06)
        power: PowerInForce = stage.of("power", "chair1")[-1]
        return power

    assert drive().left_motor == 0.5
    stage.result("pause")
    stage.work(0.2)
    power = stage.of("power", "chair1")[-1]
    assert (power.left_motor, power.state) == (0.0, "paused")
    stage.result("resume")
    assert drive().left_motor == 0.5
    stage.result("speed", Speed(factor=2.0))
    assert drive().left_motor == 0.0
    stage.result("speed", Speed(factor=1.0))
    assert drive().left_motor == 0.5
    stage.live_run.finish(stage.now)
    assert stage.of("power", "chair1")[-1].left_motor == 0.0


def test_published_body_has_the_user_input_of_a_mind_in_another_process() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1", real(role="body"))
    assert stage.of("body", "chair1")[-1].robot.user_input == ()
    stage.join("chair1", Robot(role="mind", user_input=("goal",)), instance="c" * 16)
    assert stage.of("body", "chair1")[-1].robot.user_input == ("goal",)


def test_a_body_that_joined_at_a_place_is_published_with_the_pose_where_it_joined() -> None:
    stage = Stage()
    stage.join("chair1", place="start1")
    place = next(one for one in floor("room").grid.position if one.name == "start1")  # type: ignore[union-attr]
    start = Position(x=place.x, y=place.y, heading=math.radians(place.heading_deg))
    assert stage.of("body", "chair1")[-1].robot.position == start
    stage.act("chair1", 1.0, 0.5)
    stage.work(2.0)
    assert [reply.robot.position for reply, _ in stage.ask("body", "")] == [start]  # type: ignore[attr-defined]


def test_state_goes_out_twice_a_second_while_nothing_moves_and_the_clock_at_each_tick() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    stage.work(0.5)
    stage.sent.clear()
    stage.work(4.0)
    assert 7 <= len(stage.of("state")) <= 9
    assert 79 <= len(stage.of("clock")) <= 81
    stage.act("chair1", 0.5, 0.5)
    stage.sent.clear()
    stage.work(0.4)
    assert len(stage.of("state")) >= 7
    assert stage.of("state")[-1].tick == stage.tick


def test_what_an_agent_says_is_in_the_state_at_once_though_nothing_moves() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    stage.work(1.0)
    stage.act("chair1", say="hello")
    stage.work(0.06)
    assert stage.of("state")[-1].entity[0].say == "hello"
    assert stage.of("state")[-1].tick >= stage.tick - 1


@pytest.mark.parametrize("since", ["abc", "-1", "1.5", "9" * 17, "\u0663"])
def test_events_since_something_that_is_no_number_are_refused_in_words(since: str) -> None:
    ((reply, ok),) = Stage().ask("event", "", parameters={"since": since})
    assert not ok
    assert isinstance(reply, Result)
    assert reply.code == "failed"
    assert reply.text == f"event?since: expected a number, got {since!r}"


def test_no_state_is_made_while_nobody_reads_it_and_a_reader_gets_it_at_once() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    stage.reads_state = False
    stage.sent.clear()
    stage.work(0.5)
    assert stage.of("state") == []
    assert len(stage.of("clock")) >= 9
    assert stage.ask("state", "")[0][0].entity[0].name == "chair1"  # type: ignore[attr-defined]
    stage.reads_state = True
    stage.work(0.06)
    assert len(stage.of("state")) == 1
