from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from intellwheels_maps import robot
from intellwheels_schemas.messages import (
    Actions,
    Clock,
    CrewLeave,
    Events,
    Map,
    Pose,
    Refused,
    Result,
    Robot,
    Seek,
    Speed,
    Step,
)
from intellwheels_server.service.arrival import Put
from tests.server.plays import PlayStage, Seen, record
from tests.server.stage import RUN, Stage, real


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("play") / "log"


@pytest.fixture(scope="module")
def seen(log: Path) -> list[Seen]:
    return record(log)


@pytest.fixture
def stage(log: Path, seen: list[Seen]) -> Iterator[PlayStage]:
    stage = PlayStage(log)
    yield stage
    stage.close()


def clock(stage: PlayStage) -> Clock:
    found = stage.of("clock")[-1]
    assert isinstance(found, Clock)
    return found


def test_playback_publishes_what_the_live_world_published(stage: PlayStage, seen: list[Seen]) -> None:
    assert [info.name for info in stage.of("map")] == ["room"]
    assert stage.of("body", "chair1")[-1].roles == ("both",)
    stage.work(10.0)
    told = [(one.run, one.tick, one.hash) for one in stage.of("clock")]
    assert {(one.run, one.tick) for one in seen} <= {one[:2] for one in told}
    changed = {0, 10, 20, 30}  # where changes were made at a tick, it has two hashes
    assert {one for one in seen if one.tick not in changed} <= set(told)
    assert [one.tick for one in stage.measures("chair1")][:50] == list(range(50))
    assert [one.tick for one in stage.measures("chair2")][:20] == list(range(10, 30))
    assert [event.code for event in stage.of("event")][:3] == ["joined", "left", "reset"]
    assert (clock(stage).state, clock(stage).tick, clock(stage).last) == ("ended", 35, 35)
    assert stage.lines == [f"ended tick=35 hash={seen[-1].hash} run={seen[-1].run}"]


def test_playback_runs_at_the_requested_speed(log: Path, seen: list[Seen]) -> None:
    stage = PlayStage(log, speed=2.0)
    stage.work(0.51)
    assert stage.tick == 20
    assert stage.result("speed", Speed(factor=0.5)).code == "ok"
    stage.work(1.01)
    assert stage.tick == 30
    assert (clock(stage).speed, clock(stage).late, clock(stage).pace) == (0.5, 0, "realtime")
    stage.close()


def test_pause_stops_steps_move_and_resume_continues(stage: PlayStage) -> None:
    assert stage.result("step", Step(count=2)).code == "incorrect-state"
    assert stage.result("pause").code == "ok"
    tick = stage.tick
    stage.work(3.0)
    assert stage.tick == tick
    assert clock(stage).state == "paused"
    replies = stage.ask("ctl", "step", Step(count=3))
    stage.work(0.2)
    assert isinstance(replies[0][0], Result)
    assert (replies[0][0].code, replies[0][0].tick) == ("ok", tick + 3)
    stage.work(1.0)
    assert stage.tick == tick + 3
    assert stage.result("resume").code == "ok"
    stage.work(0.26)
    assert stage.tick == tick + 8


def test_seek_reaches_later_and_earlier_ticks_and_other_runs(stage: PlayStage, seen: list[Seen]) -> None:
    hashes = {one[:2]: one.hash for one in seen}
    stage.result("pause")
    for tick in (45, 12, 31, 25):
        result = stage.result("seek", Seek(tick=tick))
        assert (result.code, result.tick, result.hash) == ("ok", tick, hashes[RUN, tick])
        assert (clock(stage).tick, clock(stage).hash, clock(stage).last) == (tick, hashes[RUN, tick], 50)
        assert [entity.name for entity in stage.of("state")[-1].entity] == list(stage.live_run.state.names)
        assert stage.measures("chair1")[-1].tick == tick
    run = seen[-1].run
    result = stage.result("seek", Seek(tick=30, run=run))
    assert (result.run, result.hash) == (run, hashes[run, 30])
    assert (clock(stage).run, clock(stage).last) == (run, 35)
    assert stage.live_run.state.names == ("chair1", "chair2")
    wrong = stage.result("seek", Seek(tick=36))
    assert (wrong.code, wrong.text) == ("not-found", f"Seek: run {run}: expected a tick in [20, 35], got 36")
    assert stage.result("seek", Seek(tick=0, run="f" * 16)).code == "not-found"


def test_body_that_is_not_here_at_the_sought_tick_is_removed(stage: PlayStage) -> None:
    stage.result("seek", Seek(tick=20))
    assert stage.of("body", "chair2")
    stage.result("seek", Seek(tick=5))
    assert stage.of("undeclare", "chair2")
    assert [entity.name for entity in stage.of("state")[-1].entity] == ["chair1"]
    told = len(stage.measures("chair2"))
    stage.work(0.1)
    assert len(stage.measures("chair2")) == told
    stage.result("seek", Seek(tick=20))
    assert len(stage.of("body", "chair2")) == 2


def test_events_up_to_the_sought_tick_can_be_asked_for(stage: PlayStage) -> None:
    def codes() -> list[str]:
        (reply,) = stage.ask("event", "")
        assert isinstance(reply[0], Events)
        return [event.code for event in reply[0].event]

    stage.result("pause")
    stage.result("seek", Seek(tick=40))
    assert codes() == ["joined", "joined", "left"]
    stage.result("seek", Seek(tick=15))
    assert codes() == ["joined", "joined"]
    stage.result("resume")
    stage.work(1.0)
    assert codes() == ["joined", "joined", "left"]


def test_end_is_printed_and_seek_can_go_back_from_it(stage: PlayStage, seen: list[Seen]) -> None:
    stage.result("seek", Seek(tick=34, run=seen[-1].run))
    stage.work(1.0)
    assert clock(stage).state == "ended"
    stage.work(60.0)
    assert stage.live_run.exit is None
    assert stage.result("resume").code == "incorrect-state"
    stage.result("pause")
    assert stage.result("step", Step()).text == "the log is at its end; seek back"
    stage.result("seek", Seek(tick=30))
    assert clock(stage).state == "paused"
    assert stage.result("resume").code == "ok"
    stage.work(0.11)
    assert stage.tick == 32
    assert clock(stage).state == "running"


def test_steps_end_with_the_log(stage: PlayStage, seen: list[Seen]) -> None:
    stage.result("pause")
    stage.result("seek", Seek(tick=33, run=seen[-1].run))
    replies = stage.ask("ctl", "step", Step(count=9))
    stage.work(1.0)
    assert isinstance(replies[0][0], Result)
    assert (replies[0][0].code, replies[0][0].text) == ("ok", "the log is at its end")


@pytest.mark.parametrize(
    ("verb", "data"),
    [
        ("reset", b"{}"),
        ("load", b'{"Name":"ward"}'),
        ("spawn", b'{"Robot":{"Name":"x","Length":1,"Width":1,"Center":0.5}}'),
        ("delete", b'{"Agent":"chair1"}'),
        ("teleport", b'{"Agent":"chair1","Position":{"X":1,"Y":1,"Heading":0}}'),
        ("take", b'{"Agent":"chair1"}'),
        ("say", b'{"Text":"hello"}'),
        ("save", b""),
        ("restore", b'{"Slot":"s1"}'),
    ],
)
def test_playback_refuses_to_be_steered(stage: PlayStage, verb: str, data: bytes) -> None:
    before = len(stage.live_run.state.saved)
    result = stage.result(verb, data)
    assert (result.code, result.text) == ("unsupported", "a played log cannot be steered")
    assert stage.live_run.state.names == ("chair1",)
    assert len(stage.live_run.state.saved) == before


def test_nobody_joins_leaves_or_drives(stage: PlayStage) -> None:
    reply, ok = stage.try_join("chair9", robot("rear-wheel"))
    assert not ok
    assert isinstance(reply, Refused)
    assert (reply.code, reply.text) == ("full", "a played log cannot be steered: agents cannot join it")
    (left,) = stage.ask("leave", "chair1")
    assert isinstance(left[0], Result)
    assert left[0].code == "unsupported"
    stage.put("chair1", Actions(left_motor=1.0))
    assert [(error.code, error.text) for error in stage.errors("chair1")] == [
        ("not-joined", "actions: a played log cannot be steered")
    ]
    assert stage.ask("join", "", Robot(), has_wildcards=True) == []


def test_key_that_nobody_reads_does_not_end_a_playback(stage: PlayStage) -> None:
    stage.live_run.take(Put("", "stray", b"", "", key="in/BAD/x"), stage.now)
    stage.live_run.take(Put("chair1", "stray", b"", "", key="in/chair1/x"), stage.now)
    assert stage.live_run.exit is None


def test_queries_are_answered_and_quit_ends_the_playback(stage: PlayStage) -> None:
    (floor,) = stage.ask("map", "")
    assert isinstance(floor[0], Map)
    (now,) = stage.ask("clock", "")
    assert isinstance(now[0], Clock)
    assert now[0].last == 50
    assert stage.ask("ctl", "nonsense")[0][1] is False
    assert stage.result("quit").code == "ok"
    assert stage.live_run.exit == 0
    stage.live_run.finish(stage.now)


def test_playback_can_quit_at_the_end(log: Path, seen: list[Seen]) -> None:
    stage = PlayStage(log, speed=100.0, quit_at_end=True)
    stage.work(5.0)
    assert stage.live_run.exit == 0
    stage.close()


def test_reported_poses_are_published_with_each_state_and_ignored_by_the_playback_itself(tmp_path: Path) -> None:
    for name, kind in (("lab", "rear-wheel"), ("ward", real())):
        live = Stage(pace="realtime", strict=False, log=tmp_path / name)
        session = live.join("chair1", kind).session
        for step in range(10):
            if name == "ward":
                live.put("chair1", Pose(session=session, x=2.0 + 0.1 * step, y=2.0, heading=0.0), "pose")
            live.work(0.05)
        live.live_run.finish(live.now)
        assert live.log is not None
        live.log.close()
    stage = PlayStage(tmp_path / "lab", reported=tmp_path / "ward")
    stage.work(0.3)
    assert stage.result("pause").code == "ok"
    told = stage.of("pose", "chair1")
    assert (told[-1].run, told[-1].tick) == (stage.live_run.state.run, stage.tick)
    assert told[-1].x > 2.0
    stage.result("seek", Seek(tick=2))
    assert stage.of("pose", "chair1")[-1].tick == 2
    stage.put("chair1", told[-1], "pose")
    assert stage.errors("chair1") == []
    stage.close()


def test_a_playback_waits_until_it_is_resumed_unless_it_quits_at_its_end(log: Path, seen: list[Seen]) -> None:
    stage = PlayStage(log, waits=True)
    stage.work(1.0)
    assert (stage.tick, stage.of("clock")[-1].state) == (0, "paused")
    assert stage.result("resume").code == "ok"
    stage.work(1.0)
    assert stage.tick > 0
    stage.close()
    alone = PlayStage(log, quit_at_end=True, waits=True)
    alone.work(1.0)
    assert alone.tick > 0
    alone.close()


def test_no_crew_joins_leaves_or_drives(stage: PlayStage) -> None:
    reply = stage.join_crew("chair1", "c1")
    assert isinstance(reply, Refused)
    assert (reply.code, reply.text) == ("full", "a played log cannot be steered: agents cannot join it")
    (left,) = stage.ask("crew-leave", "c", CrewLeave(crew="c"))
    assert isinstance(left[0], Result)
    assert left[0].code == "unsupported"
    stage.crew_act("chair1", "c1")
    # The crew is told so, not the agent that has the same name.
    assert stage.errors("chair1") == []
    assert [(error.code, error.text) for error in stage.of("crew-error", "chair1")] == [
        ("not-joined", "CrewActions: a played log cannot be steered")
    ]


def test_bodies_of_crews_are_in_no_crew_as_their_measures_come_one_by_one(tmp_path: Path) -> None:
    live = Stage(pace="realtime", log=tmp_path / "log")
    live.join_crew("c", "c1", "c2")
    live.work(0.5)
    live.live_run.finish(live.now)
    assert live.log is not None
    live.log.close()
    stage = PlayStage(tmp_path / "log", quit_at_end=True)
    stage.work(1.0)
    assert [body.robot.crew for name in ("c1", "c2") for body in stage.of("body", name)[-1:]] == [None, None]
    assert stage.measures("c1") != []
    stage.close()
