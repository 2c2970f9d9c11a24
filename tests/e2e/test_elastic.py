"""An elastic run is what happened: its log, and nothing else, runs again to the same hashes."""

from __future__ import annotations

import json
import signal

from tests.e2e.stage import Stage, run


def test_elastic_run_with_an_agent_killed_and_come_back_is_run_again_to_the_same_hashes(stage: Stage) -> None:
    log = stage.folder / "run.log"
    server = stage.server(
        "--map", "room", "--pace", "lockstep", "--miss", "elastic", "--deadline", "0.3",
        "--expect", "chair1,chair2", "--log", str(log),
    )  # fmt: skip
    words = ("--option", "left=0.1", "--option", "right=0.12", "--option", "MotorNoise=0.015")
    first = stage.agent("chair1", "drive", *words, joined=False)
    stage.agent("chair2", "drive", *words, joined=False)
    with stage.peer() as peer:
        peer.tick(50)
        stage.signal(first, signal.SIGKILL)
        lost = peer.event("lost", "chair1")
        peer.tick(lost["Tick"] + 20)
        stage.agent("chair1", "drive", *words)
        peer.ticks_on(100)
    stage.signal(server, signal.SIGTERM)
    assert stage.exit(server) == 0

    done = run("intellwheels_server", "--resimulate", str(log))
    assert done.returncode == 0, done.stdout + done.stderr

    # One hash that is another: the first such tick is named.
    lines = log.read_text().splitlines()
    tick = next(i for i, line in enumerate(lines) if i > 30 and "Hash" in json.loads(line))
    entry = json.loads(lines[tick])
    entry["Hash"] = "0" * 16
    lines[tick] = json.dumps(entry)
    log.write_text("\n".join(lines) + "\n")
    done = run("intellwheels_server", "--resimulate", str(log))
    assert done.returncode == 1
    assert str(entry["Tick"]) in done.stdout + done.stderr
