"""Folders for unfinished work: those of killed processes are deleted, those in use are not."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from intellwheels_experiments.batch.scratch_folders import delete_abandoned, scratch_folder

HOLDS = """\
import sys, pathlib
from intellwheels_experiments.batch.scratch_folders import scratch_folder
with scratch_folder(pathlib.Path(sys.argv[1]), "worker") as folder:
    print(folder, flush=True)
    sys.stdin.read()
"""


def test_a_folder_is_there_while_it_is_used(tmp_path: Path) -> None:
    with scratch_folder(tmp_path, "merge") as folder:
        (folder / "file").write_text("half")
        delete_abandoned(tmp_path)
        assert (folder / "file").read_text() == "half"
    assert list(tmp_path.iterdir()) == []


def test_what_another_machine_or_a_person_made_stays(tmp_path: Path) -> None:
    (tmp_path / ".worker-another.machine-x1").mkdir()
    (tmp_path / "runs").mkdir()
    delete_abandoned(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {".worker-another.machine-x1", "runs"}


def test_a_folder_that_is_not_there_has_nothing_to_delete(tmp_path: Path) -> None:
    delete_abandoned(tmp_path / "nowhere")


@pytest.mark.process
def test_the_folder_of_a_killed_process_is_deleted_and_not_before(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", HOLDS, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout is not None
        folder = Path(child.stdout.readline().strip())
        delete_abandoned(tmp_path)
        assert folder.is_dir()
        os.kill(child.pid, signal.SIGKILL)
        child.wait(60.0)
    assert folder.is_dir()
    delete_abandoned(tmp_path)
    assert not folder.exists()
