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


class _Part(NamedTuple):
    """The sensors of one kind on a body.

    Attributes:
        kind: The kind.
        piece: What `Kind.piece` made of them.
        rows: int64[sensors, 8], their schedule. The body is 0, and first samples are counted from those of the body.
    """

    kind: Kind
    piece: Any
    rows: Ints


class _Own(NamedTuple):
    """The simulated sensors of one body. Nothing in it depends on other bodies, so it is made once.

    Attributes:
        size: Numbers of their samples and memories.
        fields: The sensors, by the field that lists them.
        parts: The sensors, by kind.
        spans: int64[sensors, 2], the first place and the end of the samples of each sensor, without its memory.
        memory: int64[...], the places that are memory of sensors, ascending.
    """

    size: int
    fields: FittedFields
    parts: tuple[_Part, ...]
    spans: Ints
    memory: Ints


@dataclass(frozen=True, slots=True)
class _Fitting:
    """The sensors of one body, and the places of its samples, which are contiguous."""

    robot: Robot
    start: Position
    joined: int
    begin: int
    end: int
    fields: FittedFields
    own: _Own


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
    parts: dict[Kind, list[tuple[int, int, _Part]]] = {}
    size = 0
    for body, (robot, start) in enumerate(bodies):
        old = None if robot.name in arrived else stayed.get(robot.name)
        if old is not None and not (old.start == start and (old.robot is robot or old.robot == robot)):
            old = None
        joined = tick if old is None else old.joined
        own = old.own if old is not None and same else _fit(robot, start, joined, seed, floor)
        fitting = _Fitting(robot, start, joined, size, size + own.size, own.fields, own)
        for part in own.parts:
            parts.setdefault(part.kind, []).append((body, size, part))
        size += own.size
        fittings.append(fitting)
        if old is not None:
            kept.append((old, fitting))
    samples = np.zeros(size)
    if before is not None:
        for old, new in kept:
            samples[new.begin : new.end] = before[1][old.begin : old.end]
    begins = np.array([fitting.begin for fitting in fittings], dtype=np.int64)
    plan = SensorPlan(
        blocks=tuple(_block(kind, found) for kind, found in parts.items()),
        fittings=tuple(fittings),
        memory=_placed([fitting.own.memory for fitting in fittings], begins, _NO_MEMORY),
        spans=_placed([fitting.own.spans for fitting in fittings], begins, _NO_SPANS),
        seed=seed,
        floor=floor,
    )
    return plan, samples


_NO_MEMORY = np.empty(0, dtype=np.int64)
_NO_SPANS = np.empty((0, 2), dtype=np.int64)


def _fit(robot: Robot, start: Position, joined: int, seed: str, floor: Map) -> _Own:
    """Return the simulated sensors of a body."""
    fields: dict[str, list[_Place]] = {}
    found: dict[Kind, list[tuple[Fitted, list[int]]]] = {}
    spans: list[tuple[int, int]] = []
    remembered: list[int] = []
    first = 0
    for _, _, declaration in sensors_of(robot):
        if declaration.source == "real":
            continue
        kind = KINDS[type(declaration)]
        sensor = Fitted(robot, start, declaration, floor)
        every, latency, phase = declaration.every, declaration.latency, kind.phase(declaration)
        depth, width = sample_schedule.depth(every, latency), kind.width(declaration)
        place = _Place(kind.reading, sensor, first, width, depth, every, latency, phase)
        fields.setdefault(kind.field, []).append(place)
        key = noise_key(seed, str(robot.name), kind.stream(sensor))
        found.setdefault(kind, []).append((sensor, _row(declaration, joined + phase, first, depth, key)))
        spans.append((first, first + depth * width))
        first += depth * width
        memory = kind.memory(declaration)
        remembered.extend(range(first, first + memory))
        first += memory
    return _Own(
        size=first,
        fields=tuple((field, tuple(places)) for field, places in fields.items()),
        parts=tuple(_part(kind, sensors) for kind, sensors in found.items()),
        spans=np.array(spans, dtype=np.int64).reshape(-1, 2),
        memory=np.array(remembered, dtype=np.int64),
    )


def _row(declaration: Any, joined: int, first: int, depth: int, key: tuple[np.uint64, np.uint64]) -> list[int]:
    row = [0] * sample_schedule.SCHEDULE_COLUMNS
    row[sample_schedule.EVERY] = declaration.every
    row[sample_schedule.LATENCY] = declaration.latency
    row[sample_schedule.JOINED] = joined
    row[sample_schedule.FIRST_SAMPLE] = first
    row[sample_schedule.DEPTH] = depth
    row[sample_schedule.KEY0], row[sample_schedule.KEY1] = (int(half.view(np.int64)) for half in key)
    return row


def _part(kind: Kind, sensors: list[tuple[Fitted, list[int]]]) -> _Part:
    # The sort is stable: so the sensors of one mount stay in order.
    ordered = sorted(sensors, key=lambda sensor: getattr(sensor[0].declaration, "mount", "") == "start")
    rows = np.array([row for _, row in ordered], dtype=np.int64)
    return _Part(kind, kind.piece(tuple(sensor for sensor, _ in ordered)), rows)


def _block(kind: Kind, found: Sequence[tuple[int, int, _Part]]) -> Block:
    """Return the block of a kind.

    Args:
        kind: The kind.
        found: Of each body that has such sensors its index, the place of its samples, and the sensors.
    """
    counts = [len(part.rows) for _, _, part in found]
    schedule = np.concatenate([part.rows for _, _, part in found])
    schedule[:, sample_schedule.BODY] = np.repeat([body for body, _, _ in found], counts)
    schedule[:, sample_schedule.FIRST_SAMPLE] += np.repeat([begin for _, begin, _ in found], counts)
    return kind.assemble([part.piece for _, _, part in found], schedule)


def _placed(places: Sequence[Ints], begins: Ints, none: Ints) -> Ints:
    """Return places of all bodies, each of which counts them from the place where its samples begin."""
    placed = np.concatenate([none, *places])
    shift = np.repeat(begins, [len(one) for one in places])
    placed += shift.reshape(-1, *[1] * (placed.ndim - 1))
    return placed


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
