"""What a chair's electronics give and take: the one interface to hardware.

A driver has its own thread or process behind it. `read` and `write` never wait; what breaks is mended behind them, and
until then there is nothing to read.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from intellwheels_schemas.messages import Pace, ProximityReading


@dataclass(frozen=True, slots=True)
class Fix:
    """A position from outside the chair: a GPS, a tag on the ceiling, a camera.

    Attributes:
        x, y: Metres, in the map's frame.
        sd: Standard deviation on each axis, in metres.
        offset_x, offset_y: Metres, where on the body it was measured.
    """

    x: float
    y: float
    sd: float
    offset_x: float = 0.0
    offset_y: float = 0.0


@dataclass(frozen=True, slots=True)
class Reading:
    """What the electronics said at one moment.

    Attributes:
        era: Another whenever the counts began anew.
        seq: Grows by one a reading within an era.
        taken: Seconds on the hardware's own clock.
        arrived: Seconds of this process's monotonic clock.
        left, right: Encoder counts, forward positive.
        tick: The tick of a simulated hardware, else None.
        proximity: The chair's own sonars, under the ids its document has.
        fix: A position from outside, where there is one.
        battery: Volts, or None.
        forward, turn: The chair's own joystick, in [-1, 1], or None where there is none.
    """

    era: str
    seq: int
    taken: float
    arrived: float
    left: int
    right: int
    tick: int | None = None
    proximity: tuple[ProximityReading, ...] = ()
    fix: Fix | None = None
    battery: float | None = None
    forward: float | None = None
    turn: float | None = None


class Driver(Protocol):
    """A chair's electronics.

    Attributes:
        returns: Whether the chair stands at its start again in a new era: a simulated one does.
        failure: Why it has given up for good, in words, or None.
        heard: Set when the first reading is there.
    """

    returns: bool
    failure: str | None
    heard: threading.Event

    def start(self) -> None:
        """Begin to look for the hardware."""
        ...

    def read(self) -> Sequence[Reading]:
        """Return what was said since the last call, in order of arrival."""
        ...

    def write(self, left: float, right: float) -> None:
        """Give the motors these powers, in [-1, 1], until others come; the hardware itself stops on silence."""
        ...

    def enter(self, run: str) -> None:
        """Be told which run the simulation is in, before its first tick."""
        ...

    def meet(self, run: str, tick: int, pace: Pace) -> bool:
        """Be told which tick the simulation is at; return whether the readings are of the same tick.

        Where both are in lockstep this waits for the reading of that tick; real hardware returns False at once.
        """
        ...

    def powered(self, run: str, tick: int) -> None:
        """Be told that the motors have the power of a tick."""
        ...

    def faults(self) -> dict[str, int]:
        """Return what went wrong on the hardware's line so far, counts by name."""
        ...

    def close(self) -> None:
        """Stop the motors and let go."""
        ...
