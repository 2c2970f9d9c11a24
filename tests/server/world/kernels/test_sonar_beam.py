"""One ping: the probability that a wall echoes, the jitter of an echo, and when a sonar pings."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from intellwheels_server.world.kernels.sonar_beam import FIGURE_COLUMNS, ping_delay, wall_beam
from tests.every_case import every_case
from tests.server.world.sonars import many, readings
from tests.server.worlds import box_wall, cart, run, world

AHEAD = box_wall(2.0, -9.0, 3.0, 9.0)


def _sample(ticks: int, **fields: Any) -> list[float | str]:
    """Return the readings of 64 sonars at a wall 2 m ahead."""
    state = world({"a": cart(proximity=many(**fields))}, [AHEAD], period=0.1)
    found = []
    for _ in range(ticks):
        state, _ = run(state, 1)
        found += readings(state)
    return found


@every_case(
    ("turn", "share", "fields"),
    [
        (17.9, 1.0, {"cone_deg": 60.0}),
        (24.0, 0.5, {"cone_deg": 60.0}),
        (27.0, 0.25, {"cone_deg": 60.0}),
        (14.9, 1.0, {"device": "polaroid-6500", "cone_deg": 30.0}),
        (28.5, 0.5, {"device": "polaroid-6500", "cone_deg": 30.0}),
        (42.1, 0.0, {"device": "polaroid-6500", "cone_deg": 30.0}),
        (16.4, 1.0, {"device": "srf08", "cone_deg": 55.0}),
        (22.0, 0.5, {"device": "srf08", "cone_deg": 55.0}),
        (27.6, 0.0, {"device": "srf08", "cone_deg": 55.0}),
    ],
)
def test_probability_of_a_direct_return_falls_with_the_angle_of_incidence(
    turn: float, share: float, fields: dict[str, Any]
) -> None:
    found = _sample(10, direction_deg=turn, min_range=0.15, **fields)
    heard = sum(value != "none" for value in found)
    # Four standard deviations of 640 draws.
    assert heard == pytest.approx(640 * share, abs=4.0 * math.sqrt(640 * share * (1.0 - share)))


@pytest.mark.parametrize(
    ("step", "fields"),
    [
        (0.00865, {}),
        (346.0 / 49.4e3, {"device": "polaroid-6500", "cone_deg": 30.0}),
    ],
)
def test_jitter_has_steps_of_a_wave_and_the_declared_probabilities(step: float, fields: dict[str, Any]) -> None:
    found = np.array(_sample(10, min_range=0.15, **fields), dtype=np.float64)
    steps = (found - 2.0) / step
    assert np.abs(steps - np.round(steps)).max() < 1e-3  # readings are rounded to 1e-6
    shares = [float((np.round(steps) == k).mean()) for k in (-1, 0, 1)]
    # Four standard deviations of 640 draws; so the variance is half of the square of a step.
    assert shares == pytest.approx([0.25, 0.5, 0.25], abs=4.0 * math.sqrt(0.25 / 640))
    assert float(found.mean()) == pytest.approx(2.0, abs=4.0 * step * math.sqrt(0.5 / 640))


def test_device_of_235_khz_has_short_waves_and_hears_no_wall_beyond_9_degrees() -> None:
    walls = [box_wall(1.0, -9.0, 3.0, 9.0)]
    fields: dict[str, Any] = {"device": "srf235", "cone_deg": 15.0, "min_range": 0.1, "max_range": 1.2}
    for turn, heard in ((7.4, 64), (9.1, 0)):
        state, _ = run(world({"a": cart(proximity=many(direction_deg=turn, **fields))}, walls), 1)
        found = [value for value in readings(state) if not isinstance(value, str)]
        assert len(found) == heard
        assert {round((value - 1.0) * 235e3 / 346.0, 2) for value in found} <= {-1.0, 0.0, 1.0}


def test_sonar_that_hears_all_around_has_no_edge_of_its_beam() -> None:
    figures, schedule = np.zeros((1, FIGURE_COLUMNS)), np.zeros((1, 8), dtype=np.int64)
    figures[0, 2] = figures[0, 3] = math.pi
    assert wall_beam(figures, schedule, 0, 0) == (-1.0, 0.0)


def test_every_second_ping_has_the_other_delay() -> None:
    figures, schedule = np.zeros((1, FIGURE_COLUMNS)), np.zeros((1, 8), dtype=np.int64)
    figures[0, 6:] = 0.01, 0.02
    schedule[0, 1], schedule[0, 3] = 3, 4  # every third tick, from tick 4
    delays = [ping_delay(figures, schedule, 0, tick) for tick in range(12)]
    assert delays == [-1.0, -1.0, -1.0, -1.0, 0.01, -1.0, -1.0, 0.02, -1.0, -1.0, 0.01, -1.0]
