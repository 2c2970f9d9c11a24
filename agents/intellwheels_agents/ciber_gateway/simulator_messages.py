"""What clients of the Ciber-Rato simulator get: replies, measures, labs, grids and robots in XML. Pure.

Each message is one datagram that ends with a zero byte, which agents cut off. Numbers have six digits. Agents read a
reply of at most 1024 bytes and measures of at most 4096.

Source:
    The public tools of the simulator (github.com/iris-ua/ciberRatoTools).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple
from xml.sax.saxutils import quoteattr

from intellwheels_agents.ciber_gateway.lab_frame import Lab
from intellwheels_schemas.messages import Place, Robot

LARGEST: Final = 65_507
"""Most bytes of a datagram."""
KINDS: Final = ("collision", "ground", "compass", "obstacle", "beacon", "gps")
"""Sensors that may be sent on request only."""


class Settings(NamedTuple):
    """The parameters that agents are told.

    Attributes:
        sim_time, key_time: Cycles of a run, and of its first phase. Agents may rely on them; nothing ends here.
        requests: Most sensors that an agent may request in a cycle.
        requestable: Kinds of sensors that are sent on request only.
        obstacle_noise: Standard deviation of the value of an obstacle sensor.
    """

    sim_time: int = 1800
    key_time: int = 1350
    requests: int = 4
    requestable: frozenset[str] = frozenset()
    obstacle_noise: float = 0.1


class Leds(NamedTuple):
    """Which LEDs of a robot are on."""

    end: bool = False
    returning: bool = False
    visiting: bool = False


class Readings(NamedTuple):
    """What a robot senses in a cycle; None or nothing where it is not sent.

    Attributes:
        collision: Whether something blocks it.
        compass: Heading, degrees.
        ground: Number of the target it is in, or -1.
        obstacles: Values of the obstacle sensors by number.
        beacons: Direction to each beacon by number, degrees; None where it is not seen.
        gps: Position in the lab, m.
        heard: Numbers of robots, and what they said.
    """

    collision: bool | None = None
    compass: float | None = None
    ground: int | None = None
    obstacles: Sequence[tuple[int, float]] = ()
    beacons: Sequence[tuple[int, float | None]] = ()
    gps: tuple[float, float] | None = None
    heard: Sequence[tuple[int, str]] = ()


REFUSED: Final = b'<Reply Status="Refused"></Reply>\n\0'


def reply(settings: Settings, robot: Robot | None, lab: Lab, period: float) -> bytes:
    """Return the reply to a registration.

    Args:
        settings: The parameters.
        robot: The robot, as the simulator accepted it; None for a viewer.
        lab: The beacons.
        period: Seconds of a cycle.
    """
    one = Robot() if robot is None else robot
    compass, beacon = next(iter(one.compass), None), next(iter(one.beacon), None)
    gps, obstacle = next(iter(one.gps), None), next(iter(one.proximity), None)
    values: list[tuple[str, str]] = [
        ("SimTime", str(settings.sim_time)), ("CycleTime", str(round(1000.0 * period))),
        ("CompassNoise", _number(compass.noise_deg if compass else 0.0)),
        ("BeaconNoise", _number(beacon.noise_deg if beacon else 0.0)),
        ("ObstacleNoise", _number(settings.obstacle_noise)), ("MotorsNoise", _number(100.0 * one.motor_noise)),
        ("KeyTime", str(settings.key_time)), ("GPS", _on(gps is not None)),
        ("GPSLinNoise", _number(gps.noise if gps else 0.0)), ("GPSDirNoise", "0"),
        ("BeaconSensor", _on(beacon is not None)), ("CompassSensor", _on(compass is not None)),
        ("ScoreSensor", "Off"), ("ShowActions", "False"), ("NBeacons", str(len(lab.beacons))),
        ("NRequestsPerCycle", str(settings.requests)),
        *((f"{kind.capitalize()}Requestable", _on(kind in settings.requestable)) for kind in KINDS[:5]),
        ("ObstacleLatency", str(obstacle.latency if obstacle else 0)),
        ("BeaconLatency", str(beacon.latency if beacon else 0)), ("GroundLatency", "0"),
        ("CompassLatency", str(compass.latency if compass else 0)), ("CollisionLatency", "0"),
        ("BeaconAperture", _number(math.radians(beacon.cone_deg) / 2 if beacon else math.pi)),
    ]  # fmt: skip
    return _message(f'<Reply Status="Ok">\n\t<Parameters{_attributes(values)}/>\n</Reply>\n')


def measures(cycle: int, readings: Readings, leds: Leds, *, running: bool) -> bytes:
    """Return the measures of a cycle."""
    sensors: list[tuple[str, str]] = []
    if readings.collision is not None:
        sensors.append(("Collision", "Yes" if readings.collision else "No"))
    if readings.compass is not None:
        sensors.append(("Compass", _number(readings.compass)))
    if readings.ground is not None:
        sensors.append(("Ground", str(readings.ground)))
    lines = [f'\t\t<IRSensor Id="{number}" Value="{_number(value)}"/>\n' for number, value in readings.obstacles]
    lines += [
        f'\t\t<BeaconSensor Id="{number}" Value="{"NotVisible" if value is None else _number(value)}"/>\n'
        for number, value in readings.beacons
    ]
    if readings.gps is not None:
        lines.append(f'\t\t<GPS X="{_number(readings.gps[0])}" Y="{_number(readings.gps[1])}"/>\n')
    lines += [f'\t\t<Message From="{number}">{_cdata(text)}</Message>\n' for number, text in readings.heard]
    return _message(
        f'<Measures Time="{cycle}">\n\t<Sensors{_attributes(sensors)}>\n{"".join(lines)}\t</Sensors>\n'
        f'\t<Leds EndLed="{_on(leds.end)}" ReturningLed="{_on(leds.returning)}" VisitingLed="{_on(leds.visiting)}"/>\n'
        f'\t<Buttons Start="{_on(running)}" Stop="{_on(not running)}"/>\n</Measures>\n'
    )


def robot_shown(
    number: int, name: str, cycle: int, pose: tuple[float, float, float], state: str, *,
    collisions: int, collision: bool, visited: str,
) -> bytes:  # fmt: skip
    """Return a robot for viewers.

    Args:
        number: Its number, from 1.
        name: Its name.
        cycle: The cycle.
        pose: Position in the lab, m, and heading, rad.
        state: Running, Stopped, Waiting, Returning, Finished or Removed.
        collisions: How often something has begun to block it.
        collision: Whether something does.
        visited: A digit for each target, 1 if the robot has visited it.
    """
    x, y, heading = pose
    values = [
        ("Name", name), ("Id", str(number)), ("Time", str(cycle)), ("Score", "0"), ("ArrivalTime", "0"),
        ("ReturningTime", "0"), ("Collisions", str(collisions)), ("Collision", str(collision)),
        ("VisitedMask", visited), ("State", state),
    ]  # fmt: skip
    where = [("X", _number(x)), ("Y", _number(y)), ("Dir", _number(math.degrees(heading)))]
    return _message(f"<Robot{_attributes(values)}>\n\t<Position{_attributes(where)}/>\n</Robot>\n")


def lab_shown(lab: Lab, beacon_height: float) -> bytes:
    """Return a lab for viewers; it may be longer than a datagram."""
    size = [("Height", _number(lab.height)), ("Width", _number(lab.width))]
    lines = [f"<Lab{_attributes([('Name', lab.name), *size])}>"]
    for place in lab.beacons:
        x, y = place.x - lab.west, place.y - lab.south
        lines.append(f"\t<Beacon{_attributes([*_point(x, y), ('Height', _number(beacon_height))])}/>")
    lines += [
        f"\t<Target{_attributes([*_point(target.x, target.y), ('Radius', _number(target.radius))])}/>"
        for target in lab.targets
    ]
    for wall in lab.walls:
        lines.append(f'\t<Wall Height="{_number(wall.height)}">')
        lines += [f"\t\t<Corner{_attributes(_point(x, y))}/>" for x, y in wall.corners]
        lines.append("\t</Wall>")
    return _message("\n".join([*lines, "</Lab>\n"]))


def grid_shown(lab: Lab) -> bytes:
    """Return the grid of starts for viewers."""
    return _message("\n".join(["<Grid>", *(f"\t{_start(place, lab)}" for place in lab.starts), "</Grid>\n"]))


def restart() -> bytes:
    """Return what tells viewers that another lab follows."""
    return _message("<Restart/>")


def _start(place: Place, lab: Lab) -> str:
    where = [*_point(place.x - lab.west, place.y - lab.south), ("Dir", _number(place.heading_deg))]
    return f"<Position{_attributes(where)}/>"


def _point(x: float, y: float) -> list[tuple[str, str]]:
    return [("X", _number(x)), ("Y", _number(y))]


def _attributes(values: Iterable[tuple[str, str]]) -> str:
    return "".join(f" {name}={quoteattr(value)}" for name, value in values)


def _cdata(text: str) -> str:
    return f"<![CDATA[{text.replace(']]>', ']]]]><![CDATA[>')}]]>"


def _number(value: float) -> str:
    text = f"{value:g}"
    return "0" if text == "-0" else text


def _on(value: bool) -> str:
    return "On" if value else "Off"


def _message(text: str) -> bytes:
    return text.encode() + b"\0"
