from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from intellwheels_maps import robot
from intellwheels_schemas.messages import (
    Delete,
    Leave,
    Measures,
    Pose,
    Position,
    Reset,
    Restore,
    Result,
    Robot,
    Take,
    Teleport,
    Truth,
    UserInput,
)
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.world.changes import SLOTS
from intellwheels_server.world.kernels import rows
from tests.server.stage import RUN, Stage, real

SENSING = msgspec.structs.replace(
    robot("rear-wheel"), motor_noise=0.1, truth=(Truth(id="slow", every=7), Truth(id="late", latency=3))
)


def drive(stage: Stage, ticks: int) -> list[tuple[int, str, Measures]]:
    """Answer so many ticks the same way each time; return what came of each."""
    found = []
    for _ in range(ticks):
        tick = stage.tick
        for name in sorted(stage.sessions):
            stage.act(name, 0.4 + 0.02 * (tick % 7), 0.6, say=f"at {tick}")
        told = stage.measures("chair1")[-1]
        found.append((stage.tick, stage.live_run.digest(), msgspec.structs.replace(told, run=RUN)))
    return found


def result_of(replies: list[tuple[Any, bool]]) -> Result:
    assert isinstance(replies[0][0], Result)
    return replies[0][0]


def later(stage: Stage, verb: str, message: Any = b"") -> Result:
    """Ask while a barrier is open; the reply comes with the next tick's changes."""
    replies = stage.ask("ctl", verb, message)
    if not replies:
        drive(stage, 1)
    return result_of(replies)


def test_restored_run_repeats_the_saved_one_and_its_log_runs_again(tmp_path: Path) -> None:
    stage = Stage(log=tmp_path / "log")
    stage.join_two()
    stage.result("pause")
    stage.join("chair1", SENSING, parameters={"session": stage.sessions["chair1"]})
    stage.result("resume")
    drive(stage, 40)
    saved = later(stage, "save")
    assert (saved.code, saved.slot, saved.tick, saved.hash) == ("ok", "s1", 41, stage.live_run.digest())
    went = drive(stage, 60)
    restored = later(stage, "restore", Restore(slot="s1"))
    assert (restored.code, restored.slot, restored.tick, restored.hash) == ("ok", "s1", 41, saved.hash)
    assert restored.run not in (None, RUN)
    event = stage.of("event")[-1]
    assert (event.code, event.number, event.run) == ("reset", 0, restored.run)
    assert event.text == f"restored s1: tick 41 of run {RUN}"
    assert drive(stage, 60) == went
    assert stage.log is not None
    stage.live_run.finish(stage.now)
    stage.log.close()
    found = resimulate(tmp_path / "log")
    assert (found.differs, found.hash) == (None, went[-1][1])


def test_saved_states_survive_a_reset_and_the_oldest_is_dropped() -> None:
    stage = Stage()
    stage.join("chair1")
    hashes = {}
    for _ in range(SLOTS + 2):
        saved = later(stage, "save")
        hashes[saved.slot] = saved.hash
    later(stage, "reset", Reset(seed="2"))
    assert stage.live_run.state.setup.seed == "2"
    gone = later(stage, "restore", Restore(slot="s2"))
    assert (gone.code, (gone.text or "").startswith("no slot 's2'; expected one of: s3, s4")) == ("not-found", True)
    assert later(stage, "restore", Restore(slot="s3")).hash == hashes["s3"]
    assert stage.live_run.state.setup.seed == "1"
    assert all(saved.state.saved == () for saved in stage.live_run.state.saved)


def test_restoring_while_paused_stays_paused() -> None:
    stage = Stage(pace="realtime")
    stage.work(0.5)
    stage.result("pause")
    slot = stage.result("save").slot
    assert slot is not None
    stage.result("resume")
    stage.work(0.5)
    tick = stage.tick
    stage.result("pause")
    back = stage.result("restore", Restore(slot=slot)).tick
    assert back is not None
    stage.work(2.0)
    assert stage.tick == back < tick
    assert stage.of("clock")[-1].state == "paused"


def test_agent_that_joined_after_the_save_must_join_again() -> None:
    stage = Stage()
    stage.join("chair1")
    later(stage, "save")
    stage.result("pause")
    stage.join("chair2", instance="b" * 16)
    stage.result("restore", Restore(slot="s1"))
    stage.result("resume")
    assert stage.live_run.state.names == ("chair1",)
    assert [error.code for error in stage.errors("chair2")] == ["not-joined"]
    del stage.sessions["chair2"]
    drive(stage, 2)
    replies = stage.ask("join", "chair2", msgspec.structs.replace(robot("rear-wheel"), format=None, instance="b" * 16))
    drive(stage, 1)
    assert replies[0][1]
    assert "chair2" in stage.live_run.state.names


def test_body_of_an_agent_that_left_after_the_save_waits_for_it() -> None:
    stage = Stage()
    stage.join_two()
    saved = later(stage, "save")
    stage.result("pause")
    stage.ask("leave", "chair2", Leave(session=stage.sessions.pop("chair2")))
    stage.result("restore", Restore(slot="s1"))
    assert stage.live_run.state.names == ("chair1", "chair2")
    stage.join("chair2", instance="c" * 16)
    assert stage.live_run.digest() == saved.hash
    assert stage.events()[-1] == "returned"
    stage.result("resume")
    drive(stage, 3)
    assert stage.tick == (saved.tick or 0) + 3


def test_another_robot_of_that_name_replaces_the_waiting_body() -> None:
    stage = Stage()
    stage.join_two()
    later(stage, "save")
    stage.result("pause")
    stage.ask("leave", "chair2", Leave(session=stage.sessions.pop("chair2")))
    stage.result("restore", Restore(slot="s1"))
    stage.join("chair2", "mid-wheel", instance="c" * 16)
    assert stage.live_run.state.body_set.models["chair2"].robot.top_speed == robot("mid-wheel").top_speed
    assert stage.events()[-2:] == ["left", "joined"]


def test_agent_that_changed_its_robot_after_the_save_is_removed() -> None:
    stage = Stage()
    stage.join_two()
    later(stage, "save")
    stage.result("pause")
    stage.join("chair2", "mid-wheel", instance="b" * 16)
    stage.result("restore", Restore(slot="s1"))
    assert stage.errors("chair2")[-1].code == "not-joined"
    stage.result("resume")
    del stage.sessions["chair2"]
    drive(stage, 2)
    assert stage.of("clock")[-1].waiting == ()


def test_mind_in_another_process_stays_only_if_the_saved_run_had_it() -> None:
    stage = Stage()
    stage.join("chair1", role="body")
    stage.result("pause")
    assert stage.result("save").slot == "s1"
    stage.join("chair1", Robot(role="mind", user_input=("drive",)), instance="b" * 16)
    assert stage.result("save").slot == "s2"
    stage.result("restore", Restore(slot="s2"))
    assert stage.errors("chair1") == []
    stage.result("restore", Restore(slot="s1"))
    assert [error.code for error in stage.errors("chair1")] == ["not-joined"]


def test_body_deleted_by_an_operator_can_be_restored() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    saved = stage.result("save")
    stage.result("delete", Delete(agent="chair1"))
    assert stage.result("restore", Restore(slot="s1")).hash == saved.hash
    stage.join("chair1")
    assert stage.live_run.digest() == saved.hash


def test_lease_that_has_ended_does_not_come_back() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1")
    stage.result("pause")
    lease = stage.result("take", Take(agent="chair1", seconds=60.0)).lease
    stage.result("save")
    stage.result("restore", Restore(slot="s1"))
    assert stage.live_run.state.flags[rows.TAKEN, 0] == 1
    stage.result("take", Take(agent="chair1", lease=lease, seconds=0.0))
    stage.result("restore", Restore(slot="s1"))
    assert stage.live_run.state.flags[rows.TAKEN, 0] == 0
    stage.result("save")
    assert stage.result("take", Take(agent="chair1")).code == "ok"
    stage.result("restore", Restore(slot="s2"))
    assert stage.live_run.state.flags[rows.TAKEN, 0] == 0
    assert stage.result("take", Take(agent="chair1")).code == "ok"


def test_body_of_a_user_who_is_gone_stops_in_a_restored_run() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1", user_input=("drive",))
    lease = stage.result("take", Take(agent="chair1", seconds=60.0)).lease
    stage.put("chair1", UserInput(lease=lease, forward=1.0), "user")
    stage.work(0.1)
    stage.result("save")
    stage.work(1.0)
    assert stage.live_run.state.flags[rows.SILENT, 0] == 1
    stage.result("restore", Restore(slot="s1"))
    assert stage.live_run.state.flags[rows.SILENT, 0] == 0
    stage.work(1.0)
    assert stage.live_run.state.flags[rows.SILENT, 0] == 1


def test_real_chair_that_is_stale_in_the_saved_state_is_fresh_when_it_reports() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1", real())
    stage.work(1.0)
    assert stage.events()[-1] == "stale"
    stage.result("save")
    stage.put("chair1", Pose(x=1.0, y=1.0, heading=0.0), "pose")
    stage.work(0.1)
    assert stage.events()[-1] == "fresh"
    stage.result("restore", Restore(slot="s1"))
    stage.work(0.1)
    assert stage.events()[-1] == "fresh"


def test_map_is_published_again_if_the_saved_run_had_another() -> None:
    stage = Stage()
    stage.result("pause")
    stage.result("save")
    stage.result("load", b'{"Name":"corner"}')
    stage.result("restore", Restore(slot="s1"))
    assert [(info.name, info.revision) for info in stage.of("map")[-3:]] == [("room", 0), ("corner", 1), ("room", 2)]


def test_log_repeats_a_teleport_and_a_save_in_one_tick(tmp_path: Path) -> None:
    stage = Stage(log=tmp_path / "log")
    stage.join("chair1", SENSING)
    stage.result("pause")
    body = stage.live_run.state.numbers
    position = Position(x=float(body[0, 0]) + 0.1, y=float(body[1, 0]), heading=0.3)
    assert stage.result("teleport", Teleport(agent="chair1", position=position)).code == "ok"
    stage.result("save")
    stage.result("resume")
    went = drive(stage, 20)
    stage.result("pause")
    stage.result("restore", Restore(slot="s1"))
    stage.result("resume")
    assert drive(stage, 20) == went
    assert stage.log is not None
    stage.log.close()
    assert resimulate(tmp_path / "log").differs is None


def test_crew_is_told_which_of_its_agents_a_restore_removed() -> None:
    stage = Stage(pace="realtime")
    stage.join_crew("c", "c1")
    stage.result("save")
    stage.join_crew("c", "c2")
    assert stage.result("restore", Restore(slot="s1")).code == "ok"
    # A crew does not hear what is sent to its agents.
    assert [(error.code, error.agent) for error in stage.of("crew-error", "c")] == [("not-joined", "c2")]
    assert "join again" in stage.of("crew-error", "c")[0].text
    stage.join_crew("c", "c2")
    stage.work(0.1)
    assert [each.agent for each in stage.of("crew-measures", "c")[-1].measures] == ["c1", "c2"]
