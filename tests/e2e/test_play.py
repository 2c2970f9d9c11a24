"""With real processes: a recorded run is played back as a world, and a live run goes back to a saved state."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest

from intellwheels_server.log.input_log import read_header, read_lines
from tests.e2e.stage import Stage, run


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("play")
    done = run("intellwheels_experiments", "figure6", "--log", str(folder / "run.log"), timeout=180.0)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "run.log"


@pytest.fixture(scope="module")
def hashes(log: Path) -> list[str]:
    """The recorded hash of every tick from 1 on."""
    with log.open("rb") as file:
        read_header(file, str(log))
        return [line.hash for line in read_lines(file, str(log)) if line is not None and line.stepped]


def play(stage: Stage, log: Path, *words: str) -> None:
    stage.simulator = stage.start(
        "player", "intellwheels_server", "--play", str(log), "--world", stage.world, "--listen", stage.endpoint, *words
    )
    stage.line("player", "ready", timeout=60.0, world=stage.world)


def test_figure6_is_played_paused_and_sought_with_the_recorded_hashes(
    stage: Stage, log: Path, hashes: list[str]
) -> None:
    play(stage, log, "--speed", "4")
    with stage.peer() as peer:
        measures = peer.hear("out/chair1/measures")
        waiting = peer.clock()
        assert (waiting["State"], waiting["Tick"]) == ("paused", 0)
        assert peer.ctl("resume")["Code"] == "ok"
        peer.tick(20)
        assert peer.ctl("pause")["Code"] == "ok"
        clock = peer.clock()
        assert (clock["State"], clock["Last"]) == ("paused", len(hashes))
        assert clock["Hash"] == hashes[clock["Tick"] - 1]
        assert measures
        assert json.loads(measures[-1][1])["Tick"] == clock["Tick"]
        assert peer.entities().keys() == {"chair1", "chair2", "chair3", "door", "table"}
        took = []
        for tick in (len(hashes) // 2, 10, len(hashes) - 1, 5):
            began = time.monotonic()
            result = peer.ctl("seek", Tick=tick)
            took.append(time.monotonic() - began)
            assert (result["Code"], result["Tick"], result["Hash"]) == ("ok", tick, hashes[tick - 1])
            assert peer.clock()["Tick"] == tick
        assert sorted(took)[len(took) // 2] < 0.5, took  # the machine may be busy during one of them
        assert peer.ctl("teleport", Agent="chair1", Position={"X": 1.0, "Y": 1.0, "Heading": 0.0})["Text"] == (
            "a played log cannot be steered"
        )
        assert peer.ctl("resume")["Code"] == "ok"
        peer.tick(15)
        peer.ctl("seek", Tick=len(hashes) - 3)
        stage.line("player", "ended", tick=str(len(hashes)), hash=hashes[-1])
        assert peer.clock()["State"] == "ended"
        assert peer.ctl("quit")["Code"] == "ok"
    assert stage.exit("player") == 0


def test_a_player_takes_the_name_of_the_world_that_was_recorded(stage: Stage, log: Path) -> None:
    with log.open("rb") as file:
        world = read_header(file, str(log)).world
    stage.start("player", "intellwheels_server", "--play", str(log), "--listen", stage.endpoint, "--quit-at-end",
                "--speed", "1000")  # fmt: skip
    stage.line("player", "ready", timeout=60.0, world=f"{world[:27]}-play")
    stage.line("player", "ended", timeout=60.0)
    assert stage.exit("player") == 0


def test_agents_of_a_live_run_continue_from_a_restored_state(stage: Stage, tmp_path: Path) -> None:
    file = tmp_path / "live.log"
    stage.server("--pace", "lockstep", "--log", str(file))
    stage.agent("chair1", "avoid")
    with stage.peer() as peer:
        peer.tick(30)
        saved = peer.ctl("save")
        peer.tick(saved["Tick"] + 50)
        late = stage.agent("chair2", "avoid")
        peer.event("joined", "chair2")
        restored = peer.ctl("restore", Slot=saved["Slot"])
        assert (restored["Code"], restored["Tick"], restored["Hash"]) == ("ok", saved["Tick"], saved["Hash"])
        stage.line("chair1", "run", run=restored["Run"])
        stage.line(late, "joined", run=restored["Run"])
        peer.tick(saved["Tick"] + 20)
        assert peer.entities().keys() == {"chair1", "chair2"}
        peer.ctl("quit")
    assert stage.exit(stage.simulator) == 0
    done = run("intellwheels_server", "--resimulate", str(file))
    assert done.stdout.startswith("same "), done.stdout + done.stderr
