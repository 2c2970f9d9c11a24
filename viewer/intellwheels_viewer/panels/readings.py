"""Every kind of reading as numbers for people: a group a kind, its unit in the caption, a row a sensor."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, NamedTuple

from intellwheels_schemas.messages import (
    BeaconReading,
    BumperReading,
    CompassReading,
    EncodersReading,
    GPSReading,
    GroundReading,
    IMUReading,
    LidarReading,
    Measures,
    OdometryReading,
    ProximityReading,
    Record,
    Sensors,
    Status,
    TruthReading,
)
from intellwheels_schemas.rules import SENSOR_KINDS, SENSOR_RECORDS
from intellwheels_schemas.shapes import Member, shape_of
from intellwheels_viewer.panels.number_format import decimal, degrees
from intellwheels_viewer.panels.ranges import WORDS, tone


class Row(NamedTuple):
    """A sensor: its id, what it reads, how near that is (a tone or nothing), and the reading's age in ticks."""

    id: str
    text: str
    tone: str = ""
    age: int = 0


class Group(NamedTuple):
    """The sensors of a kind under their caption."""

    caption: str
    rows: tuple[Row, ...]


def groups(measures: Measures) -> list[Group]:
    """Return the readings of an agent by kind, in the order of the contract; kinds without a reading are left out."""
    sensors = measures.sensors
    return [] if sensors is None else list(_groups(sensors, measures.tick))


def _groups(sensors: Sensors, tick: int) -> Iterator[Group]:
    for field in SENSOR_KINDS:
        readings: Sequence[Any] = getattr(sensors, field)
        if readings:
            caption, read = _PANELS.get(field) or (_caption(field), _plain)
            yield Group(caption, tuple(_row(one, read, tick) for one in readings))


def _row(reading: Any, read: Callable[[Any], tuple[str, str]], tick: int) -> Row:
    text, how_near = read(reading)
    return Row(reading.id, text, how_near, 0 if reading.tick is None else max(0, tick - reading.tick))


def _proximity(one: ProximityReading) -> tuple[str, str]:
    if one.value is None:
        return WORDS[one.status], "near" if one.status == "near" else ""
    return decimal(one.value), tone(one.value)


def _lidar(one: LidarReading) -> tuple[str, str]:
    found = [(value, index) for index, value in enumerate(one.ranges) if value is not None]
    if not found:
        return "nothing seen", ""
    value, index = min(found)
    bearing = math.remainder(one.start_deg + index * one.step_deg, 360.0)
    return f"{decimal(value)} at {decimal(bearing, 0)}\u00b0, {len(found)} of {len(one.ranges)} rays", tone(value)


def _encoders(one: EncodersReading) -> tuple[str, str]:
    return f"{decimal(one.left, 0)} and {decimal(one.right, 0)}", ""


def _odometry(one: OdometryReading) -> tuple[str, str]:
    return f"{decimal(one.x)}, {decimal(one.y)}, {degrees(one.heading)}", ""


def _angle(one: CompassReading | BeaconReading) -> tuple[str, str]:
    return (WORDS[one.status] if one.value is None else degrees(one.value)), ""


def _gps(one: GPSReading) -> tuple[str, str]:
    if one.x is None or one.y is None:
        return WORDS[one.status], ""
    return f"{decimal(one.x)}, {decimal(one.y)}", ""


def _imu(one: IMUReading) -> tuple[str, str]:
    return f"{decimal(one.forward)}, {decimal(one.left)}, {degrees(one.turn_rate)}", ""


def _ground(one: GroundReading) -> tuple[str, str]:
    return one.zone or "no zone", ""


def _bumper(one: BumperReading) -> tuple[str, str]:
    return ("touches", "near") if one.value else ("free", "")


def _truth(one: TruthReading) -> tuple[str, str]:
    return f"{decimal(one.x)}, {decimal(one.y)}, {degrees(one.heading)}", ""


def _caption(field: str) -> str:
    """Return the caption of a kind without one of its own: its name, then its values with their units."""
    values = []
    for member in _values(SENSOR_RECORDS[field].reading):
        unit = member.scalar.unit if member.scalar is not None else ""
        values.append(f"{_words(member.name)}, {unit}" if unit not in {"", "1"} else _words(member.name))
    return f"{_words(field)}: {'; '.join(values)}"


def _plain(one: Any) -> tuple[str, str]:
    """Return the values of a reading of a kind without a text of its own, in the order of the contract."""
    status: Status = getattr(one, "status", "ok")
    values = [getattr(one, member.name) for member in _values(type(one))]
    texts = [_value(value) for value in values if value is not None]
    return ", ".join(texts if status == "ok" else [WORDS[status], *texts]) or "nothing", ""


def _values(reading: type[Record]) -> tuple[Member, ...]:
    return tuple(member for member in shape_of(reading).members if member.name not in {"id", "tick", "status"})


def _words(name: str) -> str:
    return name.replace("_", " ")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return f"{len(value)} values"
    return decimal(value, 2 if isinstance(value, float) else 0) if isinstance(value, int | float) else str(value)


_PANELS: Final[dict[str, tuple[str, Callable[[Any], tuple[str, str]]]]] = {
    "proximity": ("proximity, m", _proximity),
    "lidar": ("lidar, nearest, m", _lidar),
    "encoders": ("encoders, ticks left and right", _encoders),
    "odometry": ("odometry: x, y, m; heading, \u00b0", _odometry),
    "compass": ("compass, \u00b0", _angle),
    "gps": ("GPS: x, y, m", _gps),
    "imu": ("IMU: ahead, left, m/s\u00b2; turn, \u00b0/s", _imu),
    "beacon": ("beacon, bearing, \u00b0", _angle),
    "ground": ("ground", _ground),
    "bumper": ("bumper", _bumper),
    "truth": ("truth: x, y, m; heading, \u00b0", _truth),
}
"""Captions and texts that say more than `_caption` and `_plain`, by kind."""
