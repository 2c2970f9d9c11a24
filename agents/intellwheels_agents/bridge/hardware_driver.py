"""The interface to a chair's electronics.

A driver runs its own thread or process. `read` and `write` never wait. A driver repairs a broken connection by itself;
until it has done so there is nothing to read.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from intellwheels_schemas.messages import Pace, ProximityReading


@dataclass(frozen=True, slots=True)
class Fix:
    """A position measured from outside the chair: by GPS, a ceiling tag or a camera.

    Attributes:
        x, y: Metres, in the map's frame.
        sd: Standard deviation on each axis, in metres.
        offset_x, offset_y: The measured point on the body, in metres from the body's origin.
    """

    x: float
    y: float
    sd: float
    offset_x: float = 0.0
    offset_y: float = 0.0


@dataclass(frozen=True, slots=True)
class Reading:
    """A report of the electronics at one moment.

    Attributes:
        epoch: Differs after each restart of the counters.
        seq: Grows by one a reading within an epoch.
        stamp: Seconds on the hardware's own clock.
        received: Seconds of this process's monotonic clock.
        left, right: Encoder counts, forward positive.
        tick: The tick of simulated hardware, otherwise None.
        proximity: The chair's own sonars, with the ids of its robot document.
        fix: A position from outside, if there is one.
        battery: Volts, or None.
        forward, turn: The chair's own joystick, in [-1, 1], or None without one.
        motion: What the chair's own inertial unit measured: acceleration forward and to the left in m/s2, and turn
            rate in rad/s, anticlockwise; or None without one.
    """

    epoch: str
    seq: int
    stamp: float
    received: float
    left: int
    right: int
    tick: int | None = None
    proximity: tuple[ProximityReading, ...] = ()
    fix: Fix | None = None
    battery: float | None = None
    forward: float | None = None
    turn: float | None = None
    motion: tuple[float, float, float] | None = None


class Driver(Protocol):
    """A chair's electronics.

    Attributes:
        restarts_at_start: Whether the chair is back at its start in a new epoch. True for simulated hardware.
        failure: Why the driver has given up for good, as a sentence, or None.
        connected: Set when the first reading has arrived.
    """

    restarts_at_start: bool
    failure: str | None
    connected: threading.Event

    def start(self) -> None:
        """Start looking for the hardware."""
        ...

    def read(self) -> Sequence[Reading]:
        """Return the readings received since the last call, in order of arrival."""
        ...

    def write(self, left: float, right: float) -> None:
        """Set the motor powers, in [-1, 1]. The hardware itself stops when no power follows.

        Nothing reaches the hardware before the first `begin_run`: until then the simulator may refuse the bridge.
        """
        ...

    def begin_run(self, run: str) -> None:
        """Note that the simulator has accepted the bridge for a run. Called at the start of each run."""
        ...

    def sync_tick(self, run: str, tick: int, pace: Pace) -> bool:
        """Note the tick of the simulation; return whether the readings belong to the same tick.

        When both worlds are in lockstep this waits for the reading of that tick. Real hardware returns False at once.
        """
        ...

    def power_received(self, run: str, tick: int) -> None:
        """Note that the power of a tick is set."""
        ...

    def faults(self) -> dict[str, int]:
        """Return the number of faults on the hardware's line so far, by name."""
        ...

    def close(self) -> None:
        """Stop the motors and release the hardware."""
        ...
