"""The driver `serial`: a chair's controller on a serial line. The only file that knows pyserial.

One thread reads, and opens the line again whenever it is lost. A write never waits longer than a tenth of a second.

One bridge at a time drives a chair. The device is locked as it is opened (`flock`, which holds for root too), and a
device that another program has locked is given up at once. Nothing is written before the simulator has accepted the
bridge, so a bridge that is refused because its name is taken never moves a motor.
"""

from __future__ import annotations

import errno
import os
import threading
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from intellwheels_agents.bridge.hardware_driver import Fix, Reading, RealHardware
from intellwheels_agents.bridge.line_protocol import (
    LineSplitter,
    PositionFix,
    PowerLine,
    Telemetry,
    decode_line,
    encode_line,
)
from intellwheels_agents.bridge.timeouts import QUIET_LINE, REOPEN_PERIOD
from intellwheels_agents.bridge.wrapping_counter import WrappingCounter
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Proximity, ProximityReading

if TYPE_CHECKING:
    import serial

MAX_READINGS: Final = 3000
"""Readings kept until they are read: a minute at 50 Hz."""
_URLS: Final = ("socket", "rfc2217", "loop", "hwgrep", "spy", "alt", "cp2110")
"""Kinds of URL that pyserial knows."""
_READ_TIMEOUT: Final = 0.05
_WRITE_TIMEOUT: Final = 0.1
_LOCKED: Final = (errno.EWOULDBLOCK, errno.EBUSY)
"""Errors of opening a device that another program has locked, by `flock` or by TIOCEXCL."""
_STATUS: Final = {"n": "none", "c": "near", "f": "fault"}


def check_port(port: str) -> None:
    """Check the form of `--port`. A device need not exist yet.

    Raises:
        WireError: It is empty, or a URL of an unknown kind.
    """
    kind, is_url, _ = port.partition("://")
    if not port or (is_url and kind not in _URLS):
        expected = f"--port: expected a device such as /dev/ttyUSB0, or a URL ({', '.join(_URLS)})"
        raise WireError("value", f"{expected}, got {port!r}", "--port")


class SerialDriver(RealHardware):
    """The driver `serial`."""

    def __init__(
        self,
        port: str,
        baud: int,
        sonars: Sequence[Proximity],
        stop: threading.Event,
        waiting: Callable[[str], None] = lambda _reason: None,
    ) -> None:
        """Prepare to open a line.

        Args:
            port: A device such as /dev/ttyUSB0, or a pyserial URL such as socket://HOST:PORT.
            baud: Bits a second.
            sonars: The chair's own sonars, in the order of the telemetry's ranges.
            stop: Ends the thread, and is set when the driver gives up.
            waiting: Called with the reason whenever the driver starts to wait for the device or its telemetry.
        """
        super().__init__(stop, waiting, MAX_READINGS)
        self._port = port
        self._baud = baud
        self._sonars = tuple(sonars)
        self._accepted = False
        self._splitter = LineSplitter()
        self._fix: Fix | None = None
        self._boot = -1
        self._seq, self._ms = WrappingCounter(), WrappingCounter()
        self._left, self._right = WrappingCounter(), WrappingCounter()
        self._lock = threading.Lock()
        self._line: serial.Serial | None = None
        self._quiet = 0.0
        self._garbage = self._opened = self._unwritten = 0
        self._thread = threading.Thread(target=self._run, name="serial", daemon=True)

    # ------------------------------------------------------------ the driver

    def start(self) -> None:
        """Start looking for the controller."""
        self._thread.start()

    def write(self, left: float, right: float) -> None:
        """Send a power to the controller. Without a line nothing is sent, and the controller stops by itself."""
        with self._lock:
            if self._line is not None and self._accepted:
                self._send(self._line, left, right)

    def begin_run(self, run: str) -> None:  # noqa: ARG002 - as `Driver` has it
        """Allow writing: the simulator has accepted the bridge. Real hardware has no runs."""
        self._accepted = True

    def faults(self) -> dict[str, int]:
        """Return the number of faults on the line so far, by name."""
        return {
            "garbage": self._garbage + self._splitter.too_long,
            "reopened": max(self._opened - 1, 0),
            "unwritten": self._unwritten,
        }

    def close(self) -> None:
        """Wait for the thread to end. If it sent powers, its last one is zero. `stop` is set already."""
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)

    # ------------------------------------------------------------ the thread

    def _run(self) -> None:
        import serial  # noqa: PLC0415 - an optional dependency, which agents do not need

        while not self._stop.is_set():
            try:
                line = serial.serial_for_url(
                    self._port, self._baud, timeout=_READ_TIMEOUT, write_timeout=_WRITE_TIMEOUT, exclusive=True
                )
            except OSError as error:  # pyserial's own errors are OSErrors
                # A line that was lost may be taken for a while when it is back: ModemManager probes new devices.
                if error.errno in _LOCKED and not self._opened:
                    self._fail(f"{self._port} is in use by another program, perhaps by another iw-bridge")
                    return
                self._wait_for(f"cannot open {self._port}: {_in_words(error)}")
                self._stop.wait(REOPEN_PERIOD)
                continue
            except ValueError as error:
                self._fail(f"--port: expected a device or a pyserial URL, got {self._port!r}: {error}")
                return
            self._opened += 1
            with line:
                self._use(line)
            self._stop.wait(REOPEN_PERIOD)

    def _use(self, line: serial.Serial) -> None:
        """Read from an open line until it is lost or the process stops."""
        self._splitter.feed(b"\n")
        last, self._quiet = time.monotonic(), 0.0
        with self._lock:
            self._line = line
        try:
            while not self._stop.is_set():
                data, now = line.read(max(1, line.in_waiting)), time.monotonic()
                # A turn that took longer was a delay of this process, not a silence of the controller.
                self._quiet += min(now - last, 2.0 * _READ_TIMEOUT)
                last = now
                self._on_data(data, now)
                if self._quiet > QUIET_LINE:
                    self._wait_for(f"{self._port} is open, but no valid telemetry comes; check controller and --baud")
        except OSError:
            pass  # lost
        finally:
            # Nobody may write while the line closes: pyserial would fail on its own half-closed state.
            with self._lock:
                self._line = None
                if self._stop.is_set() and self._accepted:
                    self._send(line, 0.0, 0.0)

    def _send(self, line: serial.Serial, left: float, right: float) -> None:
        try:
            line.write(encode_line(PowerLine(round(1000.0 * left), round(1000.0 * right))))
        except OSError:
            self._unwritten += 1

    def _on_data(self, data: bytes, now: float) -> None:
        for line in self._splitter.feed(data):
            try:
                message = decode_line(line)
            except WireError:
                self._garbage += 1
                continue
            if isinstance(message, PositionFix):
                self._fix = message.to_fix()
            elif isinstance(message, Telemetry):
                self._readings.append(self._reading(message, now))
                self._quiet, self._reason = 0.0, ""
                self.connected.set()

    def _reading(self, telemetry: Telemetry, now: float) -> Reading:
        fix, self._fix = self._fix, None
        joystick = telemetry.joystick
        if telemetry.boot != self._boot:
            self._boot = telemetry.boot
            for counter in (self._seq, self._ms, self._left, self._right):
                counter.reset()
        return Reading(
            epoch=str(telemetry.boot),
            seq=self._seq.extend(telemetry.seq),
            stamp=self._ms.extend(telemetry.ms) / 1000.0,
            received=now,
            left=self._left.extend(telemetry.left),
            right=self._right.extend(telemetry.right),
            proximity=tuple(_range(sonar, value) for sonar, value in zip(self._sonars, telemetry.ranges, strict=False)),
            fix=fix,
            battery=telemetry.battery / 1000.0,
            forward=None if joystick is None else joystick[0] / 1000.0,
            turn=None if joystick is None else joystick[1] / 1000.0,
        )


def _in_words(error: OSError) -> str:
    """Return the reason alone: pyserial's text repeats the device and wraps another error."""
    return os.strerror(error.errno) if error.errno is not None else str(error)[:200]


def _range(sonar: Proximity, value: int | str) -> ProximityReading:
    if isinstance(value, int):
        return ProximityReading(id=sonar.id, value=value / 1000.0)
    return ProximityReading(id=sonar.id, status=_STATUS[value])  # type: ignore[arg-type]
