"""Sonars for tests: one with usual fields, what an agent's sonars hear, and what a reading may be."""

from __future__ import annotations

from typing import Any

import pytest

from intellwheels_schemas.messages import Corner, Proximity, Wall
from intellwheels_server.world import State, measures
from tests.server.worlds import run

STEP = 0.00865
"""A wave of 40 kHz, m."""


def sonar(sensor_id: str = "s", **fields: Any) -> Proximity:
    """Return a sonar in the middle of its body that looks ahead."""
    known: dict[str, Any] = {
        "x": 0.0, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "cone_deg": 60.0, "max_range": 5.0, "model": "sonar",
        "latency": 1,
    }  # fmt: skip
    return Proximity(id=sensor_id, **{**known, **fields})


def many(count: int = 64, **fields: Any) -> tuple[Proximity, ...]:
    """Return sonars that differ in their noise only."""
    return tuple(sonar(f"s{k}", **fields) for k in range(count))


def readings(state: State, agent: str = "a") -> list[float | str]:
    """Return what the sonars of an agent have just reported: a distance, or the status if there is none."""
    sensors = measures(state, agent).sensors
    assert sensors is not None
    return [reading.status if reading.value is None else reading.value for reading in sensors.proximity]


def heard(state: State, agent: str = "a", at: int = 0, latency: int = 1) -> float | str:
    """Return what a sonar hears from where everything is now: it reports it so many ticks later."""
    after, _ = run(state, latency)
    return readings(after, agent)[at]


def told(distance: float) -> Any:
    """Return what equals the readings of a distance: exact, or a wave too short or too long."""
    return pytest.approx(distance, abs=STEP + 1e-6)


def solid(*corners: tuple[float, float]) -> Wall:
    """Return a solid wall with these corners."""
    return Wall(corner=tuple(Corner(x=x, y=y) for x, y in corners))
