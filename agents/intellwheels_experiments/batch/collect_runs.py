"""Brings the runs of a batch's parts together in one folder."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

from intellwheels_experiments.batch.run_store import finished_run, load_run, run_folder
from intellwheels_experiments.batch.scratch_folders import scratch_folder


def collect_runs(out: Path, folders: Iterable[Path], rows: Sequence[str], seeds: Sequence[str]) -> int:
    """Copy runs from the folders of other parts of a batch, and return how many were copied.

    A run is copied if it has finished there and not in `out`. A run that died is copied if `out` has no such run.

    Args:
        out: The folder that takes them.
        folders: The folders of the parts.
        rows: The names of the batch's rows.
        seeds: Its seeds.

    Raises:
        OSError: A file cannot be read or written.
    """
    copied = 0
    for folder in folders:
        for row in rows:
            for seed in seeds:
                run = load_run(folder, row, seed)
                if run is None or finished_run(out, row, seed) is not None:
                    continue
                if run.measured is None and load_run(out, row, seed) is not None:
                    continue
                _copy(run_folder(folder, row, seed), run_folder(out, row, seed), out)
                copied += 1
    return copied


def _copy(source: Path, target: Path, out: Path) -> None:
    """Copy a folder so that a killed process leaves all of it or nothing."""
    with scratch_folder(out, "merge") as scratch:
        shutil.copytree(source, scratch / "run")
        shutil.rmtree(target, ignore_errors=True)
        target.parent.mkdir(parents=True, exist_ok=True)
        (scratch / "run").rename(target)
