"""What was true in a run, read from the trace that the simulator wrote, and what its chair believed.

The simulator's folder of a run has `trace.jsonl`, a line a tick, and `input.jsonl`, whose first line with changes says
which bodies joined.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from intellwheels_experiments.batch.metrics import Floats
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import (
    InputHeader,
    InputTick,
    Join,
    TraceBody,
    TraceHeader,
    TraceTick,
    read_header,
)
from intellwheels_schemas.messages import Event, Robot

_T = TypeVar("_T", InputTick, TraceTick)


@dataclass(frozen=True)
class Trace:
    """A run as it was.

    Attributes:
        heading: Which run it is.
        moments: Its ticks, one after the other.
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
        """Return where a body was, float64[n, 3]: x, y, heading; NaN where it was not there."""
        nowhere = (math.nan, math.nan, math.nan)
        return np.array([moment.body[name].pose if name in moment.body else nowhere for moment in self.moments])

    def shown(self, name: str) -> list[TraceBody]:
        """Return a body at each tick at which it was there."""
        return [moment.body[name] for moment in self.moments if name in moment.body]

    @property
    def events(self) -> list[Event]:
        """All that happened, in order."""
        return [event for moment in self.moments for event in moment.event]


def read_trace(trace: Path, log: Path) -> Trace:
    """Return a run.

    Args:
        trace: Its trace.
        log: Its input log.

    Raises:
        OSError: One cannot be read.
        WireError: One is not what this release of the simulator writes; the text says which line.
    """
    first, *rest = trace.read_bytes().splitlines() or [b""]
    heading = read_header(TraceHeader, first, f"{trace}:1")
    decoder = msgspec.json.Decoder(TraceTick)
    moments = [_tick(decoder, line, f"{trace}:{number}") for number, line in enumerate(rest, start=2)]
    return Trace(heading, moments, _robots(log))


def _robots(log: Path) -> dict[str, Robot]:
    robots: dict[str, Robot] = {}
    decoder = msgspec.json.Decoder(InputTick)
    with log.open("rb") as file:
        read_header(InputHeader, file.readline(), f"{log}:1")
        for number, text in enumerate(file, start=2):
            line = _tick(decoder, text, f"{log}:{number}")
            for change in line.inputs.changes:
                if isinstance(change, Join) and change.robot.role != "mind":
                    robots[change.agent] = change.robot
            if line.tick > 0:
                break
    return robots


def _tick(decoder: msgspec.json.Decoder[_T], line: bytes, where: str) -> _T:
    try:
        return decoder.decode(line)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise WireError("malformed", f"{where}: expected the line of a tick, got {error}", where) from None


def reported(shown: Sequence[TraceBody], robot: Robot) -> Floats | None:
    """Return the pose that a body's own wheels tell, float64[n, 3] in the map's frame; None of one without encoders.

    It is that of its odometry sensor, else the encoders' counts integrated by exact arcs with the nominal figures.
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
    """Return where the powers alone lead, float64[n, 3]: wheels that turn at once and as they are told."""
    power = np.array([one.power for one in shown[1:]], dtype=np.float64).reshape(-1, 2)
    return rolled(np.array(shown[0].pose), power * robot.top_speed * period, robot.track)


def rolled(start: Floats, way: Floats, track: float) -> Floats:
    """Return the poses after ways of both wheels, the start first, by exact arcs.

    Args:
        start: float64[3], x, y, heading.
        way: float64[n, 2], left and right, m.
        track: Between the wheels, m.
    """
    travel, turn = way.mean(axis=1), (way[:, 1] - way[:, 0]) / track
    heading = start[2] + np.concatenate([[0.0], np.cumsum(turn)])
    # The chord of the arc, along the heading of its middle.
    chord = travel * np.sinc(turn / 2.0 / math.pi)
    middle = heading[:-1] + turn / 2.0
    x = start[0] + np.concatenate([[0.0], np.cumsum(chord * np.cos(middle))])
    y = start[1] + np.concatenate([[0.0], np.cumsum(chord * np.sin(middle))])
    return np.column_stack([x, y, heading])


def _from(start: Floats, own: Floats) -> Floats:
    """Return poses told in the frame of a start in that start's own frame."""
    c, s = math.cos(start[2]), math.sin(start[2])
    return np.column_stack(
        [start[0] + c * own[:, 0] - s * own[:, 1], start[1] + s * own[:, 0] + c * own[:, 1], start[2] + own[:, 2]]
    )
