"""Rules that span several fields, one function per class. Pure. `decode` and `read_bytes` apply them.

`messages` declares the bounds of each field; this module checks fields against each other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final, NamedTuple, Protocol

from intellwheels_schemas.errors import wrong_value
from intellwheels_schemas.explain import shown, too_long
from intellwheels_schemas.lab_rules import check_lab
from intellwheels_schemas.messages import (
    Actions,
    AgentActions,
    AgentMeasures,
    Body,
    CrewActions,
    CrewJoin,
    CrewJoined,
    CrewLeave,
    CrewMeasures,
    Joined,
    Lab,
    Leave,
    LidarReading,
    Load,
    Map,
    Measures,
    Part,
    Pose,
    Record,
    Robot,
    Say,
    Scene,
    Sensors,
    Source,
    Spawn,
)
from intellwheels_schemas.scene_rules import check_map, check_scene
from intellwheels_schemas.shapes import shape_of

MAX_PARTS: Final = 32
MAX_SENSORS: Final = 64
MAX_RAYS: Final = 1440
MAX_CREW: Final = 250
DEFAULT_TOP: Final = 1.3
"""Default Top of a one-box body, in metres: the height of a seated person."""


class SensorDeclaration(Protocol):
    """The fields that the declarations of all kinds of sensors have."""

    @property
    def id(self) -> str:
        """Id of the sensor, unique in the robot."""

    @property
    def every(self) -> int:
        """Ticks from sample to sample."""

    @property
    def latency(self) -> int:
        """Ticks from sample to reading."""

    @property
    def source(self) -> Source:
        """Source of the samples: the simulator, or the bridge of a real robot."""


class SensorRecords(NamedTuple):
    """The two records of a kind of sensor."""

    declaration: type[Record]
    reading: type[Record]


def _sensor_records() -> dict[str, SensorRecords]:
    readings = {member.name: member.record for member in shape_of(Sensors).members}
    return {
        member.name: SensorRecords(member.record, reading)
        for member in shape_of(Robot).members
        if member.record is not None and (reading := readings.get(member.name)) is not None
    }


SENSOR_RECORDS: Final = _sensor_records()
"""The kinds of sensors: the fields that `Robot` and `Sensors` share, in declaration order, with their records."""

SENSOR_KINDS: Final = tuple(SENSOR_RECORDS)
"""The names of those fields."""

MIND_FIELDS: Final = frozenset({"role", "instance", "barrier", "crew", "user_input", "name"})
"""The only fields that a mind may send if its body belongs to another process."""

FILE_LACKS: Final = ("name", "role", "instance", "place")
"""The fields that a robot file may not have."""


def _wire(cls: type[Record], name: str) -> str:
    return next(member.wire for member in shape_of(cls).members if member.name == name)


# ---------------------------------------------------------------- robots


_SENSOR_WIRES: Final = tuple((kind, _wire(Robot, kind)) for kind in SENSOR_KINDS)


def sensors_of(robot: Robot) -> Iterator[tuple[str, int, SensorDeclaration]]:
    """Yield every declared sensor in declaration order: field name of its kind, index within the kind, declaration."""
    for kind, wire in _SENSOR_WIRES:
        for index, sensor in enumerate(getattr(robot, kind)):
            yield wire, index, sensor


def parts_of(robot: Robot) -> tuple[Part, ...]:
    """Return the boxes of a body in the body frame; none for a mind.

    The one-box form becomes a box whose centre is (0.5 - Center) lengths ahead of the centre of movement, since Center
    counts from the rear edge. Without Center both points coincide.
    """
    if robot.part or robot.length is None or robot.width is None:
        return robot.part
    x = 0.0 if robot.center is None else (0.5 - robot.center) * robot.length
    top = DEFAULT_TOP if robot.top is None else robot.top
    return (Part(x=x, y=0.0, length=robot.length, width=robot.width, bottom=0.0, top=top),)


def has_motors(robot: Robot) -> bool:
    """Return whether the body has motors."""
    return robot.top_speed > 0.0


def is_mobile(robot: Robot) -> bool:
    """Return whether the body can drive: it has motors and is not anchored."""
    return has_motors(robot) and not robot.anchored


def joins_barrier(robot: Robot) -> bool:
    """Return whether a lockstep run waits for the agent. Without Barrier it waits for minds and bodies with motors."""
    if robot.barrier is not None:
        return robot.barrier
    return robot.role == "mind" or has_motors(robot)


def _check_form(robot: Robot, where: str) -> None:
    if robot.format is not None:
        for name in FILE_LACKS:
            value = getattr(robot, name)
            if value is not None and value != "both":
                wire = _wire(Robot, name)
                raise wrong_value(f"{where}.{wire}", f"no {wire} in a file (it has Format)", shown(value), "field")
    if robot.role == "mind":
        for member in shape_of(Robot).members:
            if member.name not in MIND_FIELDS and getattr(robot, member.name) != member.default:
                place = f"{where}.{member.wire}"
                text = "only Name, Role, Instance, Barrier, Crew and UserInput of a mind"
                raise wrong_value(place, text, member.wire, "field")
        return
    one_part = {name: getattr(robot, name) for name in ("length", "width", "center", "top")}
    given = [name for name, value in one_part.items() if value is not None]
    if robot.part and given:
        wire = _wire(Robot, given[0])
        raise wrong_value(f"{where}.{wire}", f"either Part or {wire}", "both", "field")
    if not robot.part:
        for name in ("length", "width"):
            if one_part[name] is None:
                wire = _wire(Robot, name)
                raise wrong_value(f"{where}.{wire}", "Part, or Length and Width", f"no {wire}", "field")


def check_robot(robot: Robot, where: str = "Robot") -> None:
    """Check a robot, in a join or in a file.

    Raises:
        WireError: `field`, `value` or `too-many`.
    """
    _check_form(robot, where)
    for index, part in enumerate(robot.part):
        if not part.bottom < part.top:
            raise wrong_value(f"{where}.Part[{index}].Top", f"more than Bottom {shown(part.bottom)}", shown(part.top))
    ids: set[str] = set()
    sensors = list(sensors_of(robot))
    if len(sensors) > MAX_SENSORS:
        raise too_long(where, MAX_SENSORS, "sensors", len(sensors))
    for kind, index, sensor in sensors:
        place = f"{where}.{kind}[{index}]"
        if sensor.id in ids:
            raise wrong_value(f"{place}.Id", "an id no other sensor has", shown(sensor.id))
        ids.add(sensor.id)
        low, high = getattr(sensor, "min_range", None), getattr(sensor, "max_range", None)
        if low is not None and high is not None and not low < high:
            raise wrong_value(f"{place}.MaxRange", f"more than MinRange {shown(low)}", shown(high))
        if robot.type != "real" and sensor.source == "real":
            raise wrong_value(f"{place}.Source", "simulated for a simulated robot", shown("real"))


# ---------------------------------------------------------------- readings


def _check_lidar(reading: LidarReading, place: str) -> None:
    if len(reading.ranges) != len(reading.statuses):
        raise wrong_value(f"{place}.Statuses", f"as many as Ranges ({len(reading.ranges)})", len(reading.statuses))
    for index, (value, status) in enumerate(zip(reading.ranges, reading.statuses, strict=True)):
        if (value is not None) != (status == "ok"):
            wanted = "a number where Status is ok" if status == "ok" else f"null where Status is {status}"
            raise wrong_value(f"{place}.Ranges[{index}]", wanted, shown(value))


def values_of(reading: type[Record]) -> tuple[tuple[str, str], ...]:
    """Return the fields that a reading has only with `Status` ok, as names in Python and on the wire."""
    members = shape_of(reading).members
    if all(member.name != "status" for member in members):
        return ()
    return tuple(
        (member.name, member.wire)
        for member in members
        if member.name != "tick" and not member.required and member.default is None
    )


_VALUES: Final = {
    field: (_wire(Sensors, field), values)
    for field, records in SENSOR_RECORDS.items()
    if (values := values_of(records.reading))
}


def check_sensors(sensors: Sensors, where: str) -> None:
    """Check readings: a reading must have a value if its status is ok, and only then.

    Raises:
        WireError: `field` or `value`.
    """
    for field, (kind, values) in _VALUES.items():
        for index, reading in enumerate(getattr(sensors, field)):
            for name, wire in values:
                value = getattr(reading, name)
                if (value is not None) != (reading.status == "ok"):
                    _raise_value(f"{where}.{kind}[{index}].{wire}", reading.status, value)
    for index, scan in enumerate(sensors.lidar):
        _check_lidar(scan, f"{where}.Lidar[{index}]")


def _raise_value(place: str, status: str, value: object) -> None:
    wanted = "a value where Status is ok" if status == "ok" else f"no value where Status is {status}"
    raise wrong_value(place, wanted, "nothing" if value is None else shown(value), "field")


def _check_measures(measures: Measures | AgentMeasures, where: str) -> None:
    if measures.sensors is not None:
        check_sensors(measures.sensors, f"{where}.Sensors")


def _check_session(message: Actions | Say | Pose | Leave, where: str) -> None:
    if message.session is None:
        raise wrong_value(f"{where}.Session", "16 lower-case hex digits", "nothing", "field")


def _check_pose(pose: Pose, where: str) -> None:
    _check_session(pose, where)
    if len(pose.covariance) not in {0, 6}:
        raise wrong_value(f"{where}.Covariance", "6 numbers (xx xy xh yy yh hh)", len(pose.covariance))
    if pose.covariance and min(pose.covariance[0], pose.covariance[3], pose.covariance[5]) < 0.0:
        raise wrong_value(f"{where}.Covariance", "xx, yy and hh of at least 0", "a negative one")
    if pose.sensors is not None:
        check_sensors(pose.sensors, f"{where}.Sensors")


def _check_part(message: Any, where: str) -> None:
    if not message.part < message.parts:
        raise wrong_value(f"{where}.Part", f"less than Parts {message.parts}", message.part)


def _check_crew_join(join: CrewJoin, where: str) -> None:
    names: set[str] = set()
    for index, robot in enumerate(join.robot):
        place = f"{where}.Robot[{index}]"
        check_robot(robot, place)
        if robot.name is None:
            raise wrong_value(f"{place}.Name", "the name of an agent", "nothing", "field")
        if robot.name in names:
            raise wrong_value(f"{place}.Name", "each agent once", f"{shown(robot.name)} twice")
        names.add(robot.name)


def _check_crew_joined(joined: CrewJoined, where: str) -> None:
    for index, agent in enumerate(joined.joined):
        check_robot(agent.robot, f"{where}.Joined[{index}].Robot")


def _check_crew_leave(crew: CrewLeave, where: str) -> None:
    for index, leave in enumerate(crew.leave):
        _check_session(leave, f"{where}.Leave[{index}]")


def _check_crew_measures(crew: CrewMeasures, where: str) -> None:
    _check_part(crew, where)
    for index, measures in enumerate(crew.measures):
        _check_measures(measures, f"{where}.Measures[{index}]")


def _check_crew_actions(crew: CrewActions, where: str) -> None:
    _check_part(crew, where)
    names = {actions.agent for actions in crew.actions if actions.session is not None}
    if len(names) == len(crew.actions):
        return  # nearly always, and this is done every tick for many agents
    agents: set[str] = set()
    for index, actions in enumerate(crew.actions):
        if actions.agent in agents:
            raise wrong_value(f"{where}.Actions[{index}].Agent", "each agent once", f"{shown(actions.agent)} twice")
        agents.add(actions.agent)
        _check_session(actions, f"{where}.Actions[{index}]")


# ---------------------------------------------------------------- maps and scenes


def _check_load(load: Load, where: str) -> None:
    if (load.name is None) == (load.map is None):
        raise wrong_value(where, "either Name or Map", "neither" if load.map is None else "both", "field")
    if load.map is not None:
        check_map(load.map, f"{where}.Map")


def _check_spawn(spawn: Spawn, where: str) -> None:
    if spawn.robot.role != "both" or spawn.robot.type == "real":
        raise wrong_value(f"{where}.Robot", "a simulated robot of role both", f"{spawn.robot.type} {spawn.robot.role}")
    check_robot(spawn.robot, f"{where}.Robot")


def _check_joined(joined: Joined, where: str) -> None:
    check_robot(joined.robot, f"{where}.Robot")


def _check_body(body: Body, where: str) -> None:
    check_robot(body.robot, f"{where}.Robot")


_RULES: Final[dict[type[Record], Callable[[Any, str], None]]] = {
    Robot: check_robot,
    Joined: _check_joined,
    Body: _check_body,
    Measures: _check_measures,
    CrewJoin: _check_crew_join,
    CrewJoined: _check_crew_joined,
    CrewLeave: _check_crew_leave,
    CrewMeasures: _check_crew_measures,
    AgentMeasures: _check_measures,
    AgentActions: _check_session,
    CrewActions: _check_crew_actions,
    Actions: _check_session,
    Say: _check_session,
    Leave: _check_session,
    Pose: _check_pose,
    Map: check_map,
    Load: _check_load,
    Spawn: _check_spawn,
    Scene: check_scene,
    Lab: check_lab,
}


def has_rule(cls: type[Record]) -> bool:
    """Return whether a rule spans fields of the messages of a class."""
    return cls in _RULES


def check(message: Record) -> None:
    """Check the rules that span fields of a message.

    Raises:
        WireError: The first rule that is violated.
    """
    rule = _RULES.get(type(message))
    if rule is not None:
        rule(message, shape_of(type(message)).root)
