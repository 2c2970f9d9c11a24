"""A stand with real processes: every run of it begins alike, and what ends badly is told with its cause."""

from __future__ import annotations

import json
import threading
from pathlib import Path

import pytest

from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_experiments.batch.run_worker import Branch, RunWorker, RunWorkerError, Site, StoppedError
from intellwheels_maps import scene
from tests.experiments.scenes import write_scene

pytestmark = pytest.mark.process


def put_up(folder: Path, *, dies: bool = False, laboratory: bool = False) -> tuple[Site, tuple[Row, ...]]:
    path = write_scene(folder, dies=dies, laboratory=laboratory)
    site = Site(source=str(path), folder=folder, logs=folder / "logs", runs=folder / "runs", timeout=60.0)
    return site, rows_of(scene(str(path)))


def poses(place: Path) -> list[object]:
    """Return what was true of the chair at each tick of a run."""
    return [json.loads(line).get("Body") for line in (place / "trace.jsonl").read_text().splitlines()[1:]]


def test_runs_of_a_stand_begin_alike_the_first_too_and_a_seed_is_a_run(tmp_path: Path) -> None:
    site, rows = put_up(tmp_path)
    with RunWorker(site, rows[0], threading.Event()) as stand:
        places = [stand.run(seed) for seed in ("1", "2", "1")]
    assert [shown for _, shown in places] == [None, None, None]
    first, second, again = (poses(place) for place, _ in places)
    assert len(first) > 30
    assert first == again
    assert first != second


def test_laboratory_and_the_world_that_shows_it_both_have_their_files_the_same_each_time(tmp_path: Path) -> None:
    site, rows = put_up(tmp_path, laboratory=True)
    with RunWorker(site, rows[2], threading.Event()) as stand:
        told = [stand.run("1") for _ in range(2)]
    (truth, shown), (truth_again, shown_again) = told
    assert shown is not None
    assert shown_again is not None
    assert poses(truth) == poses(truth_again)
    # The image may or may not have been made of the last ticks.
    ticks = len(poses(truth)) - 2
    assert ticks > 10
    assert poses(shown)[:ticks] == poses(shown_again)[:ticks]
    assert poses(shown)[:ticks] != poses(truth)[:ticks]


def test_mind_that_fails_is_named_with_its_last_words(tmp_path: Path) -> None:
    site, rows = put_up(tmp_path, dies=True)
    with RunWorker(site, rows[0], threading.Event()) as stand:
        stand.run("1")
        with pytest.raises(RunWorkerError, match=r"agent-chair: (?s:.*)it was to fail"):
            stand.run("2")


def test_stand_that_is_told_to_stop_gives_up_and_leaves_nobody_behind(tmp_path: Path) -> None:
    site, rows = put_up(tmp_path)
    stop = threading.Event()
    with RunWorker(site, rows[0], stop) as stand:
        stop.set()
        with pytest.raises(StoppedError):
            stand.run("1")
    assert "left agent=chair" in (site.logs / "server.log").read_text()


def test_simulator_that_does_not_start_is_told(tmp_path: Path) -> None:
    site, rows = put_up(tmp_path)
    (tmp_path / "short.xml").unlink()
    with (
        pytest.raises(RunWorkerError, match=r"server: exit 2(?s:.*)short.xml"),
        RunWorker(site, rows[0], threading.Event()),
    ):
        pass


def test_branch_tells_each_world_its_own_log() -> None:
    branch = Branch(log=Path("/a/input.jsonl"), at=7, image=Path("/a/image.jsonl"))
    assert branch.words(of_image=False) == ["--branch", "/a/input.jsonl", "--at", "7"]
    assert branch.words(of_image=True) == ["--branch", "/a/image.jsonl", "--at", "7"]
