"""What sonars hear of the chirps of others."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_schemas.messages import Proximity, Wall
from intellwheels_server.world import State, measures
from intellwheels_server.world.kernels.sonar_echoes import COMB
from tests.server.worlds import box_wall, cart, run, world


def _sonar(sensor_id: str = "s", **fields: Any) -> Proximity:
    known: dict[str, Any] = {
        "x": 0.0, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "cone_deg": 60.0, "max_range": 5.0, "model": "sonar",
    }  # fmt: skip
    return Proximity(id=sensor_id, **{**known, **fields})


def _heard(state: State, agent: str = "a", at: int = 0) -> float | str:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    reading = sensors.proximity[at]
    return reading.status if reading.value is None else reading.value


def _told(distance: float) -> Any:
    return pytest.approx(COMB * round(distance / COMB), abs=1e-12)


def _facing(crosstalk: float, walls: list[Wall] | None = None, **fields: Any) -> State:
    robots = {
        "a": cart(proximity=(_sonar(x=0.5, crosstalk=crosstalk),)),
        "b": cart(4.0, heading=math.pi, proximity=(_sonar(x=0.5, **fields),)),
    }
    return world(robots, walls or [])


def test_chirp_of_a_sonar_that_looks_back_counts_as_half_the_way() -> None:
    assert _heard(_facing(0.0)) == _told(3.0)
    assert _heard(_facing(1.0)) == _told(1.5)
    assert _heard(_facing(1.0), "b") == _told(3.0)
    assert _heard(_facing(1.0, direction_deg=90.0)) == _told(3.0)


def test_chirp_is_not_heard_through_a_wall_nor_of_another_firing_group() -> None:
    assert _heard(_facing(1.0, [box_wall(2.2, -1.0, 2.4, 1.0)])) == _told(1.7)
    # In the first tick group 1 is silent; then the other does not fire again.
    assert _heard(_facing(1.0, every=2, group=1)) == _told(3.0)
    state, _ = run(_facing(1.0, every=2, group=1), 1)
    assert _heard(state) == _told(1.5)


def test_share_of_chirps_that_is_taken_for_an_echo() -> None:
    state = _facing(0.3)
    taken = 0
    for _ in range(400):
        taken += _heard(state) == _told(1.5)
        state, _ = run(state, 1)
    assert taken == pytest.approx(120, abs=37)  # four standard deviations
