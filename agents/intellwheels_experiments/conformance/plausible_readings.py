"""Plausible readings for the sensors of any robot. They change from tick to tick, so that a program must react."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

from intellwheels_schemas.messages import (
    BumperReading,
    CompassReading,
    EncodersReading,
    GPSReading,
    IMUReading,
    Lidar,
    LidarReading,
    OdometryReading,
    Proximity,
    ProximityReading,
    Record,
    Robot,
    Sensors,
    Status,
    TruthReading,
)
from intellwheels_schemas.rules import SENSOR_RECORDS
from intellwheels_schemas.shapes import Form, Member, shape_of

_RAYS = 9
_OK: Final[Status] = "ok"


def readings(robot: Robot, tick: int) -> Sensors | None:
    """Return a reading of every sensor of `robot` at `tick`, or None when it has none."""
    made: dict[str, Any] = {}
    for field, records in SENSOR_RECORDS.items():
        maker = _MAKERS.get(field)
        made[field] = tuple(
            _plain(records.reading, one.id, tick) if maker is None else maker(one, tick, place)
            for place, one in enumerate(getattr(robot, field))
        )
    sensors = Sensors(**made)
    return sensors if sensors != Sensors() else None


def _plain(reading: type[Record], name: str, tick: int) -> Record:
    """Return a reading of a kind that has no function here: its required fields, with numbers that vary in their range.

    A reading with a status needs no value, because the status says that there is none.
    """
    share = 0.5 + 0.4 * math.sin(0.1 * tick)
    values: dict[str, Any] = {"id": name}
    for member in shape_of(reading).members:
        if member.name == "status":
            values["status"] = "none"
        elif member.required and member.name != "id":
            values[member.name] = _value_of(member, share)
    return reading(**values)


def _value_of(member: Member, share: float) -> Any:
    """Return a value for a field: a number at a share of its range, an empty list, or one of its allowed words.

    Raises:
        TypeError: The field is a record or a text with a pattern. Its kind needs a function here.
    """
    if member.form in {Form.LIST, Form.RECORDS}:
        return ()
    scalar = member.scalar
    if scalar is None or (scalar.kind == "text" and scalar.pattern is not None):
        raise TypeError(f"{member.wire}: expected a number, a truth value or a word, got another type")
    if scalar.kind == "truth":
        return share > 0.5
    if scalar.kind == "word":
        return scalar.words[0]
    if scalar.kind == "text":
        return ""
    low = -1000.0 if scalar.low is None else max(scalar.low, -1000.0)
    high = 1000.0 if scalar.high is None else min(scalar.high, 1000.0)
    value = low + share * (high - low)
    return int(value) if scalar.kind == "integer" else value


def _proximity(sensor: Proximity, tick: int, place: int) -> ProximityReading:
    """Return a distance that goes up and down within the sensor's range, and now and then a status without distance."""
    phase = tick + 3 * place
    if phase % 7 == 5:
        return ProximityReading(id=sensor.id, status="none")
    if phase % 7 == 6:
        return ProximityReading(id=sensor.id, status="near")
    share = 0.5 + 0.4 * math.sin(phase)
    return ProximityReading(id=sensor.id, value=sensor.min_range + share * (sensor.max_range - sensor.min_range))


def _lidar(sensor: Lidar, _tick: int, _place: int) -> LidarReading:
    return LidarReading(
        id=sensor.id,
        start_deg=-90.0,
        step_deg=180.0 / (_RAYS - 1),
        ranges=(None, *(1.0 + 0.1 * ray for ray in range(1, _RAYS))),
        statuses=("none", *(_OK for _ in range(1, _RAYS))),
    )


def _turn(tick: int) -> float:
    """Return a heading that turns slowly, rad."""
    return 0.01 * (tick % 100)


def _way(tick: int) -> float:
    """Return a distance that grows steadily, m."""
    return 0.02 * tick


_MAKERS: Final[dict[str, Callable[[Any, int, int], Record]]] = {
    "proximity": _proximity,
    "lidar": _lidar,
    "encoders": lambda one, tick, _: EncodersReading(id=one.id, left=17 * tick, right=16 * tick),
    "odometry": lambda one, tick, _: OdometryReading(id=one.id, x=_way(tick), y=0.0, heading=_turn(tick)),
    "compass": lambda one, tick, _: CompassReading(id=one.id, value=_turn(tick)),
    "gps": lambda one, tick, _: GPSReading(id=one.id, x=2.0 + _way(tick), y=2.0),
    "imu": lambda one, _tick, _: IMUReading(id=one.id, forward=0.0, left=0.0, turn_rate=0.01),
    "bumper": lambda one, tick, _: BumperReading(id=one.id, value=tick % 10 == 9),
    "truth": lambda one, tick, _: TruthReading(
        id=one.id, x=2.0 + _way(tick), y=2.0, heading=_turn(tick), speed=0.4, turn_rate=0.0
    ),
}
"""Functions for kinds that `_plain` cannot imitate. Each takes a sensor, a tick and the sensor's index."""
