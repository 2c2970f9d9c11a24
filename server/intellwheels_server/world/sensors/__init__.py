"""The sensors of all bodies: checked at joining, compiled when the bodies change, sampled each tick.

Samples are part of the world's state: one array, in which every kind has its own places. Everything else
follows from the declarations. So rate, latency and noise need no other memory, and any state can be copied,
saved and continued.

A new kind of sensor is one file in this package: `catalogue` finds it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Map, Position, Record, Robot, Sensors
from intellwheels_schemas.rules import sensors_of
from intellwheels_server.world.kernels import sample_schedule
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.noise import noise_key
from intellwheels_server.world.kernels.rounded_readings import round_readings
from intellwheels_server.world.sensors.catalogue import KINDS
from intellwheels_server.world.sensors.kind import Block, Fitted, Kind, View


def check_sensors(robot: Robot, floor: Map, *, truth: bool, period: float) -> None:
    """Refuse a robot whose sensors cannot be simulated here.

    Args:
        robot: The robot as it wants to join. It has passed `rules.check_robot`.
        floor: The map, for what a sensor names on it.
        truth: Whether this world allows truth sensors.
        period: Simulated time of a tick, s.

    Raises:
        RequestRefusedError: Codes: `value` if values contradict each other, `truth`, `no-place`, or `mount` if a sensor
            of a real body is fixed in the world.
    """
    for name, index, declaration in sensors_of(robot):
        where = f"Robot.{name}[{index}]"
        kind = KINDS[type(declaration)]
        if kind.restricted and not truth:
            raise RequestRefusedError("truth", f"{where}: {kind.field} sensors are not allowed in this simulation")
        if robot.type == "real" and getattr(declaration, "mount", "body") == "start":
            raise RequestRefusedError("mount", f"{where}.Mount: expected body for a real robot, got 'start'")
        kind.check_fields(where, declaration)
        if declaration.source == "real":  # its readings come from the bridge
            continue
        kind.check(where, declaration, floor)
        kind.check_timing(where, declaration, period)


def rays_of(robot: Robot) -> float:
    """Return the rays per tick that the simulated sensors of a robot cost, in rays of a lidar."""
    return sum(
        KINDS[type(declaration)].rays(declaration) / declaration.every
        for _, _, declaration in sensors_of(robot)
        if declaration.source == "simulated"
    )


def reading_bytes_of(robot: Robot) -> int:
    """Return the largest number of bytes of all readings of a robot, in either encoding."""
    return sum(KINDS[type(declaration)].reading_bytes(declaration) for _, _, declaration in sensors_of(robot))


class _Place(NamedTuple):
    """A sensor, how its samples become a reading, and where they are among those of its body."""

    reading: Callable[[Fitted, int | None, Sequence[float]], Record]
    sensor: Fitted
    first: int
    width: int
    depth: int
    every: int
    latency: int
    phase: int


FittedFields = tuple[tuple[str, tuple[_Place, ...]], ...]
"""The sensors of a body, by the field that lists them."""


class _Scheduled(NamedTuple):
    """A sensor with the row of its schedule, in which its first sample is counted from that of its body.

    Attributes:
        kind: Its kind.
        place: Its samples.
        row: The row.
        memory: Numbers that it remembers, behind its samples.
    """

    kind: Kind
    place: _Place
    row: tuple[int, ...]
    memory: int


@dataclass(frozen=True, slots=True)
class _Fitting:
    """The sensors of one body, by the field that lists them, and in order. Its samples are contiguous."""

    robot: Robot
    start: Position
    joined: int
    begin: int
    end: int
    fields: FittedFields
    sensors: tuple[_Scheduled, ...]


@dataclass(frozen=True)
class SensorPlan:
    """All sensors of all bodies, compiled.

    Attributes:
        blocks: The block of each kind, which takes its samples.
        fittings: The sensors and places of samples of each body, in the order of the state's arrays.
        memory: int64[...], the places in the samples that are memory of sensors, ascending.
        spans: int64[sensors, 2], the first place and the end of the samples of each sensor, without its memory.
        seed: The seed of its noise.
        floor: The map.
    """

    blocks: tuple[Block, ...]
    fittings: tuple[_Fitting, ...]
    memory: Ints
    spans: Ints
    seed: str
    floor: Map


def plan_sensors(
    bodies: Sequence[tuple[Robot, Position]],
    seed: str,
    floor: Map,
    tick: int,
    before: tuple[SensorPlan, Floats] | None,
    arrived: Set[str] = frozenset(),
) -> tuple[SensorPlan, Floats]:
    """Return the sensors of all bodies, ready to be sampled, and the array of their samples.

    Call it again when the bodies or the seed change. Sensors with `Source` real are left out: their
    readings come from the bridge.

    Args:
        bodies: The robot of each body, with its name, and its start, in the order of the state's arrays.
            The robots have passed `check_sensors`.
        seed: The run's seed.
        floor: The map.
        tick: Tick at which new sensors take their first sample.
        before: The plan so far and its samples, which bodies that stay keep; None if there is none.
        arrived: Names of bodies that are new, even if a body of the same name was here before.

    Returns:
        The plan, and its samples, float64[...].
    """
    stayed = {} if before is None else {fitting.robot.name: fitting for fitting in before[0].fittings}
    # Only then are the sensors of a body that stays the same as before.
    same = before is not None and before[0].seed == seed and before[0].floor is floor
    fittings: list[_Fitting] = []
    kept: list[tuple[_Fitting, _Fitting]] = []
    fitted: dict[Kind, list[tuple[Fitted, list[int]]]] = {}
    size = 0
    remembered: list[int] = []
    spans: list[tuple[int, int]] = []
    for body, (robot, start) in enumerate(bodies):
        old = None if robot.name in arrived else stayed.get(robot.name)
        stays = old is not None and (old.robot is robot or old.robot == robot) and old.start == start
        joined = old.joined if old is not None and stays else tick
        begin = size
        if old is not None and stays and same:
            sensors = _moved(old.sensors, body)
        else:
            sensors = _fit(body, robot, start, joined, seed, floor)
        fields: dict[str, list[_Place]] = {}
        for one in sensors:
            kind, place = one.kind, one.place
            row = list(one.row)
            row[sample_schedule.FIRST_SAMPLE] = size
            fitted.setdefault(kind, []).append((place.sensor, row))
            spans.append((size, size + place.depth * place.width))
            size += place.depth * place.width
            remembered.extend(range(size, size + one.memory))
            size += one.memory
            fields.setdefault(kind.field, []).append(place)
        listed = tuple((field, tuple(places)) for field, places in fields.items())
        fittings.append(_Fitting(robot, start, joined, begin, size, listed, sensors))
        if old is not None and stays:
            kept.append((old, fittings[-1]))
    samples = np.zeros(size)
    if before is not None:
        for old, new in kept:
            samples[new.begin : new.end] = before[1][old.begin : old.end]
    blocks = tuple(_compiled(kind, sensors) for kind, sensors in fitted.items())
    plan = SensorPlan(
        blocks=blocks,
        fittings=tuple(fittings),
        memory=np.array(remembered, dtype=np.int64),
        spans=np.array(spans, dtype=np.int64).reshape(-1, 2),
        seed=seed,
        floor=floor,
    )
    return plan, samples


def _fit(body: int, robot: Robot, start: Position, joined: int, seed: str, floor: Map) -> tuple[_Scheduled, ...]:
    """Return the simulated sensors of a body."""
    found: list[_Scheduled] = []
    first = 0
    for _, _, declaration in sensors_of(robot):
        if declaration.source == "real":
            continue
        kind = KINDS[type(declaration)]
        sensor = Fitted(body, robot, start, declaration, floor)
        every, latency, phase = declaration.every, declaration.latency, kind.phase(declaration)
        depth, width = sample_schedule.depth(every, latency), kind.width(declaration)
        place = _Place(kind.reading, sensor, first, width, depth, every, latency, phase)
        key = noise_key(seed, str(robot.name), kind.stream(sensor))
        memory = kind.memory(declaration)
        found.append(_Scheduled(kind, place, _row(body, declaration, joined + phase, first, depth, key), memory))
        first += depth * width + memory
    return tuple(found)


def _moved(sensors: tuple[_Scheduled, ...], body: int) -> tuple[_Scheduled, ...]:
    """Return the sensors of a body that stays, at its index now. All else about them is as it was."""
    if not sensors or sensors[0].place.sensor.body == body:
        return sensors
    moved = []
    for one in sensors:
        row = list(one.row)
        row[sample_schedule.BODY] = body
        place = one.place._replace(sensor=one.place.sensor._replace(body=body))
        moved.append(one._replace(place=place, row=tuple(row)))
    return tuple(moved)


def _row(
    body: int, declaration: Any, joined: int, first: int, depth: int, key: tuple[np.uint64, np.uint64]
) -> tuple[int, ...]:
    row = [0] * sample_schedule.SCHEDULE_COLUMNS
    row[sample_schedule.BODY] = body
    row[sample_schedule.EVERY] = declaration.every
    row[sample_schedule.LATENCY] = declaration.latency
    row[sample_schedule.JOINED] = joined
    row[sample_schedule.FIRST_SAMPLE] = first
    row[sample_schedule.DEPTH] = depth
    row[sample_schedule.KEY0], row[sample_schedule.KEY1] = (int(half.view(np.int64)) for half in key)
    return tuple(row)


def _compiled(kind: Kind, sensors: list[tuple[Fitted, list[int]]]) -> Block:
    # The sort is stable: bodies stay in order, and so do the sensors of one mount.
    ordered = sorted(
        sensors, key=lambda sensor: (sensor[0].body, getattr(sensor[0].declaration, "mount", "") == "start")
    )
    rows = np.array([row for _, row in ordered], dtype=np.int64)
    return kind.compile([sensor for sensor, _ in ordered], rows)


def sense(plan: SensorPlan, view: View, tick: int, samples: Floats) -> Floats:
    """Return the samples with those that are due at a tick.

    Call it for every tick, in order, after the bodies have their poses. A second call at the same tick takes
    the same samples again. Samples are rounded to 1e-6; what sensors remember is not.

    Args:
        plan: The sensors.
        view: The bodies at that tick.
        tick: The tick.
        samples: The samples of the tick before; not changed.
    """
    if not plan.blocks:
        return samples
    samples = samples.copy()
    for block in plan.blocks:
        block.take(tick, view, samples)
    round_readings(plan.spans, samples)
    return samples


def readings(plan: SensorPlan, samples: Floats, tick: int, body: int) -> Sensors | None:
    """Return the readings of an agent: for each sensor the newest sample that is at least as old as its latency.

    Args:
        plan: The sensors.
        samples: The samples, including those of this tick.
        tick: This tick.
        body: Index of the agent's body.

    Returns:
        None if there is no reading: the body has no sensors, or none has a reading yet.
    """
    fitting = plan.fittings[body]
    if not fitting.fields:
        return None
    values = samples[fitting.begin : fitting.end].tolist()
    found: dict[str, tuple[Record, ...]] = {}
    for field, places in fitting.fields:
        listed = []
        for reading, sensor, first, width, depth, every, latency, phase in places:
            if depth == 1 and every == 1:
                listed.append(reading(sensor, None, values[first : first + width]))
                continue
            age = tick - latency - fitting.joined - phase
            if age < 0:
                continue
            number, rest = divmod(age, every)
            at, late = first + number % depth * width, latency + rest
            listed.append(reading(sensor, tick - late if late else None, values[at : at + width]))
        if listed:
            found[field] = tuple(listed)
    # Each kind makes readings of its own class.
    return Sensors(**found) if found else None  # type: ignore[arg-type]
