"""Odometry: the encoders' counts with the nominal figures, its drift against the closed form, and UMBmark."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from intellwheels_schemas.file_records import Join
from intellwheels_schemas.messages import Encoders, Odometry, OdometryReading
from intellwheels_server.world import Setup, State, apply, begin, measures
from intellwheels_server.world.kernels.arrays import Floats
from tests.every_case import every_case
from tests.server.worlds import ROUNDED, RUN, cart, floor_of, run, world

_FINE: dict[str, Any] = {"encoder_ticks": 1_000_000, "odometry": (Odometry(id="o"),)}


def _told(state: State, agent: str = "a") -> OdometryReading:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    return sensors.odometry[0]


def test_odometry_of_a_chair_as_it_should_be_is_its_way_since_joining() -> None:
    state = world({"a": cart(3.0, 2.0, 1.0, **_FINE)})
    assert (_told(state).x, _told(state).y, _told(state).heading) == (0.0, 0.0, 0.0)
    for power in ((1.0, 1.0), (0.2, 0.7), (-0.5, 0.5), (-1.0, -0.8)):
        state, _ = run(state, 15, {"a": power})
    told = _told(state)
    x, y, heading = state.numbers[:3, 0]
    assert told.heading == pytest.approx(math.remainder(heading - 1.0, math.tau), abs=1e-4)
    c, s = math.cos(1.0), math.sin(1.0)
    assert (3.0 + c * told.x - s * told.y, 2.0 + s * told.x + c * told.y) == pytest.approx((x, y), abs=1e-4)


def test_odometry_moves_by_whole_ticks_of_the_encoders() -> None:
    coarse = {"encoder_ticks": 10, "wheel_diameter": 1.0 / math.pi}
    state = world({"a": cart(odometry=(Odometry(id="o"),), encoders=(Encoders(id="w"),), **coarse)})
    count = 0
    for _ in range(30):
        state, _ = run(state, 1, {"a": (0.33, 0.33)})
        sensors = measures(state, "a").sensors
        assert sensors is not None
        count = sensors.encoders[0].left
        assert _told(state).x == pytest.approx(0.1 * count, abs=1e-12)
    assert count == 5


def test_odometry_errs_as_the_encoders_do_that_it_reads() -> None:
    state = world({"a": cart(encoders=(Encoders(id="w", drift=1e-3),), **_FINE)})
    for _ in range(20):
        state, _ = run(state, 1, {"a": (1.0, 1.0)})
    sensors = measures(state, "a").sensors
    assert sensors is not None
    way = math.pi * 0.35 / 1_000_000
    turned = (sensors.encoders[0].right - sensors.encoders[0].left) * way / 0.5
    assert turned != 0.0
    assert _told(state).heading == pytest.approx(turned, abs=ROUNDED)


def test_sensing_twice_at_a_tick_moves_nothing_on() -> None:
    state = world({"a": cart(encoders=(Encoders(id="w", drift=1e-3),), **_FINE)})
    state, _ = run(state, 5, {"a": (1.0, 0.8)})
    again, _ = apply(state, [Join(agent="b", robot=cart(9.0))])
    assert measures(again, "a") == measures(state, "a")


def _drifted(period: float, metres: float, drift: float, chairs: int) -> Floats:
    """Return where so many chairs think they are after so many metres straight on, float64[chairs, 3]."""
    robot = cart(encoders=(Encoders(id="w", drift=drift),), **_FINE)
    joins = [
        Join(agent=f"a{k}", robot=cart(0.0, 2.0 * k - chairs, encoders=robot.encoders, **_FINE)) for k in range(chairs)
    ]
    state, _ = apply(begin(Setup(floor=floor_of(), period=period), RUN), joins)
    state, _ = run(state, round(metres / period), {f"a{k}": (1.0, 1.0) for k in range(chairs)})
    told = [_told(state, f"a{k}") for k in range(chairs)]
    return np.array([(one.x, one.y, one.heading) for one in told])


@pytest.mark.parametrize("period", [0.25, 0.1])
def test_drift_is_that_of_the_closed_form_whatever_the_tick(period: float) -> None:
    metres, drift, track = 10.0, 1e-5, 0.5
    found = _drifted(period, metres, drift, 2000)
    # Of 2,000 runs, 5 % are three standard errors of a standard deviation.
    assert found[:, 2].std() == pytest.approx(math.sqrt(2 * drift * metres) / track, rel=0.05)
    assert found[:, 1].std() == pytest.approx(math.sqrt(2 * drift * metres**3 / 3) / track, rel=0.05)
    assert abs(found[:, 2].mean()) < 4 * found[:, 2].std() / math.sqrt(2000)


_SIDE, _TRACK = 4.0, 0.5


def _square(side: int, e_d: float, e_b: float) -> tuple[float, float]:
    """Return by how much a chair misses its start by its own odometry after a square, +1 to the left, m.

    Nothing slips and the wheels obey at once, so equal turns of the motors are equal counts: 4 m a leg and a quarter
    turn on the spot by the nominal figures.
    """
    state = world({"a": cart(track=_TRACK, wheel_ratio=e_d, track_ratio=e_b, **_FINE)})
    turn = 0.25 * math.pi * _TRACK / (20 * 0.05)
    for _ in range(4):
        state, _ = run(state, 80, {"a": (1.0, 1.0)})
        state, _ = run(state, 20, {"a": (-side * turn, side * turn)})
    told = _told(state)
    assert math.hypot(told.x, told.y) < 1e-4
    return float(state.numbers[0, 0]) - told.x, float(state.numbers[1, 0]) - told.y


def _umbmark(e_d: float, e_b: float) -> tuple[float, float]:
    """Return (E_d, E_b) as UMBmark finds them.

    Source:
        Borenstein and Feng (1996), equations for a square that is driven both ways; x is along its first leg.
    """
    left, right = _square(1, e_d, e_b), _square(-1, e_d, e_b)
    alpha = (right[0] + left[0]) / (-4.0 * _SIDE)
    beta = (right[0] - left[0]) / (-4.0 * _SIDE)
    radius = (_SIDE / 2.0) / math.sin(beta / 2.0) if beta else math.inf
    found_d = 1.0 if math.isinf(radius) else (radius + _TRACK / 2.0) / (radius - _TRACK / 2.0)
    return found_d, (math.pi / 2.0) / (math.pi / 2.0 - alpha)


@every_case("e_d", [0.997, 0.999, 1.0, 1.003])
@every_case("e_b", [0.99, 1.0, 1.004, 1.01])
def test_umbmark_gives_back_what_was_put_in(e_d: float, e_b: float) -> None:
    assert _umbmark(e_d, e_b) == pytest.approx((e_d, e_b), abs=1e-3)
