"""Scans become points in the body's frame, of the tick at which they were taken."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_agents.navigation.scan_points import ScanPoints, into_body, into_map, thinned
from intellwheels_schemas.messages import Lidar, LidarReading, Measures, Robot, Sensors
from tests.agents.kinematics import RUN

LIDAR = Lidar(id="scan", x=0.5, y=0.0, z=0.3, direction_deg=0.0, fov_deg=180.0, rays=3, min_range=0.1, max_range=8.0)


def measured(reading: LidarReading) -> Measures:
    return Measures(run=RUN, tick=9, time=0.45, sensors=Sensors(lidar=(reading,)))


def test_ranges_become_points_and_what_failed_does_not() -> None:
    scan = ScanPoints(Robot(lidar=(LIDAR,)))
    reading = LidarReading(
        id="scan", tick=7, start_deg=-90.0, step_deg=90.0, ranges=(2.0, None, None), statuses=("ok", "none", "near")
    )
    ((tick, points),) = scan.update(measured(reading))
    assert tick == 7
    assert points == pytest.approx(np.array([[0.5, -2.0], [0.5, 0.05]]), abs=1e-12)


def test_scanner_at_the_start_pose_does_not_count() -> None:
    import msgspec

    scan = ScanPoints(Robot(lidar=(msgspec.structs.replace(LIDAR, mount="start"),)))
    assert scan.update(measured(LidarReading(id="scan", start_deg=0.0, step_deg=1.0, ranges=(1.0,)))) == []


def test_points_move_between_body_and_map() -> None:
    points = np.array([[1.0, 0.0], [0.0, 2.0]])
    pose = (3.0, 4.0, math.pi / 2.0)
    assert into_map(points, pose) == pytest.approx(np.array([[3.0, 5.0], [1.0, 4.0]]))
    assert into_body(into_map(points, pose), pose) == pytest.approx(points, abs=1e-12)


def test_a_cell_keeps_one_point() -> None:
    points = np.array([[0.01, 0.01], [0.02, 0.02], [0.30, 0.01]])
    assert thinned(points) == pytest.approx(points[[0, 2]])
    assert thinned(np.zeros((0, 2))).shape == (0, 2)
