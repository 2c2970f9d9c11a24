from __future__ import annotations

import math
import random

import pytest

from intellwheels_agents.bridge.hardware_driver import Fix
from intellwheels_agents.bridge.pose_estimate import PoseEstimate, wheel_geometry
from intellwheels_maps import robot
from intellwheels_schemas.messages import Position

ORIGIN = Position(x=0.0, y=0.0, heading=0.0)
CHAIR = robot("intellwheels")
B = CHAIR.track


def driven(k: float, cuts: int, left: float = 10.0, right: float = 10.0) -> PoseEstimate:
    estimate = PoseEstimate(ORIGIN, k)
    for _ in range(cuts):
        estimate.predict(left / cuts, right / cuts, B)
    return estimate


@pytest.mark.parametrize("cuts", [1, 7, 400])
def test_quarter_turn_does_not_depend_on_how_it_is_cut(cuts: int) -> None:
    r = 2.0
    arc = math.pi / 2.0
    estimate = driven(0.0, cuts, (r - B / 2.0) * arc, (r + B / 2.0) * arc)
    assert (estimate.x, estimate.y, estimate.heading) == pytest.approx((r, r, arc), abs=1e-12)


def test_covariance_of_a_straight_path_is_the_closed_form() -> None:
    k, length = 1e-4, 10.0
    xx, _, _, yy, yh, hh = driven(k, 2000).covariance
    assert hh == pytest.approx(2 * k * length / B**2, rel=1e-12)
    # Cut into 2000 the sum is off by a thousandth of the integral.
    assert yy == pytest.approx(2 * k * length**3 / (3 * B**2), rel=1e-2)
    assert xx == pytest.approx(k * length / 2.0, rel=1e-12)
    assert yh == pytest.approx(k * length**2 / B**2, rel=1e-2)


def test_covariance_matches_a_monte_carlo_simulation() -> None:
    k, steps = 1e-3, 60
    rng = random.Random(4)
    ways = [(0.05, 0.05 + 0.02 * math.sin(i / 9.0)) for i in range(steps)]
    estimate = PoseEstimate(ORIGIN, k)
    for left, right in ways:
        estimate.predict(left, right, B)
    ends = []
    for _ in range(1500):
        one = PoseEstimate(ORIGIN, 0.0)
        for left, right in ways:
            one.predict(rng.gauss(left, math.sqrt(k * left)), rng.gauss(right, math.sqrt(k * right)), B)
        ends.append((one.x - estimate.x, one.y - estimate.y, one.heading - estimate.heading))
    seen = [sum(e[i] * e[j] for e in ends) / len(ends) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
    scale = [estimate.covariance[i] ** 0.5 for i in (0, 3, 5)]
    for (i, j), value, told in zip(
        ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)), seen, estimate.covariance, strict=True
    ):
        # 1500 runs: a variance is known to 3.7 %; four times that, and the filter is linear only near the way.
        assert value == pytest.approx(told, abs=0.15 * scale[i] * scale[j])


def test_a_fix_corrects_the_pose_and_reduces_the_covariance() -> None:
    estimate = driven(1e-3, 100)
    before = estimate.covariance
    estimate.update(Fix(10.0, 0.5, 0.01))
    assert estimate.y == pytest.approx(0.5, abs=0.01)
    assert estimate.heading == pytest.approx(0.075, abs=0.01)  # 1.5 y / x, as drift bends a way
    after = estimate.covariance
    assert all(after[i] < before[i] for i in (0, 3, 5))
    assert after[3] == pytest.approx(1e-4, rel=0.05)


def test_a_fix_of_a_point_off_the_centre_places_that_point() -> None:
    estimate = PoseEstimate(Position(x=1.0, y=2.0, heading=math.pi / 2.0), 0.0, (1.0, 0.0, 0.0, 1.0, 0.0, 1e-6))
    estimate.update(Fix(1.0, 2.5, 1e-3, offset_x=0.5))
    assert (estimate.x, estimate.y) == pytest.approx((1.0, 2.0), abs=1e-5)


def test_fixes_correct_the_drift_of_unequal_wheels() -> None:
    """0.2 % over 15 m: raw is 0.37 m aside, with a position right to 5 cm every metre it is within 10 cm."""
    figures, rng = wheel_geometry(CHAIR), random.Random(2)
    raw, corrected = PoseEstimate(ORIGIN, 1e-5), PoseEstimate(ORIGIN, 1e-5)
    for step in range(1, 301):
        for estimate in (raw, corrected):
            # The chair goes straight; its right wheel is smaller and counts more.
            estimate.predict(0.05, 0.05 * 1.002, figures.track)
        if step % 20 == 0:
            corrected.update(Fix(rng.gauss(0.05 * step, 0.05), rng.gauss(0.0, 0.05), 0.05))
    assert raw.y == pytest.approx(0.002 / B * 15.0**2 / 2.0, rel=0.01)
    assert abs(corrected.y) < 0.1
    assert abs(corrected.y) < 3.0 * corrected.covariance[3] ** 0.5


def test_wheel_geometry_follows_umbmark() -> None:
    plain, found = wheel_geometry(CHAIR), wheel_geometry(CHAIR, ratio=1.002, scale=0.99, track_ratio=1.01)
    assert found.right / found.left == pytest.approx(1.002, rel=1e-12)
    assert (found.left + found.right) / 2.0 == pytest.approx(0.99 * plain.left, rel=1e-12)
    assert found.track == pytest.approx(1.01 * CHAIR.track)
