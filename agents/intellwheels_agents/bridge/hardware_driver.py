"""The interface to a chair's electronics.

A driver runs its own thread or process. `read` and `write` never wait. A driver repairs a broken connection by itself;
until it has done so there is nothing to read.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
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


class RealHardware:
    """What the drivers of real chairs share: readings that wait, and neither runs nor ticks. See `Driver`.

    Attributes:
        restarts_at_start: False, because a real chair stays where it is when its electronics restart.
        failure: Why the driver has given up for good, or None.
        connected: Set when the first reading has arrived.
    """

    restarts_at_start = False

    def __init__(self, stop: threading.Event, waiting: Callable[[str], None], most_readings: int) -> None:
        """Begin without readings.

        Args:
            stop: Ends every thread of the driver, and is set when it gives up.
            waiting: Called with the reason whenever the driver starts to wait for its hardware.
            most_readings: Readings kept until they are read; the oldest are dropped.
        """
        self.failure: str | None = None
        self.connected = threading.Event()
        self._stop = stop
        self._waiting = waiting
        self._reason = ""
        self._readings: deque[Reading] = deque(maxlen=most_readings)

    def read(self) -> list[Reading]:
        """Return the readings since the last call."""
        found = []
        while self._readings:
            found.append(self._readings.popleft())
        return found

    def sync_tick(self, run: str, tick: int, pace: Pace) -> bool:  # noqa: ARG002 - as `Driver` has it
        """Return False: real hardware does not wait."""
        return False

    def power_received(self, run: str, tick: int) -> None:
        """Do nothing: real hardware has no ticks."""

    def _wait_for(self, reason: str) -> None:
        """Report what the driver waits for, once until it has come (`_reason` is empty then) or the reason changes."""
        if reason != self._reason:
            self._reason = reason
            self._waiting(reason)

    def _fail(self, reason: str) -> None:
        """Give up for good."""
        self.failure = reason
        self._stop.set()
