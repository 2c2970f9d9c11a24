"""`iw-run --seeds` from the command line: a batch that is killed and resumed has the same result."""

from __future__ import annotations

import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from intellwheels_experiments.run.child_processes import ChildProcesses
from tests.experiments.scenes import write_scene

LIMIT = 180.0


def command(scene: Path, out: Path, *more: str) -> list[str]:
    return [sys.executable, "-m", "intellwheels_experiments", str(scene), "--seeds", "4", "--out", str(out), *more]


def results(out: Path) -> list[Path]:
    return sorted(out.glob("runs/*/*/result.json"))


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One for all: a batch knows the scene by its path."""
    return write_scene(tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def whole(scene: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the batch that one machine makes without a break."""
    out = tmp_path_factory.mktemp("batch") / "whole"
    through = subprocess.run(command(scene, out), capture_output=True, text=True, timeout=LIMIT, check=False)
    assert through.returncode == 0, through.stderr
    assert through.stdout.count("row name=") == 2
    return out


def test_batch_that_is_killed_and_resumed_gives_the_same_csv(scene: Path, whole: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut"
    with ChildProcesses(tmp_path / "logs") as children:
        child = children.launch("batch", lambda _lifeline: command(scene, cut))
        children.wait(lambda: results(cut)[2:] or None, "three runs", LIMIT, unless=child)
        children.signal(child, signal.SIGKILL)
        assert children.exit(child) == -signal.SIGKILL
    finished = {path: path.stat().st_mtime_ns for path in results(cut)}
    assert 3 <= len(finished) < 8
    again = subprocess.run(
        command(scene, cut, "--jobs", "2"), capture_output=True, text=True, timeout=LIMIT, check=False
    )
    assert again.returncode == 0, again.stderr
    assert f"{len(finished)} of 8 runs are done" in again.stderr
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
    assert (cut / "batch.csv").read_text() == (whole / "batch.csv").read_text()
    assert (cut / "junit.xml").read_text() == (whole / "junit.xml").read_text()
    assert "<svg" in (cut / "report.html").read_text()
    # Nor is anything left of the worker that was killed.
    assert list(cut.glob(".*")) == []


def test_folder_of_another_batch_is_refused(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "batch.json").write_text("{}")
    refused = subprocess.run(command(scene, out), capture_output=True, text=True, timeout=LIMIT, check=False)
    assert (refused.returncode, "got another batch's" in refused.stderr) == (2, True)


def _words(words: list[str], _lifeline: int) -> list[str]:
    return words


def test_parts_of_two_machines_merged_give_the_csv_of_one(scene: Path, whole: Path, tmp_path: Path) -> None:
    merged = tmp_path / "merged"
    parts = [tmp_path / "first", tmp_path / "second"]
    with ChildProcesses(tmp_path / "logs") as children:
        words = [command(scene, out, "--part", f"{number}/2") for number, out in enumerate(parts, 1)]
        names = [children.launch(f"batch{number}", partial(_words, one)) for number, one in enumerate(words)]
        assert [children.exit(name, LIMIT) for name in names] == [0, 0]
    done = subprocess.run(
        command(scene, merged, "--merge", str(parts[0]), "--merge", str(parts[1])),
        capture_output=True, text=True, timeout=LIMIT, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert f"merged runs=8 folders=2 out={merged}" in done.stdout
    assert (merged / "batch.csv").read_text() == (whole / "batch.csv").read_text()
