"""A worker with real processes: all its runs start alike, and a run that dies is reported with its cause."""

from __future__ import annotations

import json
import threading
from pathlib import Path

import pytest

from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_experiments.batch.run_worker import Branch, RunWorker, RunWorkerError, StoppedError, WorkerSettings
from intellwheels_maps import scene
from tests.experiments.foreign import COMMAND, write_foreign
from tests.experiments.scenes import write_scene

pytestmark = pytest.mark.process


def prepare(folder: Path, *, dies: bool = False, laboratory: bool = False) -> tuple[WorkerSettings, tuple[Row, ...]]:
    path = write_scene(folder, dies=dies, laboratory=laboratory)
    settings = WorkerSettings(source=str(path), folder=folder, logs=folder / "logs", runs=folder / "runs", timeout=60.0)
    return settings, rows_of(scene(str(path)))


def poses(place: Path) -> list[object]:
    """Return the true bodies at each tick of a run."""
    return [json.loads(line).get("Body") for line in (place / "trace.jsonl").read_text().splitlines()[1:]]


def test_runs_of_a_worker_start_alike_and_depend_on_the_seed_alone(tmp_path: Path) -> None:
    settings, rows = prepare(tmp_path)
    with RunWorker(settings, rows[0], threading.Event()) as worker:
        places = [worker.run(seed) for seed in ("1", "2", "1")]
    assert [mirror for _, mirror in places] == [None, None, None]
    first, second, again = (poses(place) for place, _ in places)
    assert len(first) > 30
    assert first == again
    assert first != second


FOREIGN = f"""\
<Scene Format="iw.v1" Name="foreign" Map="corridor15m" Pace="lockstep" Miss="strict">
  <Cast Name="chair" Place="start" Command="{COMMAND}" NewRun="restart"/>
  <End><Timeout Seconds="1"/></End>
</Scene>
"""


def test_program_of_a_command_is_started_again_for_each_run_and_each_run_is_the_same(tmp_path: Path) -> None:
    write_foreign(tmp_path)
    path = tmp_path / "foreign.xml"
    path.write_text(FOREIGN)
    settings = WorkerSettings(
        source=str(path), folder=tmp_path, logs=tmp_path / "logs", runs=tmp_path / "runs", timeout=60.0
    )
    with RunWorker(settings, rows_of(scene(str(path)))[0], threading.Event()) as worker:
        places = [worker.run(seed) for seed in ("1", "2", "1")]
    first, second, again = (poses(place) for place, _ in places)
    assert len(first) > 15
    assert all(first)  # the trace begins when all bodies are there
    assert first == again
    assert first != second


def test_laboratory_and_mirror_both_have_files_and_each_run_is_the_same(tmp_path: Path) -> None:
    settings, rows = prepare(tmp_path, laboratory=True)
    with RunWorker(settings, rows[2], threading.Event()) as worker:
        folders = [worker.run("1") for _ in range(2)]
    (truth, mirror), (truth_again, mirror_again) = folders
    assert mirror is not None
    assert mirror_again is not None
    assert poses(truth) == poses(truth_again)
    # The mirror may or may not have shown the last ticks.
    ticks = len(poses(truth)) - 2
    assert ticks > 10
    assert poses(mirror)[:ticks] == poses(mirror_again)[:ticks]
    assert poses(mirror)[:ticks] != poses(truth)[:ticks]


def test_mind_that_fails_is_named_with_its_last_lines(tmp_path: Path) -> None:
    settings, rows = prepare(tmp_path, dies=True)
    with RunWorker(settings, rows[0], threading.Event()) as worker:
        worker.run("1")
        with pytest.raises(RunWorkerError, match=r"agent-chair: (?s:.*)failed on purpose"):
            worker.run("2")


def test_worker_that_is_told_to_stop_ends_all_its_processes(tmp_path: Path) -> None:
    settings, rows = prepare(tmp_path)
    stop = threading.Event()
    with RunWorker(settings, rows[0], stop) as worker:
        stop.set()
        with pytest.raises(StoppedError):
            worker.run("1")
    assert "left agent=chair" in (settings.logs / "server.log").read_text()


def test_simulator_that_does_not_start_is_reported(tmp_path: Path) -> None:
    settings, rows = prepare(tmp_path)
    (tmp_path / "short.xml").unlink()
    with (
        pytest.raises(RunWorkerError, match=r"server: exit 2(?s:.*)short.xml"),
        RunWorker(settings, rows[0], threading.Event()),
    ):
        pass


def test_each_world_of_a_branch_follows_its_own_log() -> None:
    branch = Branch(log=Path("/a/input.jsonl"), at=7, mirror=Path("/a/image.jsonl"))
    assert branch.arguments(of_mirror=False) == ["--branch", "/a/input.jsonl", "--at", "7"]
    assert branch.arguments(of_mirror=True) == ["--branch", "/a/image.jsonl", "--at", "7"]
