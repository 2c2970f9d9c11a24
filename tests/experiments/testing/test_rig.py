"""A rig shows a test what happened, tick by tick. Its faults are real, and no process outlives it."""

from __future__ import annotations

import math
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from intellwheels_experiments.run.child_processes import WaitError
from intellwheels_experiments.testing.rig import Rig
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Result
from tests.experiments.foreign import COMMAND, write_foreign

pytestmark = pytest.mark.process

AVOID = Path(__file__).parents[3] / "agents" / "examples" / "other_languages" / "python" / "avoid.py"
AHEAD: dict[str, Any] = {"left": 0.3, "right": 0.3}

DIES = """
class Mind:
    def __init__(self, context): pass
    def decide(self, measures):
        raise RuntimeError("no such wheel")
"""


def test_lockstep_stops_at_the_tick_at_which_the_condition_held(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner") as sim:
        sim.agent("chair1", "drive", robot="mid-wheel", place="leader", **AHEAD)
        assert sim.pose("chair1") == (0.0, 5.0, 0.0, 0.0)
        seen: list[int] = []

        def far(now: object) -> bool:
            moment = sim.now
            seen.append(moment.tick)
            return moment["chair1"].x > 5.3

        held = sim.run_until(far)
        assert seen == list(range(held.tick + 1))
        assert sim.now == held
        path = sim.path("chair1")
        assert [point.time for point in path] == pytest.approx([0.05 * tick for tick in seen])
        assert path[-2].x <= 5.3 < path[-1].x == sim.pose("chair1").x
        assert sim.run_for(1.0).time == pytest.approx(held.time + 1.0)


def test_run_of_a_seed_does_not_depend_on_where_it_is_stopped(tmp_path: Path) -> None:
    def run(folder: str, *stops: float) -> list[tuple[float, ...]]:
        with Rig(tmp_path / folder, floor="corner", seed="5") as sim:
            sim.agent("chair1", "drive", robot="mid-wheel", place="leader", MotorNoise=0.02, **AHEAD)
            for stop in stops:
                sim.run_for(stop)
            return list(sim.path("chair1"))

    assert run("once", 1.5) == run("often", 0.5, 0.25, 0.75)


def test_contacts_are_pairs_and_a_condition_that_never_holds_shows_the_world(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner") as sim:
        sim.agent("chair1", "drive", robot="mid-wheel", place="leader", left=1.0, right=1.0)
        sim.run_until(lambda now: now.contacts, seconds=15.0)
        assert sim.contacts == [("chair1", "wall")]
        assert [event.code for event in sim.events if event.agent == "chair1"] == ["joined", "contact"]
        with pytest.raises(
            WaitError, match=r"did not hold within 0.2 s of simulated time\ntick \d+(.|\n)*chair1: x 11\."
        ):
            sim.run_until(lambda now: now["chair1"].x > 99.0, seconds=0.2)
        with pytest.raises(WaitError, match="expected one of the bodies present"):
            sim.run_until(lambda now: now["chair2"].x > 0.0, seconds=0.1)


def test_agent_that_dies_fails_the_test_at_once_with_its_last_lines(tmp_path: Path) -> None:
    mind = tmp_path / "dies.py"
    mind.write_text(DIES)
    with Rig(tmp_path / "logs", floor="corner", folder=tmp_path) as sim:
        sim.agent("chair1", "dies.py")
        with pytest.raises(WaitError, match=r"agent-chair1: exit 1; its last lines:\n(.|\n)*no such wheel"):
            sim.run_for(1.0)


def test_agent_that_may_die_is_awaited_and_gives_its_code(tmp_path: Path) -> None:
    mind = tmp_path / "dies.py"
    mind.write_text(DIES)
    with Rig(tmp_path / "logs", floor="corner", folder=tmp_path) as sim:
        sim.agent("chair1", "dies.py", may_end=True)
        # It dies at its first tick, and the world continues without it.
        sim.run_for(0.5)
        assert sim.exit("chair1") == 1
        assert "no such wheel" in sim.log("chair1")


def test_simulator_that_ends_the_run_says_why(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner", arguments=("--deadline", "0.3")) as sim:
        sim.agent("chair1", "drive")
        sim.run_for(0.2)
        sim.freeze("chair1")
        with pytest.raises(WaitError, match=r"server: exit 1; its last lines:\n(.|\n)*miss agent=chair1"):
            sim.run_for(1.0)


def test_program_of_any_language_learns_where_to_join(tmp_path: Path) -> None:
    # The example knows the world `main` only, so the world is passed as a third argument here.
    program = tmp_path / "avoid.py"
    program.write_text(AVOID.read_text().replace('"iw/v1/main"', 'f"iw/v1/{sys.argv[3]}"'))
    with Rig(tmp_path / "logs", floor="corner") as sim:
        sim.agent("chair1", [sys.executable, str(program), "{name}", "{endpoint}", "{world}"])
        start = sim.pose("chair1")
        sim.run_until(lambda now: math.dist(start[1:3], (now["chair1"].x, now["chair1"].y)) > 0.3)
        with pytest.raises(ValueError, match="expected no robot, place or options with a command"):
            sim.agent("chair2", [sys.executable], place="leader")


def test_cast_of_a_scene_plays_it_to_its_end(tmp_path: Path) -> None:
    with Rig(tmp_path, scene="door") as sim:
        sim.cast()
        assert set(sim.now.bodies) == {"chair", "door"}
        sim.run_until(lambda now: now.happened("ended"), seconds=60.0)
        assert sim.contacts == []
        with pytest.raises(WaitError, match="the run has ended"):
            sim.run_for(1.0)


def test_end_of_a_run_in_real_time_is_the_last_moment(tmp_path: Path) -> None:
    with Rig(tmp_path, scene="door", pace="realtime", speed=20.0) as sim:
        sim.cast()
        sim.run_until(lambda now: now.happened("ended"), seconds=60.0)
        with pytest.raises(WaitError, match="the run ended"):
            sim.run_for(1.0)


def test_killed_agent_comes_to_rest_and_its_successor_drives_on(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner", pace="realtime") as sim:
        sim.agent("chair1", "drive", place="leader", **AHEAD)
        sim.run_until(lambda now: now["chair1"].speed > 0.2)
        sim.kill("chair1")
        rest = sim.run_until(lambda now: now["chair1"].speed < 0.01, seconds=3.0)
        assert rest.happened("lost", "chair1")
        sim.agent("chair1", "drive", **AHEAD)
        sim.run_until(lambda now: now["chair1"].speed > 0.2, seconds=5.0)
        assert sim.pose("chair1").x > rest["chair1"].x
        assert sim.log("chair1").startswith("joined")


def test_frozen_agent_times_out_and_goes_on_when_it_is_thawed(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner", pace="realtime") as sim:
        sim.agent("chair1", "drive", place="leader", **AHEAD)
        sim.run_until(lambda now: now["chair1"].speed > 0.2)
        sim.freeze("chair1")
        sim.run_until(lambda now: now.happened("timeout", "chair1") and now["chair1"].speed < 0.01, seconds=3.0)
        sim.thaw("chair1")
        sim.run_until(lambda now: now["chair1"].speed > 0.2, seconds=5.0)


def test_agents_join_the_restarted_simulator(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner") as sim:
        sim.agent("chair1", "drive", place="leader", **AHEAD)
        before = sim.run_for(1.0).events[0].run
        sim.restart_simulator()
        assert (sim.now.tick, sim.now.events[0].run != before) == (0, True)
        sim.run_until(lambda now: now["chair1"].speed > 0.2)
        assert sim.ctl("delete", agent="chair1").code == "ok"
        assert sim.now.bodies == {}
        assert sim.end_simulator() == 0


def test_cut_router_separates_agents_from_the_simulator_until_it_is_mended(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner", pace="realtime", router=True) as sim:
        sim.agent("chair1", "drive", place="leader", **AHEAD)
        sim.run_until(lambda now: now["chair1"].speed > 0.2)
        sim.cut_router()
        sim.run_until(lambda now: now["chair1"].speed < 0.01, seconds=3.0)
        sim.mend_router()
        sim.run_until(lambda now: now["chair1"].speed > 0.2, seconds=20.0)


def test_no_process_runs_after_the_end(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner") as sim:
        sim.agent("chair1", "drive")
        sim.freeze("chair1")
        assert len(sim.processes.running) == 2
    assert len(sim.processes.running) == 0


def test_fault_that_comes_too_late_is_an_error_with_the_last_lines(tmp_path: Path) -> None:
    with Rig(tmp_path, floor="corner") as sim:
        sim.agent("chair1", "drive")
        sim.kill("chair1")
        for fault in (sim.kill, sim.freeze, sim.thaw):
            with pytest.raises(WaitError, match="agent-chair1: expected a running process, got killed by SIGKILL"):
                fault("chair1")
        with pytest.raises(ValueError, match="expected a world with router=True"):
            sim.cut_router()
        with pytest.raises(LookupError, match="expected one of the agents that were started"):
            sim.log("router")
        assert sim.end_simulator() == 0
        sim.restart_simulator()
        assert sim.now.tick == 0


def test_name_is_checked_before_it_becomes_the_name_of_a_file(tmp_path: Path) -> None:
    with Rig(tmp_path / "logs", floor="corner") as sim:
        with pytest.raises(WireError, match=r"name: expected a name of a-z"):
            sim.agent("../../chair1", [sys.executable, "-c", ""])
        with pytest.raises(WireError, match=r"mind: expected a program, got 'no-such-program'"):
            sim.agent("chair1", ["no-such-program"])
        assert [title for title, _ in sim.sections()] == ["server (running)"]
        for seconds in (math.nan, math.inf, -1.0):
            with pytest.raises(ValueError, match="seconds: expected a finite number of simulated seconds"):
                sim.run_until(lambda now: False, seconds=seconds)


def test_agent_that_is_not_in_the_scene_cannot_be_cast(tmp_path: Path) -> None:
    wanted = r"cast: expected an agent of the scene \(chair, door\), got 'chiar'"
    with Rig(tmp_path, scene="door") as sim, pytest.raises(LookupError, match=wanted):
        sim.cast("chiar")


class Slow(Rig):
    """Pauses a restarted world so late that agents could make it advance before."""

    comes_back = False

    def ctl(self, verb: Verb, **fields: Any) -> Result:
        if verb == "pause" and self.comes_back:
            with suppress(WaitError):
                self.processes.wait(self._tick, "tick", 4.0)
        return super().ctl(verb, **fields)

    def _tick(self) -> int | None:
        self._query()
        return self._history.newest.tick or None if self._history.newest else None


def test_restarted_world_stands_at_tick_0_however_slow_the_machine(tmp_path: Path) -> None:
    with Slow(tmp_path, floor="corner") as sim:
        sim.agent("chair1", "drive", place="leader", **AHEAD)
        sim.comes_back = True
        sim.restart_simulator()
        assert (sim.now.tick, list(sim.now.bodies)) == (0, ["chair1"])


FOREIGN = f"""\
<Scene Format="iw.v1" Name="foreign" Map="corner" Seed="1">
  <Cast Name="chair1" Place="leader" Command="{COMMAND}" NewRun="restart"/>
</Scene>
"""


def test_program_of_a_scene_is_cast_at_its_place_and_starts_again_with_a_new_run(tmp_path: Path) -> None:
    write_foreign(tmp_path)
    (tmp_path / "foreign.xml").write_text(FOREIGN)
    with Rig(tmp_path / "logs", scene="foreign.xml", folder=tmp_path) as sim:
        sim.cast()
        assert sim.pose("chair1") == (0.0, 5.0, 0.0, 0.0)
        once = sim.run_for(1.0)["chair1"].x
        assert once > 5.1
        assert sim.ctl("reset").code == "ok"
        assert sim.pose("chair1") == (0.0, 5.0, 0.0, 0.0)
        assert sim.run_for(1.0)["chair1"].x == once
