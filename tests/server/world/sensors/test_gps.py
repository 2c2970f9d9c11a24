"""Positioning: a point of the body on the map, with noise, a walking bias and steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_schemas.messages import GPS
from intellwheels_server.world import State, measures
from tests.server.worlds import cart, run, world


def _fix(state: State, at: int = 0) -> tuple[float, float]:
    sensors = measures(state, "a").sensors
    assert sensors is not None
    x, y = sensors.gps[at].x, sensors.gps[at].y
    assert x is not None
    assert y is not None
    return x, y


def test_fix_is_where_the_point_of_the_body_is() -> None:
    state = world({"a": cart(3.0, 2.0, math.pi / 2, gps=(GPS(id="g", x=0.5, y=0.2), GPS(id="h")))})
    assert _fix(state) == pytest.approx((2.8, 2.5), abs=1e-12)
    assert _fix(state, 1) == (3.0, 2.0)


def test_noise_is_gaussian_and_independent_on_both_axes() -> None:
    state = world({"a": cart(gps=tuple(GPS(id=f"g{k}", noise=0.5) for k in range(60)))})
    found = []
    for _ in range(20):
        found += [_fix(state, k) for k in range(60)]
        state, _ = run(state, 1)
    # Four standard errors of 1200 draws.
    assert np.std(found, axis=0) == pytest.approx([0.5, 0.5], rel=0.085)
    assert abs(float(np.corrcoef(np.array(found).T)[0, 1])) < 4 / math.sqrt(1200)


def test_steps_round_to_the_nearest_and_stay_in_the_world() -> None:
    state = world({"a": cart(3.26, 2.24, gps=(GPS(id="g", step=0.5), GPS(id="h", step=3.7, noise=1000.0)))})
    assert _fix(state) == (3.5, 2.0)
    assert max(map(abs, _fix(state, 1))) <= 10_000.0


def test_bias_stays_from_fix_to_fix_while_noise_does_not() -> None:
    state = world({"a": cart(gps=(GPS(id="g", walk=1.0, every=4),))})
    assert _fix(state) == (0.0, 0.0)
    state, _ = run(state, 4)
    assert _fix(state) != (0.0, 0.0)
    state, _ = run(state, 400)
    first = _fix(state)
    state, _ = run(state, 4)
    assert 0.0 < math.dist(first, _fix(state)) < 4 * math.sqrt(2 * 0.2)
