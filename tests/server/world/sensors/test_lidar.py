"""Lidars: which rays there are, and when they were taken. What they meet is in `kernels/test_scanning.py`."""

from __future__ import annotations

from typing import Any

import pytest

from intellwheels_schemas.messages import Lidar, LidarReading
from intellwheels_server.world import State, measures
from tests.server.worlds import box_wall, cart, run, world


def _lidar(**fields: Any) -> Lidar:
    known: dict[str, Any] = {
        "id": "l", "x": 0.3, "y": 0.1, "z": 0.4, "direction_deg": 20.0, "fov_deg": 270.0, "rays": 61, "max_range": 8.0,
    }  # fmt: skip
    return Lidar(**{**known, **fields})


def _about(*ranges: float | None) -> Any:
    """Return ranges to compare with, of which those that are numbers are exact but for rounding."""
    return tuple(one if one is None else pytest.approx(one, abs=1e-12) for one in ranges)


def _scan(state: State, agent: str = "a") -> LidarReading:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    return sensors.lidar[0]


def test_rays_all_around_are_one_step_apart_and_a_single_ray_looks_ahead() -> None:
    state = world({"a": cart(lidar=(_lidar(fov_deg=360.0, rays=4, direction_deg=0.0),))}, [box_wall(1.3, -1, 2, 1)])
    scan = _scan(state)
    assert (scan.start_deg, scan.step_deg) == (-180.0, 90.0)
    assert scan.ranges == _about(None, None, 1.0, None)
    state = world({"a": cart(lidar=(_lidar(rays=1, direction_deg=0.0),))}, [box_wall(1.3, -1, 2, 1)])
    assert (_scan(state).start_deg, _scan(state).step_deg, _scan(state).ranges) == (0.0, 0.0, _about(1.0))


def test_scan_carries_its_time_when_it_comes_late() -> None:
    state = world({"a": cart(lidar=(_lidar(every=2, latency=3),))})
    state, _ = run(state, 6)
    assert _scan(state).tick == 2
    assert _scan(state).stamp == pytest.approx(0.1)
