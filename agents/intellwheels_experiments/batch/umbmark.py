"""What squares driven by odometry tell of a chair's wheels, beside what they truly were: UMBmark of a batch's runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import msgspec
import numpy as np

from intellwheels_experiments.batch import metrics
from intellwheels_experiments.batch.metrics import Floats
from intellwheels_experiments.batch.run_store import IMAGE, StoredRun, place_of, read_tum
from intellwheels_schemas.messages import Robot, Umbmark

ROUND: Final = 0.5
"""Metres from its start within which a chair that believes so has come round."""


class Figure(msgspec.Struct, frozen=True, kw_only=True):
    """A figure of a chair, 1 where it is as its data sheet says.

    Attributes:
        true: What it truly was in the runs.
        found: What the ends of the squares tell.
        error: Standard error of that: of the mean over the seeds; None of a single one.
    """

    true: float
    found: float
    error: float | None


class Squares(msgspec.Struct, frozen=True, kw_only=True):
    """UMBmark of a batch.

    Attributes:
        seeds: Seeds with a run each way.
        side: Of the squares, m.
        track: Nominal, m.
        wheels: E_d, the right wheel's diameter over the left one's.
        base: E_b, the true track over the nominal one.
    """

    seeds: int
    side: float
    track: float
    wheels: Figure
    base: Figure


def squares(out: Path, runs: Sequence[StoredRun], asked: Umbmark) -> Squares | None:
    """Return what the squares of a batch tell, over the seeds whose chair came round both ways and touched nothing.

    It is None without any, and of a chair without encoders.

    Args:
        out: The batch's folder, where the runs' trajectories and robots are.
        runs: What came of them.
        asked: Which rows are squares, and how large.
    """
    ends = {
        (run.row, run.seed): off
        for run in runs
        if run.row in (asked.left, asked.right) and run.measured is not None and not run.measured.collided
        if (off := _off(place_of(out, run.row, run.seed))) is not None
    }
    seeds = [seed for row, seed in ends if row == asked.left and (asked.right, seed) in ends]
    if not seeds:
        return None
    left, right = (np.array([ends[row, one] for one in seeds]) for row in (asked.left, asked.right))
    robot = msgspec.json.decode((place_of(out, asked.left, seeds[0]) / "robot.json").read_bytes(), type=Robot)
    found = metrics.umbmark(left, right, asked.side, robot.track)
    each = [metrics.umbmark(*one, asked.side, robot.track) for one in zip(left[:, None], right[:, None], strict=True)]
    errors = np.std(each, axis=0, ddof=1) / math.sqrt(len(seeds)) if len(seeds) > 1 else (None, None)
    wheels, base = (
        Figure(true=true, found=value, error=None if error is None else float(error))
        for true, value, error in zip((robot.wheel_ratio, robot.track_ratio), found, errors, strict=True)
    )
    return Squares(seeds=len(seeds), side=asked.side, track=robot.track, wheels=wheels, base=base)


def _off(place: Path) -> Floats | None:
    """Return where a chair truly ended less where its odometry says, x as it started: float64[2], m.

    It is None where nothing was reported, or not that it came round.
    """
    true, reported = read_tum(place / "true.tum"), read_tum(place / "reported.tum")
    if true is None or reported is None or len(true) < 2 or len(reported) < 2:
        return None
    # A world that shows a chair of a laboratory repeats at its end the pose of the tick before.
    last = -2 if (place / IMAGE).exists() else -1
    if float(np.hypot(*(reported[last, 1:3] - reported[0, 1:3]))) > ROUND:
        return None
    x, y = true[last, 1:3] - reported[last, 1:3]
    cos, sin = math.cos(true[0, 3]), math.sin(true[0, 3])
    return np.array([cos * x + sin * y, cos * y - sin * x])
