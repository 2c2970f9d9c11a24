"""All sensor readings as text: a group for each kind of sensor with its units in the caption, a row for each sensor.

A kind without a reader in `_READERS` is shown by the fields and the units that its record declares, so a new sensor
needs no change here.
"""

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
    TruthReading,
)
from intellwheels_schemas.shapes import Member, shape_of
from intellwheels_viewer.panels.number_format import decimal, degrees
from intellwheels_viewer.panels.ranges import WORDS, tone

LIST_LIMIT: Final = 6
"""Values of a list that a generic row shows; of a longer list it shows the length."""
_COMMON: Final = frozenset({"id", "tick", "stamp", "status"})
"""Fields of any reading that are not measured values."""


class Row(NamedTuple):
    """A sensor: its id, its reading as text, the tone of its range (or nothing), and the reading's age in ticks."""

    id: str
    text: str
    tone: str = ""
    age: int = 0


class Group(NamedTuple):
    """The sensors of one kind: its name in the contract, its caption, and a row for each sensor."""

    kind: str
    caption: str
    rows: tuple[Row, ...]


def groups(measures: Measures) -> list[Group]:
    """Return the readings of an agent by kind, in the order of the contract. Kinds without a reading are left out."""
    sensors = measures.sensors
    return [] if sensors is None else list(_groups(sensors, measures.tick))


def _groups(sensors: Sensors, tick: int) -> Iterator[Group]:
    for field in sensors.__struct_fields__:
        readings: Sequence[Any] = getattr(sensors, field)
        if readings:
            caption, read = _READERS.get(field) or (_caption(field, type(readings[0])), _generic)
            yield Group(field, caption, tuple(_row(one, read, tick) for one in readings))


def _row(reading: Any, read: Callable[[Any], tuple[str, str]], tick: int) -> Row:
    text, how_near = read(reading)
    return Row(reading.id, text, how_near, 0 if reading.tick is None else max(0, tick - reading.tick))


# ---------------------------------------------------------------- a kind that is not known here


def _values(kind: type[Record]) -> list[Member]:
    return [member for member in shape_of(kind).members if member.name not in _COMMON]


def _caption(field: str, kind: type[Record]) -> str:
    """Return the name of a kind and of its values, each with its unit."""
    names = []
    for member in _values(kind):
        unit = (
            ""
            if member.scalar is None
            else {"rad": "\u00b0", "deg": "\u00b0"}.get(member.scalar.unit, member.scalar.unit)
        )
        names.append(f"{_spaced(member.name)}, {unit}" if unit not in ("", "1") else _spaced(member.name))
    return f"{_spaced(field)}: {'; '.join(names)}" if names else _spaced(field)


def _spaced(field: str) -> str:
    return field.replace("_", " ")


def _generic(reading: Record) -> tuple[str, str]:
    status = getattr(reading, "status", "ok")
    if status != "ok":
        return WORDS[status] if status in WORDS else str(status), ""
    values = (_text(getattr(reading, member.name), _unit(member)) for member in _values(type(reading)))
    return ", ".join(values), ""


def _unit(member: Member) -> str:
    return "" if member.scalar is None else member.scalar.unit


def _text(value: object, unit: str) -> str:
    match value:
        case None:
            return "\u2013"
        case bool():
            return "yes" if value else "no"
        case int() | float():
            if unit in ("rad", "rad/s"):
                return degrees(value)
            return decimal(value, 0 if isinstance(value, int) or unit == "deg" else 2)
        case tuple():
            if len(value) > LIST_LIMIT:
                return f"{len(value)} values"
            return f"[{' '.join(_text(each, unit) for each in value)}]"
        case _:
            return str(value)


# ---------------------------------------------------------------- the kinds of the contract


def _proximity(one: ProximityReading) -> tuple[str, str]:
    if one.value is None:
        return WORDS[one.status], "near" if one.status == "near" else ""
    return decimal(one.value), tone(one.value)


def _lidar(one: LidarReading) -> tuple[str, str]:
    found = [(value, index) for index, value in enumerate(one.ranges) if value is not None]
    if not found:
        return WORDS["none"], ""
    value, index = min(found)
    bearing = math.remainder(one.start_deg + index * one.step_deg, 360.0)
    return f"{decimal(value)} at {decimal(bearing, 0)}\u00b0, {len(found)} of {len(one.ranges)} rays", tone(value)


def _encoders(one: EncodersReading) -> tuple[str, str]:
    return f"{decimal(one.left, 0)} and {decimal(one.right, 0)}", ""


def _pose(one: OdometryReading | TruthReading) -> tuple[str, str]:
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
    return ("touching", "near") if one.value else ("free", "")


_READERS: Final[dict[str, tuple[str, Callable[[Any], tuple[str, str]]]]] = {
    "proximity": ("proximity, m", _proximity),
    "lidar": ("lidar, nearest, m", _lidar),
    "encoders": ("encoders, ticks left and right", _encoders),
    "odometry": ("odometry: x, y, m; heading, \u00b0", _pose),
    "compass": ("compass, \u00b0", _angle),
    "gps": ("GPS: x, y, m", _gps),
    "imu": ("IMU: forward, left, m/s\u00b2; turn, \u00b0/s", _imu),
    "beacon": ("beacon, bearing, \u00b0", _angle),
    "ground": ("ground", _ground),
    "bumper": ("bumper", _bumper),
    "truth": ("truth: x, y, m; heading, \u00b0", _pose),
}
"""Captions and readers by field of `Sensors`, for kinds that need more than their fields."""
