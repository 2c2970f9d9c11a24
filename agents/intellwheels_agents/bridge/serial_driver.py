"""A chair's controller on a serial line: the driver `serial`. The only file that knows pyserial.

One thread reads, and opens the line again whenever it is gone; who writes never waits longer than a tenth of a second.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from intellwheels_agents.bridge.hardware_driver import Fix, Reading
from intellwheels_agents.bridge.line_protocol import Located, PowerLine, Splitter, Telemetry, read, written
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Pace, Proximity, ProximityReading

if TYPE_CHECKING:
    import serial

AGAIN: Final = 0.2
"""Seconds between two tries to open the line."""
ROOM: Final = 3000
"""Readings kept until they are read: a minute at 50 Hz."""
_STATUS: Final = {"n": "none", "c": "near", "f": "fault"}


class SerialDriver:
    """The driver `serial`.

    Attributes:
        returns: False: a controller that starts anew is where it was.
        failure: Why there will never be a line: pyserial is missing.
        heard: Set when the first reading is there.
    """

    returns = False

    def __init__(self, name: str, baud: int, sonars: Sequence[Proximity], stop: threading.Event) -> None:
        """Prepare to open a line.

        Args:
            name: A device such as /dev/ttyUSB0, or a URL of pyserial's such as socket://HOST:PORT.
            baud: Bits a second.
            sonars: The chair's own, in the order of the telemetry's ranges.
            stop: Ends the reading.
        """
        self.failure: str | None = None
        self.heard = threading.Event()
        self._name = name
        self._baud = baud
        self._sonars = tuple(sonars)
        self._stop = stop
        self._readings: deque[Reading] = deque(maxlen=ROOM)
        self._splitter = Splitter()
        self._fix: Fix | None = None
        self._lock = threading.Lock()
        self._line: serial.Serial | None = None
        self._garbage = self._opened = self._unwritten = 0
        self._thread = threading.Thread(target=self._live, name="serial", daemon=True)

    # ------------------------------------------------------------ the driver

    def start(self) -> None:
        """Begin to look for the controller."""
        self._thread.start()

    def read(self) -> list[Reading]:
        """Return what was said since the last call."""
        found = []
        while self._readings:
            found.append(self._readings.popleft())
        return found

    def write(self, left: float, right: float) -> None:
        """Tell the controller a power; where there is no line nothing is told, and it stops by itself."""
        with self._lock:
            if self._line is not None:
                self._tell(self._line, left, right)

    def enter(self, run: str) -> None:
        """Do nothing: real hardware has no runs."""

    def meet(self, run: str, tick: int, pace: Pace) -> bool:  # noqa: ARG002 - as `Driver` has it
        """Return False: real hardware waits for nobody."""
        return False

    def powered(self, run: str, tick: int) -> None:
        """Do nothing: real hardware has no ticks."""

    def faults(self) -> dict[str, int]:
        """Return what went wrong on the line."""
        return {
            "garbage": self._garbage + self._splitter.overlong,
            "reopened": max(self._opened - 1, 0),
            "unwritten": self._unwritten,
        }

    def close(self) -> None:
        """Let go; `stop` is set already, and the thread's last word is a zero."""
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)

    # ------------------------------------------------------------ the thread

    def _live(self) -> None:
        try:
            import serial  # noqa: PLC0415 - an extra, that agents do without
        except ImportError:
            self.failure = "pyserial is not installed: expected the extra of `pip install intellwheels[bridge]`"
            self._stop.set()
            return
        while not self._stop.is_set():
            try:
                line = serial.serial_for_url(self._name, self._baud, timeout=0.05, write_timeout=0.1)
            except OSError:
                self._stop.wait(AGAIN)  # not there yet
                continue
            self._opened += 1
            with line:
                self._use(line)
            self._stop.wait(AGAIN)

    def _use(self, line: serial.Serial) -> None:
        """Listen to an open line until it is gone or all ends."""
        self._splitter.feed(b"\n")
        with self._lock:
            self._line = line
        try:
            while not self._stop.is_set():
                self._hear(line.read(max(1, line.in_waiting)), time.monotonic())
        except OSError:
            pass  # gone
        finally:
            # Nobody writes to a line that is being closed: pyserial's own state is gone under the writer's hands.
            with self._lock:
                self._line = None
                if self._stop.is_set():
                    self._tell(line, 0.0, 0.0)

    def _tell(self, line: serial.Serial, left: float, right: float) -> None:
        try:
            line.write(written(PowerLine(round(1000.0 * left), round(1000.0 * right))))
        except OSError:  # pyserial's own errors are OSErrors
            self._unwritten += 1

    def _hear(self, data: bytes, now: float) -> None:
        for line in self._splitter.feed(data):
            try:
                message = read(line)
            except WireError:
                self._garbage += 1
                continue
            if isinstance(message, Located):
                self._fix = message.fix()
            elif isinstance(message, Telemetry):
                self._readings.append(self._reading(message, now))
                self.heard.set()

    def _reading(self, told: Telemetry, now: float) -> Reading:
        fix, self._fix = self._fix, None
        return Reading(
            era=str(told.boot),
            seq=told.seq,
            taken=told.ms / 1000.0,
            arrived=now,
            left=told.left,
            right=told.right,
            proximity=tuple(_range(sonar, heard) for sonar, heard in zip(self._sonars, told.ranges, strict=False)),
            fix=fix,
            battery=told.battery / 1000.0,
            forward=None if told.stick is None else told.stick[0] / 1000.0,
            turn=None if told.stick is None else told.stick[1] / 1000.0,
        )


def _range(sonar: Proximity, heard: int | str) -> ProximityReading:
    if isinstance(heard, int):
        return ProximityReading(id=sonar.id, value=heard / 1000.0)
    return ProximityReading(id=sonar.id, status=_STATUS[heard])  # type: ignore[arg-type]
