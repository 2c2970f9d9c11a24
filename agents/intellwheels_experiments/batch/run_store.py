"""The files of a batch: a folder of each run, and what is told of all. A run is done when its `result.json` is there.

    runs/ROW/SEED/  input.jsonl   the input log, for `iw-server --resimulate` and `--play`
                    image.jsonl   of a chair in a laboratory, the log of the world that shows it
                    true.tum reported.tum command.tum   trajectories: t x y z qx qy qz qw
                    contacts.csv  along.csv  bodies.csv (the others that moved)  robot.json  measures.csv  result.json
    batch.json      what is run, and where with
    batch.csv       a line a run; no wall time, host or date, so that equal batches have equal files

`result.json` is put in its place at once, so that a process that is killed leaves no half of it.
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
from intellwheels_experiments.batch.run_measures import Course, Measured

RESULT: Final = "result.json"
LOG: Final = "input.jsonl"
IMAGE: Final = "image.jsonl"


class StoredRun(msgspec.Struct, frozen=True, kw_only=True):
    """What came of a run.

    Attributes:
        row: Its row.
        seed: Its seed.
        died: Why it came to no end, or empty.
        measured: Its numbers, or None where it came to no end.
        wall: Seconds of wall time; not for the CSV.
    """

    row: str
    seed: str
    died: str = ""
    measured: Measured | None = None
    wall: float = 0.0


def place_of(folder: Path, row: str, seed: str) -> Path:
    """Return the folder of a run."""
    return folder / "runs" / row / seed


def done(folder: Path, row: str, seed: str) -> StoredRun | None:
    """Return what came of a run that came to its end, or None: then it is to be run."""
    try:
        kept = msgspec.json.decode((place_of(folder, row, seed) / RESULT).read_bytes(), type=StoredRun)
    except (OSError, msgspec.MsgspecError):
        return None
    return kept if kept.measured is not None else None


def keep(
    folder: Path, kept: StoredRun, course: Course | None = None, log: Path | None = None, image: Path | None = None
) -> None:
    """Write the files of a run, `result.json` last.

    Args:
        folder: The batch's.
        kept: What came of it.
        course: The run along its time.
        log: The input log of the world that its chair was truly in.
        image: That of the world that showed it, of a chair in a laboratory.
    """
    place = place_of(folder, kept.row, kept.seed)
    place.mkdir(parents=True, exist_ok=True)
    if log is not None:
        shutil.copyfile(log, place / LOG)
    if image is not None:
        shutil.copyfile(image, place / IMAGE)
    if course is not None:
        _write_course(place, course)
        (place / "robot.json").write_bytes(msgspec.json.encode(course.robot) + b"\n")
    if kept.measured is not None:
        (place / "measures.csv").write_text(table([kept]))
    draft = place / f"{RESULT}.part"
    draft.write_bytes(msgspec.json.format(msgspec.json.encode(kept), indent=2) + b"\n")
    draft.replace(place / RESULT)


def _write_course(place: Path, course: Course) -> None:
    for name, poses in (("true", course.true), ("reported", course.reported), ("command", course.commanded)):
        if poses is not None:
            (place / f"{name}.tum").write_text(tum(course.times, poses))
    heads = ("time", "agent", "other", "x", "y", "speed")
    rows = [(one.tick, one.agent, one.other, one.x, one.y, one.speed) for one in course.contacts]
    (place / "contacts.csv").write_text(_csv([("tick", *heads[1:]), *rows]))
    if course.others:
        titles = [f"{name}_{what}" for name in course.others for what in ("x", "y", "heading")]
        values = np.column_stack([course.times, *course.others.values()])
        lines = [[f"{value:.6g}" for value in line] for line in values]
        (place / "bodies.csv").write_text(_csv([("time", *titles), *lines]))
    error = np.full((len(course.times), 2), math.nan)
    if course.reported is not None:
        error = course.reported[:, :2] - course.true[:, :2]
    series = zip(course.times, course.clearance, course.speed, *error.T, strict=True)
    lines = [[f"{value:.6g}" for value in line] for line in series]
    (place / "along.csv").write_text(_csv([("time", "clearance", "speed", "error_x", "error_y"), *lines]))


def tum(times: Floats, poses: Floats) -> str:
    """Return a trajectory as a line a pose: t x y z qx qy qz qw, s and m, z 0 and a turn about z.

    Source:
        The trajectory format of the TUM RGB-D benchmark, Sturm et al. (2012), which evo and others read.
    """
    half = poses[:, 2] / 2.0
    lines = [
        f"{t:.3f} {x:.6f} {y:.6f} 0 0 0 {sine:.9f} {cosine:.9f}\n"
        for t, x, y, sine, cosine in zip(times, poses[:, 0], poses[:, 1], np.sin(half), np.cos(half), strict=True)
    ]
    return "".join(lines)


def read_tum(path: Path) -> Floats | None:
    """Return a trajectory, float64[n, 4]: t, x, y, heading; None where there is none."""
    try:
        found = np.loadtxt(path, ndmin=2)
    except OSError:
        return None
    return np.column_stack([found[:, :3], 2.0 * np.arctan2(found[:, 6], found[:, 7])])


FIELDS: Final = Measured.__struct_fields__


def table(runs: Iterable[StoredRun]) -> str:
    """Return runs as CSV, a line each; what has no value is empty."""
    lines: list[Sequence[object]] = [("row", "seed", "died", *FIELDS)]
    for kept in runs:
        values = [_cell(getattr(kept.measured, name)) if kept.measured else "" for name in FIELDS]
        lines.append((kept.row, kept.seed, "yes" if kept.died else "no", *values))
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
