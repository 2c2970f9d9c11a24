"""UMBmark of a batch: which runs count, and that it is right where the ends are known in closed form."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from intellwheels_experiments.batch.run_store import StoredRun, run_folder, tum
from intellwheels_experiments.batch.umbmark import umbmark_of
from intellwheels_maps import robot
from intellwheels_schemas.messages import Umbmark
from tests.experiments.runs import stored

ASKED = Umbmark(left="left", right="right", side=4.0)
CHAIR = msgspec.structs.replace(robot("corridor-chair"), wheel_ratio=1.002, track_ratio=1.005)


def end(turn: float, noise: float = 0.0) -> tuple[float, float]:
    """Return where a chair with those wheels ends when its odometry says that it drove the square."""
    x = y = heading = 0.0
    wide = CHAIR.track * CHAIR.track_ratio
    # The mean of its wheels is the nominal one: what they turn leads round a curve.
    curve = 2.0 * (CHAIR.wheel_ratio - 1.0) / (CHAIR.wheel_ratio + 1.0) / wide
    for _side in range(4):
        for _step in range(4000):
            heading += curve * 1e-3
            x, y = x + 1e-3 * math.cos(heading), y + 1e-3 * math.sin(heading)
        heading += turn * math.pi / 2.0 / CHAIR.track_ratio
    return x + noise, y


def write(
    folder: Path,
    row: str,
    seed: str,
    true: tuple[float, float],
    *,
    heading: float = 0.0,
    reported: tuple[float, float] = (0.0, 0.0),
) -> StoredRun:
    target = run_folder(folder, row, seed)
    target.mkdir(parents=True)
    (target / "robot.json").write_bytes(msgspec.json.encode(CHAIR))
    cos, sin = math.cos(heading), math.sin(heading)
    for name, (x, y) in (("true", true), ("reported", reported)):
        poses = np.array([[0.0, 0.0, heading], [cos * x - sin * y, sin * x + cos * y, heading]])
        (target / f"{name}.tum").write_text(tum(np.array([0.0, 1.0]), poses))
    return stored(row, seed)


def test_factors_have_an_error_over_the_seeds_that_have_both_directions(tmp_path: Path) -> None:
    runs = [write(tmp_path, "left", str(seed), end(1.0, 0.01 * seed)) for seed in (-1, 0, 1)]
    runs += [write(tmp_path, "right", str(seed), end(-1.0)) for seed in (-1, 0, 1)]
    runs += [write(tmp_path, "left", "9", (9.0, 9.0)), stored("right", "9", died="on purpose")]
    found = umbmark_of(tmp_path, runs, ASKED)
    assert found is not None
    assert (found.seeds, found.side, found.track) == (3, 4.0, CHAIR.track)
    assert (found.wheels.true, found.base.true) == (1.002, 1.005)
    # The method's own linearisation errs by 2.3e-4 there.
    assert found.wheels.found == pytest.approx(1.002, abs=3e-4)
    assert found.base.found == pytest.approx(1.005, abs=3e-4)
    assert found.base.error is not None
    assert found.wheels.error is not None
    # An end 1 cm off in x turns alpha by 0.01 / 4 / 4: E_b by that over 90 degrees, and a mean of three by sqrt 3 less.
    assert found.base.error == pytest.approx(0.01 / 16.0 / (math.pi / 2.0) / math.sqrt(3.0), rel=0.02)


def test_one_seed_has_no_error_and_one_direction_has_no_result(tmp_path: Path) -> None:
    left = write(tmp_path, "left", "1", end(1.0))
    assert umbmark_of(tmp_path, [left], ASKED) is None
    found = umbmark_of(tmp_path, [left, write(tmp_path, "right", "1", end(-1.0))], ASKED)
    assert found is not None
    assert (found.wheels.error, found.base.error) == (None, None)


@pytest.mark.parametrize("degrees", [90.0, 180.0, -30.0])
def test_squares_may_begin_along_any_direction(tmp_path: Path, degrees: float) -> None:
    runs = [
        write(tmp_path, row, "1", end(turn), heading=math.radians(degrees))
        for row, turn in (("left", 1.0), ("right", -1.0))
    ]
    found = umbmark_of(tmp_path, runs, ASKED)
    assert found is not None
    assert found.wheels.found == pytest.approx(1.002, abs=3e-4)
    assert found.base.found == pytest.approx(1.005, abs=3e-4)


def test_run_with_a_collision_or_an_open_square_does_not_count(tmp_path: Path) -> None:
    runs = [write(tmp_path, row, "1", end(turn)) for row, turn in (("left", 1.0), ("right", -1.0))]
    runs += [write(tmp_path, "right", seed, end(-1.0)) for seed in "23"]
    hit = write(tmp_path, "left", "2", end(1.0))
    assert hit.measured is not None
    runs.append(msgspec.structs.replace(hit, measured=msgspec.structs.replace(hit.measured, collided=True)))
    runs.append(write(tmp_path, "left", "3", (2.0, 1.0), reported=(2.0, 1.0)))
    found = umbmark_of(tmp_path, runs, ASKED)
    assert found is not None
    assert found.seeds == 1


def test_chair_without_odometry_has_no_result(tmp_path: Path) -> None:
    runs = [write(tmp_path, row, "1", end(turn)) for row, turn in (("left", 1.0), ("right", -1.0))]
    (run_folder(tmp_path, "left", "1") / "reported.tum").unlink()
    assert umbmark_of(tmp_path, runs, ASKED) is None
