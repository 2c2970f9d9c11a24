"""Reads the trace of a run: its true states, and the poses that the chair itself estimated.

The simulator writes a folder for each run. In it `trace.jsonl` has one line per tick. The first line with changes in
`input.jsonl` says which bodies joined.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from intellwheels_experiments.batch.metrics import Floats
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import (
    Join,
    TraceBody,
    TraceHeader,
    TraceTick,
    read_header,
)
from intellwheels_schemas.input_reader import InputReader
from intellwheels_schemas.messages import Event, Robot


@dataclass(frozen=True)
class Trace:
    """The true states of a run.

    Attributes:
        heading: The first line of the trace, which identifies the run.
        moments: Its ticks, in order.
        robots: The bodies as they joined, by name.
    """

    heading: TraceHeader
    moments: Sequence[TraceTick]
    robots: dict[str, Robot]

    @property
    def times(self) -> Floats:
        """Simulated seconds of each tick, float64[n]."""
        return np.array([moment.tick for moment in self.moments]) * self.heading.period

    def poses(self, name: str) -> Floats:
        """Return the poses of a body, float64[n, 3]: x, y, heading; NaN at ticks without the body."""
        nowhere = (math.nan, math.nan, math.nan)
        return np.array([moment.body[name].pose if name in moment.body else nowhere for moment in self.moments])

    def shown(self, name: str) -> list[TraceBody]:
        """Return the states of a body, at each tick at which it was present."""
        return [moment.body[name] for moment in self.moments if name in moment.body]

    @property
    def events(self) -> list[Event]:
        """All events, in order."""
        return [event for moment in self.moments for event in moment.event]


def read_trace(trace: Path, log: Path) -> Trace:
    """Return a run.

    Args:
        trace: Its trace.
        log: Its input log.

    Raises:
        OSError: One cannot be read.
        WireError: A line is not in the format that this release of the simulator writes, or the log is edited; the
            text says which line.
    """
    first, *rest = trace.read_bytes().splitlines() or [b""]
    heading = read_header(TraceHeader, first, f"{trace}:1")
    decoder = msgspec.json.Decoder(TraceTick)
    moments = [_tick(decoder, line, f"{trace}:{number}") for number, line in enumerate(rest, start=2)]
    return Trace(heading, moments, _robots(log))


def _robots(log: Path) -> dict[str, Robot]:
    """Return the bodies that joined. All lines are read, so that an edited log is noticed."""
    robots: dict[str, Robot] = {}
    begun = False
    with log.open("rb") as file:
        reader = InputReader(file.readline(), str(log))
        for line in reader.read_all(file):
            for change in () if begun else line.inputs.changes:
                if isinstance(change, Join) and change.robot.role != "mind":
                    robots[change.agent] = change.robot
            begun = begun or line.tick > 0
    return robots


def _tick(decoder: msgspec.json.Decoder[TraceTick], line: bytes, where: str) -> TraceTick:
    try:
        return decoder.decode(line)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise WireError("malformed", f"{where}: expected the line of a tick, got {error}", where) from None


def reported(shown: Sequence[TraceBody], robot: Robot) -> Floats | None:
    """Return the poses by odometry, float64[n, 3] in the map's frame; None for a body without encoders.

    They come from its odometry sensor if it has one. Otherwise the encoder counts are integrated along exact arcs with
    the nominal dimensions.
    """
    start = np.array(shown[0].pose)
    if shown[0].odometry is not None:
        own = np.array([one.odometry if one.odometry is not None else (math.nan,) * 3 for one in shown])
        return _from(start, own - 0.0)
    if shown[0].wheels is None:
        return None
    counts = np.array([one.wheels for one in shown], dtype=np.float64)
    way = np.diff(counts, axis=0) * (math.pi * robot.wheel_diameter / robot.encoder_ticks)
    return rolled(start, way, robot.track)


def commanded(shown: Sequence[TraceBody], robot: Robot, period: float) -> Floats:
    """Return the poses that follow from the powers alone, float64[n, 3]: ideal wheels, without lag or slip."""
    power = np.array([one.power for one in shown[1:]], dtype=np.float64).reshape(-1, 2)
    return rolled(np.array(shown[0].pose), power * robot.top_speed * period, robot.track)


def rolled(start: Floats, way: Floats, track: float) -> Floats:
    """Return the poses along exact arcs given by the travel of both wheels, the start first.

    Args:
        start: float64[3], x, y, heading.
        way: Travel of the left and right wheel at each tick, float64[n, 2], m.
        track: Distance between the wheels, m.
    """
    travel, turn = way.mean(axis=1), (way[:, 1] - way[:, 0]) / track
    heading = start[2] + np.concatenate([[0.0], np.cumsum(turn)])
    # The chord of the arc points along the heading at the middle of the arc.
    chord = travel * np.sinc(turn / 2.0 / math.pi)
    middle = heading[:-1] + turn / 2.0
    x = start[0] + np.concatenate([[0.0], np.cumsum(chord * np.cos(middle))])
    y = start[1] + np.concatenate([[0.0], np.cumsum(chord * np.sin(middle))])
    return np.column_stack([x, y, heading])


def _from(start: Floats, own: Floats) -> Floats:
    """Return poses that are relative to a start, in the frame in which the start is given."""
    c, s = math.cos(start[2]), math.sin(start[2])
    return np.column_stack(
        [start[0] + c * own[:, 0] - s * own[:, 1], start[1] + s * own[:, 0] + c * own[:, 1], start[2] + own[:, 2]]
    )
