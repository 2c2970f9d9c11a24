"""The sensors of all bodies: checked at joining, compiled when the bodies change, sampled each tick.

Samples are part of the world's state: one array, which every kind writes its own places of. All else
follows from the declarations, so that rate, latency and noise need no other memory and any
state can be copied, kept and gone on from.

A new kind of sensor is a file here and a line in `KINDS`.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import (
    Bumper,
    Compass,
    Encoders,
    Position,
    Proximity,
    Record,
    Robot,
    Sensors,
    Truth,
)
from intellwheels_schemas.rules import sensors_of
from intellwheels_server.kernels import timetable
from intellwheels_server.kernels.arrays import Floats
from intellwheels_server.kernels.noise import noise_key
from intellwheels_server.sensors.bumper import BumperKind
from intellwheels_server.sensors.compass import CompassKind
from intellwheels_server.sensors.encoders import EncodersKind
from intellwheels_server.sensors.kind import Block, Fitted, Kind, View
from intellwheels_server.sensors.proximity import ProximityKind
from intellwheels_server.sensors.truth import TruthKind

KINDS: dict[type[Record], Kind] = {
    Proximity: ProximityKind(),
    Encoders: EncodersKind(),
    Compass: CompassKind(),
    Bumper: BumperKind(),
    Truth: TruthKind(),
}
"""The kinds that are simulated, by their declaration. Whatever else the contract names is refused at joining."""


def check_sensors(robot: Robot, *, truth: bool) -> None:
    """Refuse a robot whose sensors cannot be simulated here.

    Args:
        robot: The robot as it wants to join; what documents must fulfil (`rules.check_robot`) it does.
        truth: Whether agents may know the truth here.

    Raises:
        RequestRefusedError: With code `field` for a kind that is not simulated yet, `value` for a model
            that is not, `truth`, or `mount` for a real body's sensor that is fixed in the world.
    """
    for name, index, declaration in sensors_of(robot):
        where = f"Robot.{name}[{index}]"
        if isinstance(declaration, Truth) and not truth:
            raise RequestRefusedError("truth", f"{where}: truth sensors are not allowed in this simulation")
        if robot.type == "real" and getattr(declaration, "mount", "body") == "start":
            raise RequestRefusedError("mount", f"{where}.Mount: expected body for a real robot, got 'start'")
        if declaration.source == "real":  # the bridge reads it
            continue
        kind = KINDS.get(type(declaration))
        if kind is None:
            names = ", ".join(known.__name__ for known in KINDS)
            raise RequestRefusedError("field", f"{where}: expected one of {names}; {name} is not simulated yet")
        kind.check(where, declaration, robot)


class _Place(NamedTuple):
    """A sensor, and where its samples are among those of its body."""

    kind: Kind
    declaration: Any
    first: int
    depth: int


@dataclass(frozen=True, slots=True)
class _Fitting:
    """The sensors of one body; all its samples lie together."""

    robot: Robot
    start: Position
    joined: int
    begin: int
    end: int
    places: tuple[_Place, ...]


@dataclass(frozen=True)
class SensorPlan:
    """All sensors of all bodies, compiled.

    Attributes:
        blocks: By kind, what takes their samples.
        fittings: By body, in the order of the state's arrays, where its samples are.
    """

    blocks: tuple[Block, ...]
    fittings: tuple[_Fitting, ...]


def plan_sensors(
    bodies: Sequence[tuple[Robot, Position]],
    seed: str,
    tick: int,
    before: tuple[SensorPlan, Floats] | None,
    arrived: Set[str] = frozenset(),
) -> tuple[SensorPlan, Floats]:
    """Return the sensors of all bodies, ready to be sampled, and room for their samples.

    To be called anew when the bodies or the seed change. Sensors with `Source` real are left out: their
    readings come from the bridge.

    Args:
        bodies: Each body's robot, with its name, and where it joined, in the order of the state's arrays.
            The robots have passed `check_sensors`.
        seed: The run's seed.
        tick: Tick at which sensors that are new take their first sample.
        before: The plan until now and its samples, which bodies that stay go on with; None begins anew.
        arrived: Names of bodies that are new, though one of that name was here before.

    Returns:
        The plan, and its samples, float64[...].
    """
    stayed = {} if before is None else {fitting.robot.name: fitting for fitting in before[0].fittings}
    fittings: list[_Fitting] = []
    kept: list[tuple[_Fitting, _Fitting]] = []
    fitted: dict[Kind, list[tuple[Fitted, list[int]]]] = {}
    size = 0
    for body, (robot, start) in enumerate(bodies):
        old = None if robot.name in arrived else stayed.get(robot.name)
        stays = old is not None and old.robot == robot and old.start == start
        joined = old.joined if old is not None and stays else tick
        begin = size
        places = []
        for _, _, declaration in sensors_of(robot):
            if declaration.source == "real":
                continue
            kind = KINDS[type(declaration)]
            depth = timetable.depth(declaration.every, declaration.latency)
            places.append(_Place(kind, declaration, size - begin, depth))
            row = _row(body, declaration, joined, size, depth, noise_key(seed, str(robot.name), declaration.id))
            fitted.setdefault(kind, []).append((Fitted(body, robot, start, declaration), row))
            size += depth * kind.width
        fittings.append(_Fitting(robot, start, joined, begin, size, tuple(places)))
        if old is not None and stays:
            kept.append((old, fittings[-1]))
    samples = np.zeros(size)
    if before is not None:
        for old, new in kept:
            samples[new.begin : new.end] = before[1][old.begin : old.end]
    return SensorPlan(tuple(_compiled(kind, sensors) for kind, sensors in fitted.items()), tuple(fittings)), samples


def _row(
    body: int, declaration: Any, joined: int, first: int, depth: int, key: tuple[np.uint64, np.uint64]
) -> list[int]:
    row = [0] * timetable.COLUMNS
    row[timetable.BODY] = body
    row[timetable.EVERY] = declaration.every
    row[timetable.LATENCY] = declaration.latency
    row[timetable.JOINED] = joined
    row[timetable.FIRST] = first
    row[timetable.DEPTH] = depth
    row[timetable.KEY0], row[timetable.KEY1] = (int(half.view(np.int64)) for half in key)
    return row


def _compiled(kind: Kind, sensors: list[tuple[Fitted, list[int]]]) -> Block:
    # The sort is stable: bodies stay in order, and so do the sensors of one mount.
    ordered = sorted(
        sensors, key=lambda sensor: (sensor[0].body, getattr(sensor[0].declaration, "mount", "") == "start")
    )
    rows = np.array([row for _, row in ordered], dtype=np.int64)
    return kind.compile([sensor for sensor, _ in ordered], rows)


def sense(plan: SensorPlan, view: View, tick: int, samples: Floats) -> Floats:
    """Return the samples with those that are due at a tick.

    To be called once for every tick, in order, after the bodies have their poses; calling it again at the
    same tick takes the same samples again.

    Args:
        plan: The sensors.
        view: The bodies at that tick.
        tick: The tick.
        samples: Those of the tick before; not changed.
    """
    if not plan.blocks:
        return samples
    samples = samples.copy()
    for block in plan.blocks:
        block.take(tick, view, samples)
    return samples


def readings(plan: SensorPlan, samples: Floats, tick: int, body: int) -> Sensors | None:
    """Return what an agent reads: of each sensor the newest sample that its latency lets through.

    Args:
        plan: The sensors.
        samples: With those of this tick.
        tick: This tick.
        body: Index of the agent's body.

    Returns:
        None when there is no reading, be it that the body has no sensors or that all are still to come.
    """
    fitting = plan.fittings[body]
    if not fitting.places:
        return None
    values = samples[fitting.begin : fitting.end].tolist()
    found: dict[str, list[Record]] = {}
    for kind, declaration, first, depth in fitting.places:
        at, sampled = first, None
        if depth > 1 or declaration.every > 1:
            age = tick - declaration.latency - fitting.joined
            if age < 0:
                continue
            number, rest = divmod(age, declaration.every)
            at += number % depth * kind.width
            late = declaration.latency + rest
            sampled = tick - late if late else None
        reading = kind.reading(declaration, sampled, values[at : at + kind.width])
        if kind.field in found:
            found[kind.field].append(reading)
        else:
            found[kind.field] = [reading]
    if not found:
        return None
    # Each kind makes readings of its own class.
    return Sensors(**{field: tuple(listed) for field, listed in found.items()})  # type: ignore[arg-type]
