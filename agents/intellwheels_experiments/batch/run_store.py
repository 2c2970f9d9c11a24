"""The files of a batch: one folder per run, and the files about all runs. A run is finished once it has `result.json`.

    runs/ROW/SEED/  input.jsonl   the input log, for `iw-server --resimulate` and `--play`
                    image.jsonl   for a chair in a laboratory, the log of the world that mirrors it
                    true.tum reported.tum command.tum   trajectories: t x y z qx qy qz qw
                    contacts.csv  along.csv  bodies.csv (the others that moved)  robot.json  measures.csv  result.json
    batch.json      the scene and the map of the batch
    batch.csv       one line per run, without wall time, host or date, so that equal batches have equal files

`result.json` is written under another name and then renamed, so that a killed process never leaves half a file.
"""

from __future__ import annotations

import csv
import io
import math
import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from intellwheels_experiments.batch.metrics import Floats
from intellwheels_experiments.batch.run_measures import RunMeasures, RunSeries

RESULT: Final = "result.json"
LOG: Final = "input.jsonl"
MIRROR_LOG: Final = "image.jsonl"


class StoredRun(msgspec.Struct, frozen=True, kw_only=True):
    """A run, as `result.json` holds it. A run that was not made has no such file: neither `died` nor `measured`.

    Attributes:
        row: Its row.
        seed: Its seed.
        died: Why it did not reach its end; empty if it did, or if it was not made.
        measured: Its measures; None if it did not reach its end, or if it was not made.
        wall: Wall time in s. The CSV leaves it out.
        drawn: The offsets that its seed drew, by what they were added to.
    """

    row: str
    seed: str
    died: str = ""
    measured: RunMeasures | None = None
    wall: float = 0.0
    drawn: dict[str, float] = {}

    @property
    def is_missing(self) -> bool:
        """Whether the run was not made."""
        return self.measured is None and not self.died


def run_folder(folder: Path, row: str, seed: str) -> Path:
    """Return the folder of a run in the folder of its batch."""
    return folder / "runs" / row / seed


def load_run(folder: Path, row: str, seed: str) -> StoredRun | None:
    """Return a stored run, whether it finished or died; None if there is none or its file cannot be read."""
    try:
        return msgspec.json.decode((run_folder(folder, row, seed) / RESULT).read_bytes(), type=StoredRun)
    except (OSError, msgspec.MsgspecError):
        return None


def finished_run(folder: Path, row: str, seed: str) -> StoredRun | None:
    """Return a stored run that reached its end; None if the run still has to be made."""
    run = load_run(folder, row, seed)
    return run if run is not None and run.measured is not None else None


def store_run(
    folder: Path, run: StoredRun, series: RunSeries | None = None, log: Path | None = None, mirror: Path | None = None
) -> None:
    """Write the files of a run, `result.json` last.

    Args:
        folder: The batch's folder.
        run: The run.
        series: Its time series.
        log: The input log of the world in which its chair truly was.
        mirror: For a chair in a laboratory, the input log of the world that mirrored it.
    """
    target = run_folder(folder, run.row, run.seed)
    target.mkdir(parents=True, exist_ok=True)
    if log is not None:
        shutil.copyfile(log, target / LOG)
    if mirror is not None:
        shutil.copyfile(mirror, target / MIRROR_LOG)
    if series is not None:
        _write_series(target, series)
        (target / "robot.json").write_bytes(msgspec.json.encode(series.robot) + b"\n")
    if run.measured is not None:
        (target / "measures.csv").write_text(runs_csv([run]))
    draft = target / f"{RESULT}.part"
    draft.write_bytes(msgspec.json.format(msgspec.json.encode(run), indent=2) + b"\n")
    draft.replace(target / RESULT)


def _write_series(target: Path, series: RunSeries) -> None:
    for name, poses in (("true", series.true), ("reported", series.reported), ("command", series.commanded)):
        if poses is not None:
            (target / f"{name}.tum").write_text(tum(series.times, poses))
    contacts = [(one.tick, one.agent, one.other, one.x, one.y, one.speed) for one in series.contacts]
    (target / "contacts.csv").write_text(_csv([("tick", "agent", "other", "x", "y", "speed"), *contacts]))
    if series.others:
        titles = [f"{name}_{what}" for name in series.others for what in ("x", "y", "heading")]
        values = np.column_stack([series.times, *series.others.values()])
        lines = [[f"{value:.6g}" for value in line] for line in values]
        (target / "bodies.csv").write_text(_csv([("time", *titles), *lines]))
    error = np.full((len(series.times), 2), math.nan)
    if series.reported is not None:
        error = series.reported[:, :2] - series.true[:, :2]
    columns = zip(series.times, series.clearance, series.speed, *error.T, strict=True)
    lines = [[f"{value:.6g}" for value in line] for line in columns]
    (target / "along.csv").write_text(_csv([("time", "clearance", "speed", "error_x", "error_y"), *lines]))


def tum(times: Floats, poses: Floats) -> str:
    """Return a trajectory as text, one line per pose: t x y z qx qy qz qw, in s and m; z is 0, the turn is about z.

    Args:
        times: float64[n], in s.
        poses: float64[n, 3]: x and y in m, heading in rad.

    Source:
        The trajectory format of the TUM RGB-D benchmark, Sturm et al. (2012), which tools such as evo read.
    """
    half = poses[:, 2] / 2.0
    lines = [
        f"{t:.3f} {x:.6f} {y:.6f} 0 0 0 {sine:.9f} {cosine:.9f}\n"
        for t, x, y, sine, cosine in zip(times, poses[:, 0], poses[:, 1], np.sin(half), np.cos(half), strict=True)
    ]
    return "".join(lines)


def read_tum(path: Path) -> Floats | None:
    """Return a trajectory, float64[n, 4]: t in s, x and y in m, heading in rad; None if the file cannot be opened."""
    try:
        values = np.loadtxt(path, ndmin=2)
    except OSError:
        return None
    return np.column_stack([values[:, :3], 2.0 * np.arctan2(values[:, 6], values[:, 7])])


FIELDS: Final = RunMeasures.__struct_fields__


def runs_csv(runs: Iterable[StoredRun]) -> str:
    """Return runs as CSV, one line each, without those that were not made. A measure without a value is empty."""
    lines: list[Sequence[object]] = [("row", "seed", "died", "drawn", *FIELDS)]
    for run in (run for run in runs if not run.is_missing):
        values = [_cell(getattr(run.measured, name)) if run.measured else "" for name in FIELDS]
        offsets = "; ".join(f"{label}={offset:.6g}" for label, offset in run.drawn.items())
        lines.append((run.row, run.seed, "yes" if run.died else "no", offsets, *values))
    return _csv(lines)


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.6g}"
    return str(value)


def _csv(lines: Iterable[Sequence[object]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(lines)
    return text.getvalue()
