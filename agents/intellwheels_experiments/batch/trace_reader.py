"""What was true in a run, read from the trace that the simulator wrote, and what its chair believed.

The simulator's folder of a run has `trace.jsonl`, a line a tick, and `input.jsonl`, whose first line with changes says
which bodies joined.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from intellwheels_experiments.batch.metrics import Floats
from intellwheels_schemas.codec import from_plain
from intellwheels_schemas.messages import Event, Robot


class Shown(msgspec.Struct, frozen=True, kw_only=True, rename="pascal"):
    """A body at a tick, as the simulator's trace has it."""

    pose: tuple[float, float, float]
    speed: float = 0.0
    turn_rate: float = 0.0
    power: tuple[float, float] = (0.0, 0.0)
    touching: bool = False
    mode: str | None = None
    wheels: tuple[int, int] | None = None
    odometry: tuple[float, float, float] | None = None
    user: tuple[float, float] | None = None


class Moment(msgspec.Struct, frozen=True, kw_only=True, rename="pascal"):
    """A tick of a trace."""

    tick: int
    body: dict[str, Shown]
    event: tuple[Event, ...] = ()
    hash: str


class Heading(msgspec.Struct, frozen=True, kw_only=True, rename="pascal"):
    """The first line of a trace."""

    run: str
    seed: str
    period: float
    floor: str


@dataclass(frozen=True)
class Trace:
    """A run as it was.

    Attributes:
        heading: Which run it is.
        moments: Its ticks, one after the other.
        robots: The bodies as they joined, by name.
    """

    heading: Heading
    moments: Sequence[Moment]
    robots: dict[str, Robot]

    @property
    def times(self) -> Floats:
        """Simulated seconds of each tick, float64[n]."""
        return np.array([moment.tick for moment in self.moments]) * self.heading.period

    def poses(self, name: str) -> Floats:
        """Return where a body was, float64[n, 3]: x, y, heading; NaN where it was not there."""
        nowhere = (math.nan, math.nan, math.nan)
        return np.array([moment.body[name].pose if name in moment.body else nowhere for moment in self.moments])

    def shown(self, name: str) -> list[Shown]:
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
        msgspec.MsgspecError: One is not what the simulator writes.
    """
    first, *rest = trace.read_bytes().splitlines()
    moments = msgspec.json.Decoder(Moment)
    return Trace(msgspec.json.decode(first, type=Heading), [moments.decode(line) for line in rest], _robots(log))


def _robots(log: Path) -> dict[str, Robot]:
    robots: dict[str, Robot] = {}
    with log.open("rb") as file:
        next(file)
        for line in file:
            plain: dict[str, Any] = msgspec.json.decode(line)
            for change in plain["Inputs"].get("Changes", ()):
                if change["Do"] == "Join" and change["Robot"].get("Role", "both") != "mind":
                    robots[change["Agent"]] = from_plain(Robot, change["Robot"])
            if plain["Tick"] > 0:
                break
    return robots


def reported(shown: Sequence[Shown], robot: Robot) -> Floats | None:
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


def commanded(shown: Sequence[Shown], robot: Robot, period: float) -> Floats:
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
