"""The robot document that an agent joins with: a robot file, changed by options that name its fields.

`MotorNoise=0.015` sets a field of the robot, `Compass.NoiseDeg=0.5` sets a field of all its compasses. The names are
those of the contract, so they begin with a capital letter; the options of a mind do not. `Proximity.Device=srf08`
makes all proximity sensors sonars of that device: its beam, its range, its rate, its latency and crosstalk.
Options win.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from intellwheels_agents.options import OptionError
from intellwheels_schemas.defaults import PERIOD
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import check_plain
from intellwheels_schemas.messages import Position, Robot, Role
from intellwheels_schemas.rules import check_robot
from intellwheels_schemas.shapes import shape_of
from intellwheels_schemas.sonar_devices import DEVICES, reading_time, sample_time, ticks_for

DEFAULT_ROBOT = "intellwheels"
"""The robot of a mind that has none of its own."""
OWN_ROBOTS = {name: name for name in ("car", "door", "person", "table")}
"""The robot of each mind that does not drive a wheelchair."""
_NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][-+]?\d+)?")


def default_robot(mind: str) -> str:
    """Return the name of the included robot that a mind drives if no robot is given."""
    return OWN_ROBOTS.get(mind, DEFAULT_ROBOT)


def split_options(given: Mapping[str, str]) -> tuple[dict[str, str], dict[str, str]]:
    """Return the options that set fields of the robot document, and the options of the mind."""
    robot_options = {name: value for name, value in given.items() if name[:1].isupper()}
    return robot_options, {name: value for name, value in given.items() if name not in robot_options}


def fields_of(given: Sequence[str]) -> dict[str, str]:
    """Return the fields of a robot that `--option` sets, by name.

    Raises:
        WireError: One is no field with a value, or comes twice.
    """
    pairs: dict[str, str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals or not name[:1].isupper() or name in pairs:
            raise WireError(
                "value", f"--option: expected FIELD=VALUE, each field of the robot once, got {text!r}", "--option"
            )
        pairs[name] = value
    return pairs


def equipped(robot: Robot, changes: Mapping[str, str]) -> Robot:
    """Return `robot` with changed fields.

    Args:
        robot: A robot document.
        changes: Values by field name, `Field` for the robot or `Kind.Field` for all its sensors of a kind.

    Raises:
        OptionError: The robot has no such field or sensor, or the field cannot have that value.
        WireError: The fields contradict each other.
    """
    if not changes:
        return robot
    plain: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(robot))
    for name, text in changes.items():
        kind, _, field = name.rpartition(".")
        records = plain.get(kind) if kind else [plain]
        if not isinstance(records, list) or not records:
            raise OptionError(f"option {name}: expected a kind of sensor this robot has, got {kind!r}")
        for record in records:
            record[field] = _plain(text)
            if name == "Proximity.Device" and text in DEVICES:
                record.update(_device_fields(text, record, changes))
        try:
            robot = msgspec.convert(plain, Robot)
        except msgspec.ValidationError as error:
            raise OptionError(f"option {name}: {_explained(plain, text, error)}") from None
    if changes.get("Proximity.Device") in DEVICES:
        _check_sonars(robot)
    check_robot(robot)
    return robot


def _check_sonars(robot: Robot) -> None:
    """Refuse options that no sonar of a device can have."""
    for one in robot.proximity:
        if one.model != "sonar":
            raise OptionError(f"option Proximity.Model: expected sonar with Proximity.Device, got '{one.model}'")
        if one.latency < 1:
            raise OptionError(f"option Proximity.Latency: expected at least 1 with Proximity.Device, got {one.latency}")


def _device_fields(name: str, record: Mapping[str, Any], changes: Mapping[str, str]) -> dict[str, Any]:
    """Return the fields of a sonar that follow from its device, without those that an option sets."""
    device = DEVICES[name]

    def number(field: str, otherwise: float) -> float:
        told = _plain(changes.get(f"Proximity.{field}", ""))
        return float(told) if isinstance(told, int | float) else otherwise

    far = number("MaxRange", device.max_range)
    delays = [number(field, record.get(field, 0.0)) for field in ("PingDelay", "SecondPingDelay")]
    fields = {
        "Model": "sonar", "ConeDeg": device.cone_deg, "MinRange": device.min_range, "MaxRange": device.max_range,
        "Crosstalk": 1.0,
        # Of the usual period; a shorter one needs the options.
        "Latency": max(ticks_for(reading_time(far, *delays), PERIOD), record.get("Latency", 0)),
        "Every": max(ticks_for(sample_time(name, far, *delays), PERIOD), record.get("Every", 1)),
    }  # fmt: skip
    return {field: value for field, value in fields.items() if f"Proximity.{field}" not in changes}


def _explained(plain: dict[str, Any], text: str, error: Exception) -> str:
    """Return what is wrong with a robot document: what was expected and what came, without the place."""
    try:
        check_plain(shape_of(Robot), plain, "Robot", strict=True)
    except WireError as wrong:
        return wrong.text.partition(": ")[2]
    return f"expected a value of the robot document, got {text!r}: {error}"


def _plain(text: str) -> Any:
    if text in ("true", "false"):
        return text == "true"
    if _NUMBER.fullmatch(text):
        # 007 and 1e999 are no numbers of JSON: the robot document refuses the text.
        with contextlib.suppress(msgspec.DecodeError):
            return msgspec.json.decode(text)
    return text


def joining(
    robot: Robot,
    *,
    agent: str,
    role: Role,
    instance: str,
    place: str | None,
    barrier: bool | None,
    position: Position | None = None,
) -> Robot:
    """Return the document that an agent joins with.

    Args:
        robot: The body; for the role `mind`, only the fields that a mind may set are used.
        agent: The agent's name.
        role: What joins: a whole agent, a body alone, or the mind of a body that another process provides.
        instance: 16 hex digits, new for each process.
        place: A place of the map to start at; None leaves the choice to the simulator.
        barrier: Whether a lockstep waits for this agent; None keeps the robot's own value.
        position: The pose to start at instead of a place.
    """
    awaited = robot.barrier if barrier is None else barrier
    if role == "mind":
        return Robot(
            name=agent, role=role, instance=instance, barrier=awaited, crew=robot.crew, user_input=robot.user_input
        )
    return msgspec.structs.replace(
        robot,
        format=None,
        name=agent,
        role=role,
        instance=instance,
        place=robot.place if place is None else place,
        position=robot.position if position is None else position,
        barrier=awaited,
    )
