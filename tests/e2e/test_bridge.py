"""Real chairs among virtual ones, with two worlds or with a controller on a pseudo-terminal. Real processes.

The world `lab` stands for the building with the real chairs. They meet the virtual ones in the world of the stage.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from intellwheels_maps import robot as robot_file
from intellwheels_schemas.link import START_ONE
from tests.e2e.stage import Peer, Stage
from tests.e2e.stand_in import StandIn

WATCHDOG_MS = 5 * 200
"""Five times the promise, as the controller is a process that may be late on a busy machine. Its logic is held to the
promise in `tests/agents/bridge/test_firmware_stand_in.py`."""


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Stage]:
    folder = tmp_path / "laboratory"
    folder.mkdir()
    with Stage(folder, "lab") as stage:
        yield stage


def bridge(stage: Stage, name: str, *words: str, joined: bool = True) -> str:
    child = stage.start(
        f"bridge-{name}", "intellwheels_agents.bridge", *words, "--name", name,
        "--connect", stage.endpoint, "--world", stage.world,
    )  # fmt: skip
    if joined:
        stage.line(child, "joined")
    return child


def mind(stage: Stage, name: str, which: str, *words: str) -> str:
    child = stage.start(
        f"mind-{name}", "intellwheels_agents", which, "--name", name, "--role", "mind",
        "--connect", stage.endpoint, "--world", stage.world, *words,
    )  # fmt: skip
    stage.line(child, "joined")
    return child


def hashes(log: Path, ticks: int) -> list[str]:
    found = [json.loads(line).get("Hash") for line in log.read_text().splitlines()]
    return [one for one in found if one is not None][:ticks]


def floor_with_a_table(folder: Path) -> str:
    """Return a corridor in which a table can stand across the way."""
    text = (Path(__file__).parents[2] / "maps/intellwheels_maps/floors/corner.xml").read_text()
    place = '<Position Name="table" X="9.0" Y="0.0" HeadingDeg="90.0" Kinds="table"/>'
    path = folder / "corner.xml"
    path.write_text(text.replace("</Grid>", f"{place}</Grid>"))
    return str(path)


def robot_that_sees_tops(folder: Path) -> str:
    """Return a chair with one more, virtual sensor, at the height of a table's top."""
    text = (Path(__file__).parents[2] / "maps/intellwheels_maps/robots/intellwheels.xml").read_text()
    high = '<Proximity Id="high" X="0.696" Y="0.0" Z="0.7" DirectionDeg="0.0" ConeDeg="30.0" MaxRange="4.0"/>'
    path = folder / "seeing.xml"
    path.write_text(text.replace("<Encoders", f"{high}\n  <Encoders"))
    return str(path)


# ---------------------------------------------------------------- two worlds, tick by tick


@contextmanager
def two_worlds(stage: Stage, lab: Stage, log: Path, *words: str) -> Iterator[Peer]:
    """Run a real chair towards a virtual table, both worlds in strict lockstep."""
    lockstep = ("--pace", "lockstep", "--miss", "strict", "--deadline", "60", "--seed", "5")
    lab.server("--map", "corner", "--hide-truth", "--expect", "chair1", *lockstep)
    stage.server("--map", floor_with_a_table(stage.folder), "--expect", "chair1,table", "--log", str(log), *lockstep)
    bridge(
        stage, "chair1", "world", "--lab-connect", lab.endpoint, "--place", "leader",
        "--robot", robot_that_sees_tops(stage.folder), "--chair", "intellwheels", *words,
    )  # fmt: skip
    stage.agent("table", "table", "--place", "table")
    mind(stage, "chair1", "waypoints", "--option", "points=11.2 0", "--option", "speed=0.8")
    with stage.peer() as peer:
        yield peer
    # Its log is whole when it has ended.
    stage.signal(stage.simulator, signal.SIGTERM)
    assert stage.exit(stage.simulator) == 0


def stood(peer: Peer) -> dict[str, Any]:
    """Wait until the real chair has driven and stands; return its state."""
    peer.entity("chair1", lambda one: one["X"] > 6.0)
    return peer.entity("chair1", lambda one: abs(one.get("Speed", 0.0)) < 1e-3)


def test_a_real_chair_stops_for_a_virtual_table_the_same_each_time(stage: Stage, lab: Stage, tmp_path: Path) -> None:
    with two_worlds(stage, lab, tmp_path / "run.jsonl", "--chair-option", "WheelRatio=1.002") as peer:
        chair = stood(peer)
        # The top's edge is at 8.6, the chair's front 0.696 ahead; it keeps half a metre and a little more.
        assert 6.9 < chair["X"] < 8.6 - 0.696 - 0.3
        assert chair.get("Contacts", 0) == 0
        assert [event for event in peer.events() if event["Code"] in ("contact", "stale", "late")] == []
        peer.tick(300)
    first = hashes(tmp_path / "run.jsonl", 200)
    assert len(first) == 200
    # Again, with other processes: the poses of two worlds are a function of the seeds.
    with Stage(tmp_path / "again", "again") as other, Stage(tmp_path / "lab2", "lab") as lab2:
        other.folder.mkdir(exist_ok=True)
        lab2.folder.mkdir(exist_ok=True)
        with two_worlds(other, lab2, tmp_path / "again.jsonl", "--chair-option", "WheelRatio=1.002") as peer:
            peer.tick(300)
    assert hashes(tmp_path / "again.jsonl", 200) == first


def test_playback_shows_the_reported_pose_beside_the_true_one(stage: Stage, lab: Stage, tmp_path: Path) -> None:
    logs = {one: tmp_path / f"{one.world}.jsonl" for one in (lab, stage)}
    lockstep = ("--pace", "lockstep", "--deadline", "60", "--map", "corner", "--expect", "chair1")
    lab.server("--hide-truth", "--log", str(logs[lab]), *lockstep)
    stage.server("--log", str(logs[stage]), *lockstep)
    bridge(
        stage, "chair1", "world", "--lab-connect", lab.endpoint, "--place", "leader",
        "--chair-option", "WheelRatio=1.02",
    )  # fmt: skip
    mind(stage, "chair1", "waypoints", "--option", "points=11.2 0")
    with stage.peer() as peer:
        peer.entity("chair1", lambda one: one["X"] > 9.0)
    for one in (stage, lab):
        one.signal(one.simulator, signal.SIGTERM)
        assert one.exit(one.simulator) == 0
    with Stage(tmp_path / "played", "played") as played:
        player = played.start(
            "player", "intellwheels_server", "--play", str(logs[lab]), "--reported", str(logs[stage]),
            "--world", played.world, "--listen", played.endpoint,
        )  # fmt: skip
        played.line(player, "ready", 60.0)
        with played.peer() as peer:
            told = peer.hear("in/chair1/pose")
            assert peer.ctl("pause")["Code"] == "ok"
            tick = peer.clock()["Last"] - 40
            answer = peer.ctl("seek", Tick=tick)
            assert answer["Code"] == "ok", (tick, answer)
            said = played.wait(
                lambda: next((one for one in map(json.loads, (data for _, data in told)) if one["Tick"] == tick), None),
                "the reported pose",
            )
            truth = peer.entities()["chair1"]
            # The chair drives a curve that its odometry does not show.
            assert 0.02 < abs(truth["Y"] - said["Y"]) < 2.0
            assert abs(said["Y"]) < 0.1
            assert abs(truth["X"] - said["X"]) < 0.5
            assert [event for event in peer.events() if event["Code"] == "not-joined"] == []


@pytest.mark.parametrize("first", ["lab", "here"])
def test_a_reset_of_both_worlds_repeats_the_run(stage: Stage, lab: Stage, tmp_path: Path, first: str) -> None:
    log = tmp_path / "run.jsonl"
    with (
        two_worlds(stage, lab, log, "--delay", "0.08", "--jitter", "0.1", "--loss", "0.1") as peer,
        lab.peer() as there,
    ):
        peer.tick(120)
        run = peer.clock()["Run"]
        for one in (there, peer) if first == "lab" else (peer, there):
            assert one.ctl("reset", Seed="5")["Code"] == "ok"

        def is_repeated() -> bool | None:
            clock = peer.clock()
            return True if clock["Run"] != run and clock["Tick"] >= 120 else None

        stage.wait(is_repeated, "tick 120 of the new run")
    lines = log.read_text().splitlines()
    (restart,) = [i for i, line in enumerate(lines) if '"Do":"Restart"' in line]
    first_run, second_run = places(lines[:restart]), places(lines[restart + 1 :])
    ticks = range(100)
    assert [second_run[tick] for tick in ticks] == [first_run[tick] for tick in ticks]
    assert first_run[99] > first_run[0] + 0.5


def places(lines: list[str]) -> dict[int, float]:
    """Return where a log's lines say that the real chair was reported, by tick."""
    entries = [json.loads(line) for line in lines]
    return {
        entry["Tick"]: entry["Inputs"]["Poses"]["chair1"]["X"]
        for entry in entries
        if "Poses" in entry.get("Inputs", {})
    }


# ---------------------------------------------------------------- two worlds in real time


def test_a_virtual_chair_stops_for_a_real_one_and_the_laboratory_reveals_no_truth(stage: Stage, lab: Stage) -> None:
    lab.server("--map", "corner", "--pace", "realtime", "--hide-truth")
    stage.server("--map", "corner", "--pace", "realtime")
    with lab.peer() as spy, stage.peer() as peer:
        everything = spy.hear("**")
        bridge(
            stage, "real1", "world", "--lab-connect", lab.endpoint, "--place", "leader", "--pose", "corrected",
            "--fix-noise", "0.1", "--chair-option", "WheelRatio=1.01",
        )  # fmt: skip
        stage.agent("virtual1", "waypoints", "--place", "follower2", "--option", "points=9 0", robot="intellwheels")
        peer.entity("virtual1", lambda one: one["X"] > 1.5)
        virtual = peer.entity("virtual1", lambda one: abs(one.get("Speed", 0.0)) < 1e-3)
        # The real one's back is 0.504 behind 5.0.
        assert 2.5 < virtual["X"] < 5.0 - 0.504 - 0.696 - 0.3
        mind(stage, "real1", "drive", "--option", "left=0.5", "--option", "right=0.5")
        moved = peer.entity("real1", lambda one: one["X"] > 5.5)
        # Its way is free again, and it drives on.
        peer.entity("virtual1", lambda one: one["X"] > virtual["X"] + 0.1)
        heard = list(everything)
    assert moved["Speed"] > 0.2
    kinds = {key.removeprefix(spy.prefix) for key, _ in heard}
    assert {"clock", "out/real1/measures", "in/real1/actions"} <= kinds
    assert not any(kind.startswith("state") for kind in kinds)
    for key, data in heard:
        document = json.loads(data)
        if key.endswith("/measures"):
            sensors = document.get("Sensors", {})
            assert "Truth" not in sensors
            # Of places there are the receiver's, as it has them: 0.1 m wrong.
            assert set(sensors) <= {"Proximity", "Encoders", "Compass", "Bumper", "GPS"}
        elif "/event" in key:
            assert not {"X", "Y", "Speed"} & document.keys()
        elif "/body/" in key:
            assert not {"WheelRatio", "WheelScale", "TrackRatio"} & document["Robot"].keys()
        else:
            assert not {"X", "Y", "Heading", "Entity"} & document.keys(), (key, document)


def test_a_bridge_survives_the_death_and_return_of_either_world(stage: Stage, lab: Stage) -> None:
    lab_server = lab.server("--map", "corner", "--pace", "realtime", "--hide-truth")
    server = stage.server("--map", "corner", "--pace", "realtime")
    child = bridge(stage, "real1", "world", "--lab-connect", lab.endpoint, "--place", "leader")
    mind(stage, "real1", "drive", "--option", "left=0.3", "--option", "right=0.3")
    with stage.peer() as peer:
        peer.entity("real1", lambda one: one["X"] > 5.3)
        lab.signal(lab_server, signal.SIGKILL)
        peer.event("stale", "real1")
        lab.server("--map", "corner", "--pace", "realtime", "--hide-truth")
        stage.line(child, "lab-joined")
        peer.event("fresh", "real1")
        peer.entity("real1", lambda one: one.get("Speed", 0.0) > 0.1)
    stage.signal(server, signal.SIGKILL)
    stage.server("--map", "corner", "--pace", "realtime")
    stage.line(child, "joined")
    with stage.peer() as peer:
        # The chair has not moved: the new simulator gets its pose from the bridge.
        peer.entity("real1", lambda one: one["X"] > 5.1 and one.get("Speed", 0.0) > 0.1)
    stage.signal(child, signal.SIGTERM)
    assert stage.exit(child) == 0
    assert "bridged agent=real1" in stage.log(child)


def test_a_killed_bridge_lets_its_chair_come_to_rest(stage: Stage, lab: Stage) -> None:
    lab.server("--map", "corner", "--pace", "realtime")
    stage.server("--map", "corner", "--pace", "realtime")
    child = bridge(stage, "real1", "world", "--lab-connect", lab.endpoint, "--place", "leader")
    mind(stage, "real1", "drive", "--option", "left=0.3", "--option", "right=0.3")
    with lab.peer() as there, stage.peer() as here:
        there.entity("real1", lambda one: one.get("Speed", 0.0) > 0.2)
        stage.signal(child, signal.SIGKILL)
        assert stage.exit(child) == -signal.SIGKILL
        there.entity("real1", lambda one: abs(one.get("Speed", 0.0)) < 1e-3)
        here.event("stale", "real1")


# ---------------------------------------------------------------- a controller on a line


class Controller(StandIn):
    """The firmware stand-in, at the end of a line."""

    def __init__(self, stage: Stage, *words: str) -> None:
        self.port = stage.folder / "tty"
        super().__init__(stage, "firmware", "firmware_stand_in", "--link", str(self.port), *words)


@pytest.mark.parametrize("fault", ["cut 2", "noise 2", "unplug 2"])
def test_a_faulty_line_stops_the_motors_within_0_2_s_and_comes_back(stage: Stage, fault: str) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage)
    child = bridge(stage, "real1", "serial", "--port", str(controller.port), "--place", "start")
    mind(stage, "real1", "drive", "--option", "left=0.2", "--option", "right=0.2")
    with stage.peer() as peer:
        controller.line("moving")
        before = peer.entity("real1", lambda one: one["X"] > 0.1)["X"]
        controller.command(fault)
        stopped = controller.line("stopped")
        # By its own watchdog. Half of the bytes are garbage: no line gets through whole.
        assert 0 < stopped["silence"] <= WATCHDOG_MS
        peer.event("stale", "real1")
        controller.line("moving")
        peer.event("fresh", "real1")
        peer.entity("real1", lambda one: one["X"] > before + 0.1)
    stage.signal(child, signal.SIGTERM)
    assert stage.exit(child) == 0
    # By a command, not by the watchdog.
    controller.stops_by_command()


def test_after_a_killed_bridge_the_controller_s_watchdog_stops_the_motors(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage)
    child = bridge(stage, "real1", "serial", "--port", str(controller.port), "--place", "start")
    mind(stage, "real1", "drive", "--option", "left=0.2", "--option", "right=0.2")
    controller.line("moving")
    stage.signal(child, signal.SIGKILL)
    assert 0 < controller.line("stopped")["silence"] <= WATCHDOG_MS


def test_after_a_killed_simulator_the_bridge_stops_the_motors(stage: Stage) -> None:
    server = stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage)
    bridge(stage, "real1", "serial", "--port", str(controller.port), "--place", "start")
    mind(stage, "real1", "drive", "--option", "left=0.2", "--option", "right=0.2")
    controller.line("moving")
    stage.signal(server, signal.SIGKILL)
    # The bridge is alive and sends zeros, so the line was never silent.
    controller.stops_by_command()


def test_the_chair_s_own_joystick_is_the_user(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage)
    words = ("--port", str(controller.port), "--place", "start", "--joystick")
    bridge(stage, "real1", "serial", *words)
    mind(stage, "real1", "joystick")
    controller.command("stick 300 0")
    controller.line("moving")
    controller.command("stick 0 0")
    controller.stops_by_command()


def test_a_chair_whose_counters_wrap_drives_on_without_a_jump(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage, "--wrap-in", "2")
    child = bridge(stage, "real1", "serial", "--port", str(controller.port), "--place", "start")
    mind(stage, "real1", "drive", "--option", "left=0.5", "--option", "right=0.5")
    with stage.peer() as peer:
        poses = peer.hear("in/real1/pose")
        # At half power the counters have wrapped after 2 s, which is 1 m.
        peer.entity("real1", lambda one: one["X"] > 1.5)
        places = [json.loads(data)["X"] for _, data in list(poses)]
        assert [event for event in peer.events() if event["Code"] == "stale"] == []
    assert max(abs(after - before) for before, after in pairwise(places)) < 0.5
    stage.signal(child, signal.SIGTERM)
    assert stage.exit(child) == 0
    assert stage.line(child, "bridged")["missing"] == "0"


@pytest.mark.parametrize("name", ["other1", "real1"])
def test_a_second_bridge_on_the_same_line_is_refused_and_the_first_is_not_disturbed(stage: Stage, name: str) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage)
    bridge(stage, "real1", "serial", "--port", str(controller.port), "--place", "start")
    mind(stage, "real1", "drive", "--option", "left=0.2", "--option", "right=0.2")
    with stage.peer() as peer:
        controller.line("moving")
        peer.entity("real1", lambda one: one["X"] > 0.1)
        second = bridge(stage, name, "serial", "--port", str(controller.port), "--place", "goal", joined=False)
        assert stage.exit(second) == 1
        assert f"{controller.port} is in use by another program" in stage.log(second)
        before = peer.entity("real1", lambda one: one["X"] > 0.1)["X"]
        peer.entity("real1", lambda one: one["X"] > before + 0.2)
        assert [event["Code"] for event in peer.events() if event["Code"] in ("stale", "lost", "left")] == []
    # The controller stopped its motors at no time: it has printed one line only.
    assert stage.log(controller.child).count("moving") == 1
    assert "stopped" not in stage.log(controller.child)


def test_a_bridge_that_the_simulator_refuses_writes_nothing_to_its_line(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    stage.agent("real1", "drive")
    controller = Controller(stage)
    child = bridge(stage, "real1", "serial", "--port", str(controller.port), "--place", "start", joined=False)
    assert stage.exit(child) == 4
    assert "already-here" in stage.log(child)
    assert "powered" not in stage.log(controller.child)


# ---------------------------------------------------------------- after an interruption


def bridge_with_input(stage: Stage, port: Path, *words: str) -> tuple[str, Path]:
    """Start a bridge of `real1` on a line; return it, and the pipe that is its standard input."""
    pipe = stage.folder / "enter"
    os.mkfifo(pipe)
    command = [
        sys.executable, "-m", "intellwheels_agents.bridge", "serial", "--port", str(port), "--name", "real1",
        "--place", "start", "--connect", stage.endpoint, "--world", stage.world, *words,
    ]  # fmt: skip
    child = stage.launch(
        "bridge", lambda lifeline: ["sh", "-c", 'exec "$@" <> "$0"', str(pipe), *command, "--lifeline", str(lifeline)]
    )
    stage.line(child, "joined")
    return child, pipe


def press_enter_until_resumed(stage: Stage, child: str, pipe: Path) -> None:
    """Press Enter again and again: the answer to a join may hold the chair once more after the first time."""
    with pipe.open("w") as enter:

        def pressed() -> bool | None:
            enter.write("\n")
            enter.flush()
            return True if "resumed agent=real1" in stage.log(child) else None

        stage.wait(pressed, "resumed", unless=child)


@pytest.mark.parametrize("resume", ["confirm", "auto"])
def test_after_the_return_of_the_simulator_a_person_says_go(stage: Stage, resume: str) -> None:
    server = stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage)
    # Confirmation is the default of real hardware.
    child, pipe = bridge_with_input(stage, controller.port, *(() if resume == "confirm" else ("--resume", "auto")))
    mind(stage, "real1", "drive", "--option", "left=0.1", "--option", "right=0.1")
    controller.line("moving")
    stage.signal(server, signal.SIGKILL)
    stage.line(child, "simulator-gone", agent="real1")
    controller.stops_by_command()
    stage.server("--map", "corridor15m", "--pace", "realtime")
    if resume == "confirm":
        with stage.peer() as peer:
            stage.line(child, "ready", agent="real1")
            # The mind drives again, and the simulator asks for power, but the chair stands.
            powers = peer.hear("out/real1/power")
            stage.wait(
                lambda: next((True for _, data in list(powers) if json.loads(data)["LeftMotor"] > 0.05), None), "power"
            )
            peer.ticks_on(20)
            assert "moving" not in stage.log(controller.child).rpartition("stopped")[2]
        press_enter_until_resumed(stage, child, pipe)
    controller.line("moving")
    assert ("held agent=real1" in stage.log(child)) == (resume == "confirm")
    stage.signal(child, signal.SIGTERM)
    assert stage.exit(child) == 0


def test_after_the_return_of_the_router_a_person_says_go(stage: Stage) -> None:
    def start_router() -> str:
        child = stage.start("router", "intellwheels_server.service.router", "--listen", stage.endpoint)
        stage.line(child, "ready")
        return child

    router = start_router()
    server = stage.start(
        "server", "intellwheels_server", "--connect", stage.endpoint, "--world", stage.world,
        "--map", "corridor15m", "--pace", "realtime",
    )  # fmt: skip
    stage.line(server, "ready")
    controller = Controller(stage)
    child, pipe = bridge_with_input(stage, controller.port)
    mind(stage, "real1", "drive", "--option", "left=0.1", "--option", "right=0.1")
    controller.line("moving")
    stage.signal(router, signal.SIGKILL)
    controller.stops_by_command()
    start_router()
    stage.line(child, "ready", agent="real1")
    press_enter_until_resumed(stage, child, pipe)
    controller.line("moving")


def test_the_bridge_says_at_once_what_it_waits_for(stage: Stage) -> None:
    port = stage.folder / "tty"
    child = bridge(stage, "real1", "serial", "--port", str(port), "--place", "start", joined=False)

    def says(text: str) -> None:
        stage.wait(lambda: text in stage.log(child) or None, text, unless=child)

    says(f"waiting why='cannot open {port}: No such file or directory'")
    Controller(stage)
    stage.line(child, "hardware", agent="real1")
    says(f"waiting why='nobody answers at {stage.endpoint}; {START_ONE}'")
    stage.server("--map", "corridor15m", "--pace", "realtime")
    stage.line(child, "joined", agent="real1")
    # Each reason once. That the server listens, but has not answered yet, may be a third one.
    waits = [line for line in stage.log(child).splitlines() if line.startswith("waiting why=")]
    assert len(waits) == len(set(waits))


def test_the_bridge_prints_what_happens_to_its_chair(stage: Stage) -> None:
    server = stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage)
    child = bridge(stage, "real1", "serial", "--port", str(controller.port), "--place", "start")
    with stage.peer() as peer:
        driver = mind(stage, "real1", "drive", "--option", "left=0.1", "--option", "right=0.1")
        stage.line(child, "mind-joined", agent="real1")
        controller.line("moving")
        lease = peer.ctl("take", Agent="real1", Seconds=30.0)["Lease"]
        stage.line(child, "taken", agent="real1")
        assert peer.ctl("take", Agent="real1", Lease=lease, Seconds=0.0)["Code"] == "ok"
        stage.line(child, "released", agent="real1")
        stage.signal(driver, signal.SIGTERM)
        stage.line(child, "mind-left", agent="real1")
        assert peer.ctl("delete", Agent="real1")["Code"] == "ok"
        stage.line(child, "removed", agent="real1", reason="deleted")
    stage.signal(server, signal.SIGKILL)
    stage.line(child, "simulator-gone", agent="real1")


def test_a_bridge_that_listens_for_the_simulator_prints_events_too(stage: Stage) -> None:
    controller = Controller(stage)
    child = stage.start(
        "bridge", "intellwheels_agents.bridge", "serial", "--port", str(controller.port), "--place", "start",
        "--name", "real1", "--listen", stage.endpoint, "--world", stage.world,
    )  # fmt: skip
    stage.line(child, "hardware")
    server = stage.start(
        "server", "intellwheels_server", "--connect", stage.endpoint, "--world", stage.world,
        "--map", "corridor15m", "--pace", "realtime",
    )  # fmt: skip
    stage.line(child, "joined")
    stage.signal(server, signal.SIGKILL)
    stage.line(child, "simulator-gone", agent="real1")
    stage.signal(child, signal.SIGTERM)
    assert stage.exit(child) == 0


def test_the_motors_stop_at_once_when_the_simulation_is_paused(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    controller = Controller(stage)
    bridge(stage, "real1", "serial", "--port", str(controller.port), "--place", "start")
    mind(stage, "real1", "drive", "--option", "left=0.1", "--option", "right=0.1")
    with stage.peer() as peer:
        controller.line("moving")
        assert peer.ctl("pause")["Code"] == "ok"
        controller.stops_by_command()
        # A pause is no interruption: who resumes it has said go.
        assert peer.ctl("resume")["Code"] == "ok"
        controller.line("moving")


def test_the_robot_has_the_size_that_these_tests_assume() -> None:
    part = robot_file("intellwheels").part[0]
    assert (part.x + part.length / 2.0, part.x - part.length / 2.0) == pytest.approx((0.696, -0.504))
