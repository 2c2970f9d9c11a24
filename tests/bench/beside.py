"""The same benchmarks of another commit, in a checkout of its own, for ratios within one run."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from tests.bench.rows import Row

ROOT = Path(__file__).parents[2]
DEADLINE = 3600.0
SOURCES = ("agents", "maps", "schemas", "server", "viewer")


def rows_of(commit: str, bench: str, *, quick: bool = False) -> list[Row]:
    """Return the rows of a benchmark of another commit, measured now; none if that commit does not have it.

    Raises:
        RuntimeError: There is no such commit, or its benchmark fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        tree, file = Path(folder) / "tree", Path(folder) / "rows.csv"
        _run(["git", "worktree", "add", "--detach", str(tree), commit], ROOT)
        try:
            if not (tree / "tests" / "bench" / f"{bench}.py").exists():
                return []
            words = [sys.executable, "-m", "tests.bench", bench, "--csv", str(file), *(["--quick"] if quick else [])]
            paths = [str(tree), *(str(tree / name) for name in SOURCES)]
            _run(words, tree, {**os.environ, "PYTHONPATH": os.pathsep.join(paths)})
            with file.open(newline="") as stream:
                return [_row(line) for line in csv.DictReader(stream)]
        finally:
            _run(["git", "worktree", "remove", "--force", str(tree)], ROOT)


def ratios(rows: Iterable[Row], others: Iterable[Row]) -> list[Row]:
    """Return each figure as a ratio to the same figure of the other commit, where it has one that is not 0."""
    known = {(row.bench, row.case, row.figure): row.value for row in others}
    return [
        Row(row.bench, row.case, row.figure, row.value / value, "of the other")
        for row in rows
        if (value := known.get((row.bench, row.case, row.figure)))
    ]


def _row(line: dict[str, str]) -> Row:
    return Row(line["bench"], line["case"], line["figure"], float(line["value"]), line["unit"], line["goal"])


def _run(words: list[str], folder: Path, env: dict[str, str] | None = None) -> None:
    done = subprocess.run(
        words, cwd=folder, env=env, capture_output=True, text=True, timeout=DEADLINE, check=False
    )  # fmt: skip
    if done.returncode != 0:
        raise RuntimeError(f"expected exit code 0 of {' '.join(words)}, got {done.returncode}: {done.stderr[-2000:]}")
