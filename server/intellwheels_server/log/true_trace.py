"""What was true at each tick, for whoever measures a run: the states that an input log leads to, as plain lines.

JSON Lines. The first says which run it is, each after it a tick. Nothing is rounded. A trace is written to a file and
never put on the network.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_schemas.messages import Event
from intellwheels_server.log.input_log import LogError, read_header, read_lines
from intellwheels_server.log.resimulate import difference, replay
from intellwheels_server.world import begin, digest
from intellwheels_server.world.kernels.rows import (
    COLLISION,
    CONTACTS,
    HEADING,
    LEFT_POWER,
    RIGHT_POWER,
    SPEED,
    TOUCHING,
    TURN_RATE,
    X,
    Y,
)
from intellwheels_server.world.observations import measures
from intellwheels_server.world.state import State

FORMAT: Final = "iw.v1"


class Heading(msgspec.Struct, frozen=True, kw_only=True, rename="pascal"):
    """The first line of a trace."""

    trace: str = FORMAT
    run: str
    seed: str
    period: float
    floor: str


class Shown(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True):
    """A body at a tick.

    Attributes:
        pose: True x and y, m, and heading, rad.
        speed: m/s.
        turn_rate: rad/s.
        power: Left and right, in force in the step to this tick, in [-1, 1].
        collision: Whether it could not move as it would.
        touching: Whether it touches something.
        contacts: Episodes of contact so far.
        mode: What its mind says it is doing.
        wheels: The counts of its first encoders.
        odometry: The pose of its first odometry since joining, x, y, m, and heading, rad.
        user: Forward and turn of its user.
    """

    pose: tuple[float, float, float]
    speed: float = 0.0
    turn_rate: float = 0.0
    power: tuple[float, float] = (0.0, 0.0)
    collision: bool = False
    touching: bool = False
    contacts: int = 0
    mode: str | None = None
    wheels: tuple[int, int] | None = None
    odometry: tuple[float, float, float] | None = None
    user: tuple[float, float] | None = None


class Moment(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True):
    """A tick: its number, every body, what happened in the step to it, and the hash."""

    tick: int
    body: dict[str, Shown]
    event: tuple[Event, ...] = ()
    hash: str


def heading_of(state: State) -> Heading:
    """Return the first line of the trace of a run."""
    setup = state.setup
    return Heading(run=state.run, seed=setup.seed, period=setup.period, floor=setup.floor.name)


def moment_of(state: State, hashed: str, events: tuple[Event, ...] = ()) -> Moment:
    """Return the line of a tick."""
    bodies = {name: _shown(state, name, i) for i, name in enumerate(state.names)}
    return Moment(tick=state.tick, body=bodies, event=events, hash=hashed)


def _shown(state: State, name: str, i: int) -> Shown:
    numbers, sensors = state.numbers[:, i].tolist(), measures(state, name).sensors
    wheels = sensors.encoders[0] if sensors and sensors.encoders else None
    odometry = sensors.odometry[0] if sensors and sensors.odometry else None
    user, status = state.user.get(name), state.statuses.get(name)
    return Shown(
        pose=(numbers[X], numbers[Y], numbers[HEADING]),
        speed=numbers[SPEED],
        turn_rate=numbers[TURN_RATE],
        power=(numbers[LEFT_POWER], numbers[RIGHT_POWER]),
        collision=bool(state.flags[COLLISION, i]),
        touching=bool(numbers[TOUCHING]),
        contacts=int(state.flags[CONTACTS, i]),
        mode=status.mode if status else None,
        wheels=(wheels.left, wheels.right) if wheels else None,
        odometry=(odometry.x, odometry.y, odometry.heading) if odometry else None,
        user=(user.forward, user.turn) if user else None,
    )


def trace_lines(path: Path) -> Iterator[bytes]:
    """Yield the trace of a log: for each of its runs the first line, the first tick and every tick after it.

    Raises:
        LogError: The file is no log, or a hash differs from the recorded one.
        OSError: The file cannot be read.
    """
    encode = msgspec.json.encode
    with path.open("rb") as file:
        header = read_header(file, str(path))
        state, run = begin(header.world_setup(), header.run), ""
        for number, line in enumerate(read_lines(file, str(path)), start=2):
            if line is None:
                return
            state, outputs = replay(state, line, f"{path}:{number}")
            found = digest(state)
            if found != line.hash:
                raise LogError(f"{path}: {difference(state, line, number, found)}")
            if state.run != run:
                run = state.run
                yield encode(heading_of(state)) + b"\n"
            if line.stepped or state.tick == 0:
                yield encode(moment_of(state, found, outputs.events if line.stepped else ())) + b"\n"
