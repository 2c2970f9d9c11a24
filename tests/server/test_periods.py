"""What a model does depends on simulated time, never on the number of ticks in it: every noise and every limit.

Each experiment runs at one period and returns, by field, what it found, what is right and the tolerance. A field of a
robot, of a sensor or of the setup that no experiment names must be listed below with the reason.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import pytest

from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import (
    GPS,
    IMU,
    Actions,
    Beacon,
    Compass,
    Encoders,
    Lidar,
    Place,
    Proximity,
    Robot,
    Sensors,
)
from intellwheels_schemas.rules import SENSOR_RECORDS
from intellwheels_server.world import Setup, State, advance, apply, measures
from intellwheels_server.world.kernels import rows
from tests.server.worlds import ROUNDED, box_wall, cart, floor_of, run, world

Found = dict[str, tuple[object, object, float]]
"""By field: what came out, what is right, and the absolute tolerance."""

PERIODS = (0.01, 0.02, 0.05, 0.1, 0.2)

SENSOR_FIELDS = {
    **dict.fromkeys(("id", "source", "place", "model", "device"), "names"),
    **dict.fromkeys(("x", "y", "z", "direction_deg", "cone_deg", "mount", "rays", "fov_deg"), "geometry"),
    **dict.fromkeys(("min_range", "max_range", "incidence_deg"), "bounds of one reading"),
    **dict.fromkeys(("every", "latency", "group"), "counted in ticks, as their description says"),
}
"""Fields of sensors without a time, and why."""
TIMELESS = {
    **dict.fromkeys(
        ("Robot.format", "Robot.name", "Robot.type", "Robot.kind", "Robot.role", "Robot.instance"), "names"
    ),
    **dict.fromkeys(("Robot.barrier", "Robot.crew", "Robot.user_input", "Robot.hardware"), "of the service"),
    **dict.fromkeys(("Robot.place", "Robot.position", "Robot.length", "Robot.width", "Robot.center"), "geometry"),
    **dict.fromkeys(("Robot.top", "Robot.part", "Robot.anchored"), "geometry"),
    **dict.fromkeys(("Robot.track", "Robot.wheel_diameter", "Robot.encoder_ticks"), "nominal dimensions"),
    **dict.fromkeys(("Setup.floor", "Setup.seed", "Setup.period", "Setup.truth", "Setup.strict"), "what is run"),
    **dict.fromkeys(("Setup.say_limit", "Setup.say_range", "Setup.say_walls", "Setup.say_loss"), "of one message"),
    "Setup.end": "simulated seconds, compared once a tick",
    "Proximity.crosstalk": "a share of pings, of which one or none is in a tick",
}


def _fields() -> Iterator[str]:
    records: list[type[msgspec.Struct]] = [Robot, Setup, *(records.declaration for records in SENSOR_RECORDS.values())]
    for record in records:
        for field in msgspec.structs.fields(record):
            if record in (Robot, Setup) or field.name not in SENSOR_FIELDS:
                yield f"{record.__name__}.{field.name}"


def _crowd(period: float, robots: dict[str, Robot], seconds: float, power: tuple[float, float]) -> State:
    """Return the world in which robots got one command, that long ago. Nobody is in anybody's way."""
    state = world(period=period, command_timeout=3600.0)
    state, outputs = apply(state, [Join(agent=name, robot=robot) for name, robot in robots.items()])
    assert all(outcome.code == "ok" for outcome in outputs.outcomes)
    state, _ = advance(state, Inputs(actions=dict.fromkeys(robots, Actions(left_motor=power[0], right_motor=power[1]))))
    for _ in range(round(seconds / period) - 1):
        state, _ = advance(state, Inputs())
    return state


def _sensors(state: State, name: str = "a") -> Sensors:
    found = measures(state, name).sensors
    assert found is not None
    return found


# ---------------------------------------------------------------- experiments


def readings(period: float) -> Found:
    """A body at rest reads so often; a wall is 1.5 m ahead, a beacon 4 m."""
    each, ticks = 40, 12
    front: dict[str, Any] = {"x": 0.5, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "max_range": 5.0}
    robot = cart(
        compass=(*(Compass(id=f"c{k}", noise_deg=2.0) for k in range(each)), Compass(id="cs", step_deg=7.0)),
        gps=(*(GPS(id=f"g{k}", noise=0.3) for k in range(each)), GPS(id="gs", x=0.3, step=0.25)),
        imu=tuple(IMU(id=f"i{k}", noise=0.2, turn_noise=0.1) for k in range(each)),
        beacon=(
            *(Beacon(id=f"b{k}", place="p", noise_deg=3.0) for k in range(each)),
            Beacon(id="bs", place="p", step_deg=7.0),
        ),
        lidar=tuple(Lidar(id=f"l{k}", rays=1, fov_deg=1.0, noise=0.05, dropout=0.25, **front) for k in range(each))
        + tuple(Lidar(id=f"m{k}", rays=1, fov_deg=1.0, noise_share=0.02, **front) for k in range(each)),
        proximity=tuple(
            Proximity(id=f"p{k}", cone_deg=10.0, model="infrared", noise_volts=0.01, dropout=0.25, **front)
            for k in range(each)
        ),
    )  # fmt: skip
    floor = floor_of([box_wall(2.0, -1.0, 3.0, 1.0)], [Place(name="p", x=-4.0, y=0.5)])
    state = world({"a": robot}, floor=floor, period=period)
    seen = []
    for _ in range(ticks):
        seen.append(_sensors(state))
        state, _ = run(state, 1)
    count = each * ticks

    def spread(values: list[float | None], right: float) -> tuple[float, float, float]:
        known = [value for value in values if value is not None]
        # Five standard errors: there are dozens of such comparisons.
        return float(np.std(known)), right, 5.0 * right / math.sqrt(2.0 * len(known))

    def share(values: list[float | None]) -> tuple[float, float, float]:
        return values.count(None) / count, 0.25, 5.0 * math.sqrt(0.25 * 0.75 / count)

    ranges = [one.ranges[0] for sensors in seen for one in sensors.lidar[:each]]
    near = [one.value for sensors in seen for one in sensors.proximity]
    bearing = math.atan2(0.5, -4.0)
    return {
        "Compass.noise_deg": spread([one.value for s in seen for one in s.compass[:each]], math.radians(2.0)),
        "GPS.noise": spread([one.x for sensors in seen for one in sensors.gps[:each]], 0.3),
        "IMU.noise": spread([one.left for sensors in seen for one in sensors.imu], 0.2),
        "IMU.turn_noise": spread([one.turn_rate for sensors in seen for one in sensors.imu], 0.1),
        "Beacon.noise_deg": spread(
            [math.remainder((one.value or 0.0) - bearing, 2.0 * math.pi) for s in seen for one in s.beacon[:each]],
            math.radians(3.0),
        ),
        "Lidar.noise": spread(ranges, 0.05),
        "Lidar.dropout": share(ranges),
        "Lidar.noise_share": spread([one.ranges[0] for sensors in seen for one in sensors.lidar[each:]], 0.03),
        # MODEL.md: the voltage is 0.47 V m over the distance, so its noise counts with the square of the distance.
        "Proximity.noise_volts": spread(near, 0.01 * 1.5**2 / 0.47),
        "Proximity.dropout": share(near),
        "Compass.step_deg": (seen[-1].compass[-1].value, 0.0, ROUNDED),
        "GPS.step": (seen[-1].gps[-1].x, 0.25, ROUNDED),
        "Beacon.step_deg": (seen[-1].beacon[-1].value, math.radians(175.0), ROUNDED),
    }  # fmt: skip


def pings(period: float) -> Found:
    """Two sonars, 3 m apart, face each other; one takes the pings of the other, 2 ms and 5 ms later, for its own."""
    # From ping to ping are 50 ms, or 47 by the delays; the last echo is back after 37 ms.
    every, late = math.ceil(0.053 / period - 1e-9), math.ceil(0.037 / period)
    eye: dict[str, Any] = {
        "x": 0.5, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "cone_deg": 20.0, "max_range": 5.0, "model": "sonar",
        "every": every, "latency": late,
    }  # fmt: skip
    own = Proximity(id="s", crosstalk=1.0, ping_delay=0.003, second_ping_delay=0.003, **eye)
    other = Proximity(id="s", ping_delay=0.005, second_ping_delay=0.008, **eye)
    state = world({"a": cart(proximity=(own,)), "b": cart(4.0, heading=math.pi, proximity=(other,))}, period=period)
    state, _ = run(state, late)
    first = _sensors(state).proximity[0].value
    state, _ = run(state, every)
    # Half of the way of sound, at 346 m/s; the jitter is one wave of 40 kHz.
    return {
        "Proximity.ping_delay": (first, 1.5 + 173.0 * 0.002, 0.00865 + ROUNDED),
        "Proximity.second_ping_delay": (
            _sensors(state).proximity[0].value, 1.5 + 173.0 * 0.005, 0.00865 + ROUNDED,
        ),
    }  # fmt: skip


def walks(period: float) -> Found:
    """Biases after two seconds at rest."""
    each, seconds = 200, 2.0
    robot = cart(
        compass=tuple(Compass(id=f"c{k}", walk_deg=2.0) for k in range(each)),
        gps=tuple(GPS(id=f"g{k}", walk=0.3) for k in range(each)),
        imu=tuple(IMU(id=f"i{k}", walk=0.2, turn_walk=0.1) for k in range(each)),
        beacon=tuple(Beacon(id=f"b{k}", place="p", walk_deg=3.0) for k in range(each)),
    )
    state = world({"a": robot}, floor=floor_of((), [Place(name="p", x=4.0, y=0.0)]), period=period)
    state, _ = run(state, round(seconds / period))
    seen = _sensors(state)

    def spread(values: list[float | None], per_root_second: float) -> tuple[float, float, float]:
        right = per_root_second * math.sqrt(seconds)
        return float(np.std([value or 0.0 for value in values])), right, 5.0 * right / math.sqrt(2.0 * each)

    return {
        "Compass.walk_deg": spread([one.value for one in seen.compass], math.radians(2.0)),
        "GPS.walk": spread([one.y for one in seen.gps], 0.3),
        "IMU.walk": spread([one.left for one in seen.imu], 0.2),
        "IMU.turn_walk": spread([one.turn_rate for one in seen.imu], 0.1),
        "Beacon.walk_deg": spread([one.value for one in seen.beacon], math.radians(3.0)),
    }


def quantised_motion(period: float) -> Found:
    """Acceleration and turn rate on a circle, to their steps: 0.75 m/s on a track of 0.5 m is 1 rad/s."""
    state, _ = run(world({"a": cart(imu=(IMU(id="i", step=0.5, turn_step=0.3),))}, period=period), 3, {"a": (0.5, 1.0)})
    one = _sensors(state).imu[0]
    return {"IMU.step": (one.left, 1.0, ROUNDED), "IMU.turn_step": (one.turn_rate, 0.9, ROUNDED)}


def motion(period: float) -> Found:
    """Eight seconds under one command, each body with one figure of its own."""
    lagged = {"acceleration_curve": 0.9}
    robots = {
        "lag": cart(0.0, 0.0, **lagged),
        "top": cart(0.0, 10.0, top_speed=0.7),
        "limit": cart(0.0, 20.0, acceleration_limit=0.3, **lagged),
        "ratio": cart(0.0, 40.0, wheel_ratio=1.02),
        "scale": cart(0.0, 60.0, wheel_scale=1.05),
        "track": cart(0.0, 80.0, track_ratio=1.1),
    }  # fmt: skip
    state = _crowd(period, robots, 8.0, (0.5, 0.5))
    x = {name: float(state.numbers[rows.X, state.body_set.index[name]]) for name in robots}
    heading = {name: float(state.numbers[rows.HEADING, state.body_set.index[name]]) for name in robots}
    tau = -0.05 / math.log(0.9)
    even = (0.5 - 0.3 * tau) / 0.3
    then = 0.3 * even
    limited = 0.5 * then * even + 0.5 * (8.0 - even) + (then - 0.5) * tau * (1.0 - math.exp(-(8.0 - even) / tau))
    spin = _crowd(period, {"turn": cart(turn_limit=0.8), "track": cart(0.0, 9.0, track_ratio=1.1)}, 2.0, (-0.5, 0.5))
    turned = spin.numbers[rows.HEADING, [spin.body_set.index["turn"], spin.body_set.index["track"]]]
    right, left = 2.04 / 2.02, 2.0 / 2.02
    return {
        "Robot.acceleration_curve": (x["lag"], 0.5 * (8.0 - tau * (1.0 - math.exp(-8.0 / tau))), 1e-9),
        "Robot.top_speed": (x["top"], 0.5 * 0.7 * 8.0, 1e-9),
        "Robot.acceleration_limit": (x["limit"], limited, 1e-9),
        "Robot.wheel_ratio": (heading["ratio"], 0.5 * (right - left) / 0.5 * 8.0, 1e-9),
        "Robot.wheel_scale": (x["scale"], 0.5 * 1.05 * 8.0, 1e-9),
        "Robot.turn_limit": (float(turned[0]), 0.8 * 2.0, 1e-9),
        "Robot.track_ratio": (float(turned[1]), 1.0 / (0.5 * 1.1) * 2.0 - 2.0 * math.pi, 1e-9),
    }


@functools.cache
def _noisy_drives(period: float) -> tuple[State, list[float], list[float]]:
    """Return 150 bodies after 15 m at 0.6 m/s with noisy motors and encoders: the world, their y and encoder errors."""
    count = 150
    robots = {
        f"n{k:03}": cart(
            0.0, 3.0 * k, motor_noise=0.03, encoders=(Encoders(id="w", drift=1e-4),), encoder_ticks=100_000
        )
        for k in range(count)
    }
    state = _crowd(period, robots, 25.0, (0.6, 0.6))
    a_tick = math.pi * Robot().wheel_diameter / 100_000
    errors = [
        _sensors(state, name).encoders[0].left * a_tick - float(state.numbers[rows.LEFT_TRAVEL, index])
        for index, name in enumerate(robots)
    ]
    return state, (state.numbers[rows.Y] - 3.0 * np.arange(count)).tolist(), errors


def noisy_motion(period: float) -> Found:
    """Noisy motors lead to where they lead at 50 ms, and as far apart as white noise of that size does."""
    _, y, errors = _noisy_drives(period)
    _, right, _ = _noisy_drives(0.05)
    # A wheel's travel has a variance of s^2 HOLD v for each metre; see MODEL.md for the rest.
    way = 0.03**2 * 0.05 * 0.6
    sd = math.sqrt(2.0 * way * 15.0**3 / 3.0) / 0.5
    assert np.std(y) == pytest.approx(sd, rel=5.0 / math.sqrt(2.0 * len(y)))
    drift = math.sqrt(1e-4 * 15.0)
    # The motion in a tick is one arc, though its curvature changes: at 0.2 s this is worth up to 6 mm of 0.49 m.
    return {
        "Robot.motor_noise": (y, right, 0.02 * sd),
        "Encoders.drift": (float(np.std(errors)), drift, 5.0 * drift / math.sqrt(2.0 * len(errors))),
    }


def pressed(period: float) -> Found:
    """Wheels that press against a wall for two seconds, from rest and after a crash at full speed."""
    walls = [box_wall(0.5, -1.0, 1.0, 1.0), box_wall(2.5, 4.0, 3.0, 6.0)]
    robots = {
        "a": cart(slip=0.25, acceleration_curve=0.9, acceleration_limit=0.5),
        "b": cart(0.0, 5.0, slip=0.25),
        "c": cart(-9.0, 0.0, slip=0.5, acceleration_curve=0.9),
    }
    state = world(robots, [*walls, box_wall(-8.5, -1.0, -8.0, 1.0)], period=period)
    state, _ = run(state, round(4.0 / period), {"a": (1.0, 1.0), "b": (1.0, 1.0), "c": (0.8, 0.8)})
    tau = -0.05 / math.log(0.9)
    even = max(0.0, (0.25 - 0.5 * tau) / 0.5)
    then = 0.5 * even
    limited = 0.5 * then * even + 0.25 * (4.0 - even) + (then - 0.25) * tau * (1.0 - math.exp(-(4.0 - even) / tau))
    free = 0.4 * (4.0 - tau * (1.0 - math.exp(-4.0 / tau)))
    found = [float(state.numbers[rows.LEFT_TRAVEL, state.body_set.index[name]]) for name in robots]
    # `b` drives 2 m and then presses for 2 s.
    return {"Robot.slip": (found, [limited, 2.0 + 0.25 * 2.0, free], 1e-6)}


def silence(period: float) -> Found:
    """Motors obey the last command for so long, and a message takes so long, after the tick that it always takes."""
    robots = {"a": cart(command_timeout=0.4), "b": cart(0.0, 5.0), "c": cart(0.0, -5.0)}
    state = world(robots, period=period, command_timeout=0.8, say_delay=0.6)
    once = Actions(left_motor=0.5, right_motor=0.5)
    state, _ = advance(state, Inputs(actions={"a": once, "b": once, "c": Actions(say="now")}))
    heard = 0.0
    for _ in range(round(1.4 / period)):
        if not heard and any(each.text == "now" for each in measures(state, "a").message):
            heard = state.tick * period
        state, _ = advance(state, Inputs())
    x = [float(state.numbers[rows.X, state.body_set.index[name]]) for name in ("a", "b")]
    return {
        "Robot.command_timeout": (x[0], 0.2, 1e-9),
        "Setup.command_timeout": (x[1], 0.4, 1e-9),
        "Setup.say_delay": (heard - period, 0.6, 1e-9),
    }


EXPERIMENTS: tuple[Callable[[float], Found], ...] = (
    readings, pings, walks, quantised_motion, motion, noisy_motion, pressed, silence,
)  # fmt: skip


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_model_does_not_depend_on_the_period(experiment: Callable[[float], Found], period: float) -> None:
    for field, (found, right, tolerance) in experiment(period).items():
        assert found == pytest.approx(right, abs=tolerance), field


def test_every_noise_and_every_limit_is_swept() -> None:
    swept = [field for experiment in EXPERIMENTS for field in experiment(0.1)]
    lists = {f"Robot.{field}" for field in SENSOR_RECORDS}
    known, fields = [*swept, *TIMELESS, *lists], sorted(_fields())
    assert [field for field in fields if field not in known] == [], "name each in an experiment, or in TIMELESS"
    assert sorted(known) == fields, "each field once"
