from __future__ import annotations

import itertools
from pathlib import Path

import msgspec
import pytest

from intellwheels_maps import robot
from intellwheels_schemas.messages import (
    Actions,
    Clock,
    End,
    Joined,
    Load,
    Pose,
    Refused,
    Reset,
    Result,
    Robot,
    Take,
    Timeout,
    UserInput,
)
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.service.pace import WATCHED
from tests.server.log_edits import records, rewrite
from tests.server.stage import RUN, Stage, real


def test_measures_0_come_before_any_command_and_a_tick_follows_each_answer() -> None:
    stage = Stage()
    joined = stage.join("chair1")
    assert (joined.run, joined.tick) == (RUN, 0)
    for tick in range(5):
        assert [m.tick for m in stage.measures("chair1")] == list(range(tick + 1))
        stage.act("chair1", 0.5, 0.5)
    assert stage.tick == 5
    assert stage.errors("chair1") == []


def test_barrier_waits_for_every_member() -> None:
    stage = Stage()
    stage.join_two()
    stage.act("chair1")
    assert stage.tick == 0
    stage.act("chair2")
    assert stage.tick == 1


def test_run_stays_at_tick_0_until_all_expected_agents_have_joined() -> None:
    stage = Stage(expect=("chair1", "chair2"))
    stage.join("chair1")
    assert stage.lines == []
    assert stage.measures("chair1") == []
    clock = stage.of("clock")[-1]
    stage.work(1.0)
    clock = stage.of("clock")[-1]
    assert (clock.state, clock.waiting) == ("waiting", ("chair2",))
    stage.join("chair2", instance="b" * 16)
    assert stage.lines == [f"running tick=0 run={stage.live_run.state.run}"]
    assert [m.tick for m in stage.measures("chair1")] == [0]


def test_join_in_a_running_lockstep_takes_effect_at_the_next_barrier() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1")
    stage.token("chair2", instance="b" * 16)
    wanted = msgspec.structs.replace(robot("rear-wheel"), name="chair2", instance="b" * 16, format=None)
    replies = stage.ask("join", "chair2", wanted)
    assert replies == []
    stage.act("chair1")
    joined = replies[0][0]
    assert isinstance(joined, Joined)
    assert joined.tick == 2
    assert [m.tick for m in stage.measures("chair2")] == [2]
    stage.act("chair1")
    assert stage.tick == 2


def test_unanswered_measures_are_sent_again() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.work(0.15)
    assert [m.tick for m in stage.measures("chair1")] == [0, 0, 0, 0]


def test_missed_answer_ends_a_strict_run_with_exit_1() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1")
    stage.work(10.1)
    assert stage.live_run.exit == 1
    assert stage.lines[-1] == "miss agent=chair1 tick=1"


def test_elastic_run_rests_a_body_after_three_misses_until_it_answers() -> None:
    stage = Stage(strict=False)
    stage.join_two()
    for _ in range(3):
        stage.act("chair1")
        stage.work(1.01)
    assert stage.tick == 3
    assert [code for code in stage.events() if code in ("late", "rested")] == ["late", "late", "late", "rested"]
    stage.act("chair2", 0.5, 0.5)
    stage.act("chair1")
    assert stage.events()[-1] == "back"
    tick = stage.tick
    stage.act("chair1")
    assert stage.tick == tick


def test_barrier_waits_again_for_a_resting_agent_that_answers_late() -> None:
    stage = Stage(strict=False)
    stage.join_two()
    for _ in range(4):
        stage.act("chair1")
        stage.work(1.01)
    stage.act("chair2", tick=stage.tick - 1)
    assert stage.errors("chair2")[-1].code == "late"
    stage.act("chair1")
    tick = stage.tick
    stage.act("chair1")
    assert stage.tick == tick


def test_barrier_does_not_wait_for_a_member_with_barrier_false() -> None:
    stage = Stage()
    stage.join("watcher", instance="b" * 16, barrier=False)
    stage.join("chair1")
    stage.act("chair1")
    assert stage.tick == 1
    assert [m.tick for m in stage.measures("watcher")] == [0, 1]


def test_lockstep_without_members_waits() -> None:
    stage = Stage()
    stage.work(5.0)
    assert stage.tick == 0
    assert stage.of("clock")[-1].state == "waiting"
    assert 8 <= len(stage.of("clock")) <= 13


def test_real_time_keeps_its_ticks_at_any_speed() -> None:
    stage = Stage(pace="realtime", speed=4.0)
    stage.work(10.01)
    assert stage.tick == 800
    clock = stage.of("clock")[-1]
    assert (clock.state, clock.late, clock.speed) == ("running", 0, 4.0)
    assert clock.factor == pytest.approx(4.0, rel=0.05)


def test_free_run_refuses_an_agent_that_wants_its_answers_awaited() -> None:
    stage = Stage(pace="free")
    stage.result("pause")
    refused, ok = stage.try_join("chair1")
    assert not ok
    assert isinstance(refused, Refused)
    assert "--open-loop" in refused.text
    assert isinstance(stage.join("chair1", barrier=False), Joined)


def test_end_is_printed_with_tick_and_hash_and_resume_continues() -> None:
    stage = Stage(end=End(timeout=Timeout(seconds=0.1)))
    stage.join("chair1")
    stage.act("chair1")
    stage.act("chair1")
    assert stage.lines[-1] == f"ended tick=2 hash={stage.live_run.digest()} run={stage.live_run.state.run}"
    assert stage.of("clock")[-1].state == "ended"
    stage.act("chair1")
    assert stage.tick == 2
    assert stage.result("resume").code == "ok"
    assert stage.tick == 3


def test_service_can_quit_at_the_end() -> None:
    stage = Stage(end=End(timeout=Timeout(seconds=0.05)), quit_at_end=True)
    stage.join("chair1")
    stage.act("chair1")
    assert stage.live_run.exit == 0


def test_chair_whose_bridge_is_silent_is_stale_until_it_reports() -> None:
    stage = Stage(pace="realtime", strict=False)
    session = stage.join("chair1", real()).session
    stage.work(1.0)
    stage.put("chair1", Pose(session=session, x=2.0, y=2.0, heading=0.0), "pose")
    stage.work(0.2)
    assert [code for code in stage.events() if code in ("stale", "fresh")] == ["stale", "fresh"]


def test_in_lockstep_a_simulated_bridge_answers_with_its_pose() -> None:
    stage = Stage()
    stage.result("pause")
    body = stage.join("chair1", real(hardware="simulated", role="body")).session
    mind = stage.join("chair1", Robot(role="mind"), "b" * 16).session
    stage.result("resume")
    stage.put("chair1", Pose(session=body, tick=0, x=2.0, y=2.0, heading=0.0), "pose")
    assert stage.tick == 0
    stage.put("chair1", Actions(session=mind, tick=0, left_motor=0.25, right_motor=0.25))
    assert stage.tick == 1
    assert stage.of("power", "chair1")[-1].tick == 0


def same(path: Path) -> None:
    found = resimulate(path)
    assert found.differs is None
    assert not found.cut


def test_log_of_an_elastic_run_with_everything_in_it_gives_the_same_hashes(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    stage = Stage(strict=False, log=path)
    stage.join_two(user_input=("drive",))
    lease = stage.ask("ctl", "take", Take(agent="chair1", seconds=2.0))
    for tick in range(30):
        stage.act("chair1", 0.5, 0.4, say="hello" if tick % 5 == 0 else None)
        if tick % 3:
            stage.put("chair2", UserInput(forward=0.5, seq=tick), "user")
            stage.act("chair2", 0.2, 0.3)
        stage.work(1.01)
    assert isinstance(lease[0][0], Result)
    stage.token("chair2", instance="b" * 16, present=False)
    stage.work(4.0)
    stage.ask("ctl", "reset", Reset(seed="7"))
    stage.work(1.1)
    for _ in range(5):
        stage.act("chair1", -0.3, 0.4)
    stage.result("pause")
    stage.result("load", Load(name="corner"))
    stage.result("resume")
    for _ in range(5):
        stage.act("chair1", 0.3, 0.4)
    stage.result("pause")
    stage.live_run.finish(stage.now)
    assert stage.log is not None
    stage.log.close()
    assert stage.tick >= 5
    same(path)


def test_changed_log_differs_at_the_changed_tick(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    stage = Stage(log=path)
    stage.join("chair1")
    for _ in range(10):
        stage.act("chair1", 0.5, 0.5)
    stage.live_run.finish(stage.now)
    assert stage.log is not None
    stage.log.close()
    same(path)
    lines = records(path)
    lines[5] = lines[5].replace(b'"LeftMotor":0.5', b'"LeftMotor":0.6')
    rewrite(path, lines)
    found = resimulate(path)
    assert found.differs is not None
    assert found.differs.startswith(f"tick 4 of run {RUN} (line 6): expected hash ")


def test_two_strict_runs_with_one_seed_give_one_hash_whatever_the_timing() -> None:
    hashes = []
    for delay in (0.0, 0.3):
        stage = Stage()
        stage.join_two()
        order: list[str] = ["chair1", "chair2"] if delay else ["chair2", "chair1"]
        for tick in range(40):
            for agent in order:
                stage.act(agent, 0.5, 0.4 + 0.005 * tick)
                stage.work(delay)
        hashes.append(stage.live_run.digest())
    assert hashes[0] == hashes[1]


def test_a_run_that_awaits_a_page_stays_at_tick_0_until_it_is_resumed() -> None:
    stage = Stage(pace="realtime", strict=False, await_page=True)
    stage.join("chair1")
    stage.work(2.0)
    assert (stage.tick, stage.of("clock")[-1].state) == (0, "paused")
    assert [event.code for event in stage.of("event")] == ["joined"]
    assert stage.result("resume").code == "ok"
    stage.work(2.0)
    assert stage.tick > 0


@pytest.mark.parametrize("stop", ["wait", "pause"])
def test_a_real_chair_is_not_stale_because_the_run_stood_still(stop: str) -> None:
    """While no tick is made, no bridge is asked for a pose; a bridge that stays silent is found afterwards."""
    stage = Stage(pace="realtime", strict=False, expect=("chair1", "chair2") if stop == "wait" else ())
    stage.join("chair1", real())
    if stop == "wait":
        stage.now += 60.0
        stage.join("chair2", instance="b" * 16)
    else:
        stage.result("pause")
        stage.now += 60.0
        stage.result("resume")
    stage.work(0.25)
    assert stage.tick > 0
    assert "stale" not in stage.events()
    stage.work(0.2)
    assert "stale" in stage.events()


def test_load_is_told_when_ticks_begin_to_be_late_and_when_they_are_on_time_again() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1", instance="a" * 16)
    stage.work(1.0)
    seconds = itertools.count()
    stage.live_run._timer = lambda: 0.02 * next(seconds)
    for _ in range(2 * WATCHED):
        stage.now += 0.06
        stage.live_run.work(stage.now)
        stage.live_run.spend(0.05, stage.now)
    for _ in range(100):
        stage.put("chair1", b"{}", "say")
    clock = stage.ask("clock", "")[0][0]
    assert isinstance(clock, Clock)
    assert clock.late > WATCHED
    assert clock.world == pytest.approx(0.02 / 0.06, rel=0.1)
    assert clock.wire == pytest.approx(clock.load - clock.world)
    assert clock.flooding == "chair1"
    told = [note for note in stage.notes if note.startswith("ticks")]
    assert len(told) == 1
    assert told[0].startswith("ticks are late tick=")
    assert " wire=" in told[0]
    assert told[0].endswith("costliest=chair1")
    stage.work(2.0)
    told = [note for note in stage.notes if note.startswith("ticks")]
    assert len(told) == 2
    assert told[1].startswith("ticks are on time again tick=")
