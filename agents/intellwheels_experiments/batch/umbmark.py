"""UMBmark of a batch: the odometry calibration that its squares yield, compared with the true wheels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from intellwheels_experiments.batch import metrics
from intellwheels_experiments.batch.metrics import Floats
from intellwheels_experiments.batch.run_store import MIRROR_LOG, StoredRun, read_tum, run_folder
from intellwheels_schemas.messages import Robot, Umbmark

CLOSED: Final = 0.5
"""Metres: a square counts as driven if its end by odometry is this close to its start."""


class Factor(msgspec.Struct, frozen=True, kw_only=True):
    """A calibration factor of a chair; 1 for a chair that matches its data sheet.

    Attributes:
        true: The true value in the runs.
        found: The value that follows from the ends of the squares.
        error: The standard error of `found`, as a mean over the seeds; None with a single seed.
    """

    true: float
    found: float
    error: float | None


class UmbmarkResult(msgspec.Struct, frozen=True, kw_only=True):
    """The UMBmark of a batch.

    Attributes:
        seeds: Number of seeds with a usable run in each direction.
        side: The side of the squares, in m.
        track: The nominal track, in m.
        wheels: E_d, the right wheel's diameter divided by the left wheel's.
        base: E_b, the true track divided by the nominal one.
    """

    seeds: int
    side: float
    track: float
    wheels: Factor
    base: Factor


def umbmark_of(out: Path, runs: Sequence[StoredRun], spec: Umbmark) -> UmbmarkResult | None:
    """Return the UMBmark of a batch.

    A seed counts if in both directions its chair closed the square by its odometry and touched nothing. The result is
    None if no seed counts, as for a chair without encoders.

    Args:
        out: The batch's folder, which has the trajectories and robots of the runs.
        runs: The runs.
        spec: Which rows are the squares, and their side.
    """
    ends = {
        (run.row, run.seed): error
        for run in runs
        if run.row in (spec.left, spec.right) and run.measured is not None and not run.measured.collided
        if (error := _end_error(run_folder(out, run.row, run.seed))) is not None
    }
    seeds = [seed for row, seed in ends if row == spec.left and (spec.right, seed) in ends]
    if not seeds:
        return None
    left, right = (np.array([ends[row, seed] for seed in seeds]) for row in (spec.left, spec.right))
    robot = msgspec.json.decode((run_folder(out, spec.left, seeds[0]) / "robot.json").read_bytes(), type=Robot)
    found = metrics.umbmark(left, right, spec.side, robot.track)
    each = [metrics.umbmark(*pair, spec.side, robot.track) for pair in zip(left[:, None], right[:, None], strict=True)]
    errors = np.std(each, axis=0, ddof=1) / math.sqrt(len(seeds)) if len(seeds) > 1 else (None, None)
    wheels, base = (
        Factor(true=true, found=value, error=None if error is None else float(error))
        for true, value, error in zip((robot.wheel_ratio, robot.track_ratio), found, errors, strict=True)
    )
    return UmbmarkResult(seeds=len(seeds), side=spec.side, track=robot.track, wheels=wheels, base=base)


def _end_error(folder: Path) -> Floats | None:
    """Return the true end of a run minus its end by odometry, float64[2] in m, with x along the start heading.

    It is None if nothing was reported, or if by its odometry the chair did not close the square.
    """
    true, reported = read_tum(folder / "true.tum"), read_tum(folder / "reported.tum")
    if true is None or reported is None or len(true) < 2 or len(reported) < 2:
        return None
    # The mirror of a chair in a laboratory repeats the pose of the tick before as its last one.
    last = -2 if (folder / MIRROR_LOG).exists() else -1
    if float(np.hypot(*(reported[last, 1:3] - reported[0, 1:3]))) > CLOSED:
        return None
    x, y = true[last, 1:3] - reported[last, 1:3]
    cos, sin = math.cos(true[0, 3]), math.sin(true[0, 3])
    return np.array([cos * x + sin * y, cos * y - sin * x])
