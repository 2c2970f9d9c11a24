"""The trace of a run: the true state at each tick, for evaluation. `file_records` declares its lines.

A trace is written to a file and never put on the network.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec

from intellwheels_schemas.file_records import TraceBody, TraceHeader, TraceTick
from intellwheels_schemas.input_reader import cut_text
from intellwheels_schemas.messages import Event
from intellwheels_server.log.input_log import LogError, LogReader
from intellwheels_server.log.resimulate import difference, first_state, replay
from intellwheels_server.world import digest
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.observations import measures
from intellwheels_server.world.state import State


def heading_of(state: State) -> TraceHeader:
    """Return the first line of the trace of a run."""
    setup = state.setup
    return TraceHeader(run=state.run, seed=setup.seed, period=setup.period, floor=setup.floor.name)


def moment_of(state: State, hashed: str, events: tuple[Event, ...] = ()) -> TraceTick:
    """Return the line of a tick."""
    bodies = {name: _shown(state, name, i) for i, name in enumerate(state.names)}
    return TraceTick(tick=state.tick, body=bodies, event=events, hash=hashed)


def _shown(state: State, name: str, i: int) -> TraceBody:
    numbers, sensors = state.numbers[:, i].tolist(), measures(state, name).sensors
    wheels = sensors.encoders[0] if sensors and sensors.encoders else None
    odometry = sensors.odometry[0] if sensors and sensors.odometry else None
    user, status = state.user.get(name), state.statuses.get(name)
    return TraceBody(
        pose=(numbers[rows.X], numbers[rows.Y], numbers[rows.HEADING]),
        speed=numbers[rows.SPEED],
        turn_rate=numbers[rows.TURN_RATE],
        power=(numbers[rows.LEFT_POWER], numbers[rows.RIGHT_POWER]),
        collision=bool(state.flags[rows.COLLISION, i]),
        touching=bool(numbers[rows.TOUCHING]),
        contacts=int(state.flags[rows.CONTACTS, i]),
        mode=status.mode if status else None,
        wheels=(wheels.left, wheels.right) if wheels else None,
        odometry=(odometry.x, odometry.y, odometry.heading) if odometry else None,
        user=(user.forward, user.turn) if user else None,
    )


def trace_lines(path: Path, tell: Callable[[str], None] = lambda _text: None) -> Iterator[bytes]:
    """Yield the trace of a log: for each of its runs the first line, the first tick and every tick after it.

    Args:
        path: The log.
        tell: Called with a text for people if the log is cut.

    Raises:
        LogError: The file is no log, it is edited, or a hash differs from the recorded one.
        OSError: The file cannot be read.
    """
    encode = msgspec.json.encode
    with path.open("rb") as file:
        reader = LogReader(file, str(path))
        state, run = first_state(reader.first, str(path)), ""
        for line in reader.read_all(file):
            state, outputs = replay(state, line, f"{path}:{reader.lines}")
            found = digest(state)
            if found != line.hash:
                raise LogError(f"{path}: {difference(state, line, reader.lines, found)}")
            if state.run != run:
                run = state.run
                yield encode(heading_of(state)) + b"\n"
            if line.stepped or state.tick == 0:
                yield encode(moment_of(state, found, outputs.events if line.stepped else ())) + b"\n"
    if reader.cut:
        tell(cut_text(str(path), state.tick))
