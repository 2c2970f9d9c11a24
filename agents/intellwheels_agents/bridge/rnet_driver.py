"""The driver `rnet`: a chair with R-Net electronics, on its CAN bus. One of the two files that know python-can.

It listens. The pose is dead reckoning from the joystick and the speed setting, because the bus has no encoders.

With `inject`, it also drives: directly after each frame of a joystick at rest it sends a frame of the same identifier
with the simulator's power, and the motors obey the newer one. This makes a driver that stops by silence: without a new
power, without a joystick module, or while a person deflects the joystick, nothing is sent, and the joystick's own
frames are in force within 10 ms. Nothing is sent before the simulator has accepted the bridge either.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from intellwheels_agents.bridge.chair_joystick import DEAD_ZONE
from intellwheels_agents.bridge.fault_notes import FaultNotes
from intellwheels_agents.bridge.hardware_driver import Reading, RealHardware
from intellwheels_agents.bridge.line_lock import LineLock
from intellwheels_agents.bridge.rnet_frames import (
    BITRATE,
    FILTERS,
    Battery,
    Content,
    Frame,
    MotorCurrent,
    SpeedLimit,
    Stick,
    decode_frame,
    joystick_frame,
)
from intellwheels_agents.bridge.stick_motion import StickMotion
from intellwheels_agents.bridge.timeouts import (
    CONTROLLER_WATCHDOG,
    INTERRUPTION,
    QUIET_LINE,
    REOPEN_PERIOD,
    STATUS_PERIOD,
)
from intellwheels_agents.user_input import unmixed
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Robot

if TYPE_CHECKING:
    import can

MAX_READINGS: Final = 3000
"""Readings kept until they are read: a minute at 50 Hz."""
READING_PERIOD: Final = 0.02
"""Seconds from one reading to the next: every second frame of the joystick."""
ECHO_TIME: Final = 0.2
"""Seconds in which a frame that was sent may come back."""
MAX_ERRORS: Final = 10
"""Errors of the bus in a row after which it is opened again. A stranger's bytes make single ones."""
MAX_BATCH: Final = 1000
"""Frames that are taken at once. After so many there may be newer ones."""
_READ_TIMEOUT: Final = 0.05
_ECHOING: Final = ("udp_multicast",)
"""Interfaces of python-can that hand back what was sent, and cannot be told not to."""


class RnetDriver(RealHardware):
    """The driver `rnet`."""

    def __init__(
        self,
        interface: str,
        channel: str,
        chair: Robot,
        stop: threading.Event,
        *,
        options: Mapping[str, Any] | None = None,
        inject: bool = False,
        waiting: Callable[[str], None] = lambda _reason: None,
        tell: Callable[[str], None] = lambda _text: None,
        status: Callable[[str], None] = lambda _line: None,
    ) -> None:
        """Prepare to open a bus.

        Args:
            interface: The kind of CAN adapter, as python-can names it.
            channel: The bus, such as can0.
            chair: Gives what dead reckoning needs: top speed, acceleration, wheels.
            stop: Ends the thread, and is set when the driver gives up.
            options: Further options of python-can for this kind of adapter.
            inject: Whether to drive. Without it, nothing is ever sent.
            waiting: Called with the reason whenever the driver starts to wait for the bus or its joystick.
            tell: Called with what was wrong with a frame, once for each kind.
            status: Called with a line about battery, speed setting and motor current.
        """
        super().__init__(stop, waiting, MAX_READINGS)
        self._interface = interface
        self._channel = channel
        self._options = dict(options or {})
        self._inject = inject
        self._status = status
        self._tell = tell
        self._faults = FaultNotes(tell)
        self._lock_of_chair = LineLock(f"rnet/{interface}/{channel}")
        self._accepted = False
        self._motion = StickMotion(chair)
        self._power = (0.0, 0.0)
        self._power_at = float("-inf")
        self._sent: deque[tuple[float, Frame]] = deque(maxlen=1000)
        self._deflected_at = float("-inf")
        self._device: int | None = None
        self._heard_at = self._read_at = 0.0
        self._battery: int | None = None
        self._current = 0
        self._said: tuple[float, str] = (float("-inf"), "")
        self._seq = self._opened = self._injected = self._unsent = 0
        self._thread = threading.Thread(target=self._run, name="rnet", daemon=True)

    # ------------------------------------------------------------ the driver

    def start(self) -> None:
        """Start to listen, unless another bridge on this machine uses the bus."""
        if not self._lock_of_chair.take():
            self._fail(f"{self._channel} is in use by another iw-bridge")
            return
        self._thread.start()

    def write(self, left: float, right: float) -> None:
        """Set the motor powers. The thread of the bus sends them, if it may."""
        self._power = unmixed(left, right)
        self._power_at = time.monotonic()

    def begin_run(self, run: str) -> None:  # noqa: ARG002 - as `Driver` has it
        """Allow sending: the simulator has accepted the bridge."""
        self._accepted = True

    def faults(self) -> dict[str, int]:
        """Return the number of faults so far, by name, and of injected frames."""
        return {
            "garbage": self._faults.count,
            "reopened": max(self._opened - 1, 0),
            "unwritten": self._unsent,
            "injected": self._injected,
        }

    def close(self) -> None:
        """Wait for the thread to end. The chair stops because nothing more is sent. `stop` is set already."""
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)
        self._lock_of_chair.release()

    # ------------------------------------------------------------ the bus

    def _run(self) -> None:
        import can  # noqa: PLC0415 - an optional dependency, which agents do not need

        while not self._stop.is_set():
            try:
                bus = can.Bus(
                    interface=self._interface, channel=self._channel, bitrate=BITRATE, can_filters=FILTERS,
                    **self._options,
                )  # fmt: skip
            except Exception as error:  # the library of an adapter may raise anything
                may_pass = isinstance(error, (can.CanError, OSError))
                if not may_pass or isinstance(error, can.CanInterfaceNotImplementedError):
                    # The adapter's kind or its options are wrong: waiting does not help.
                    used = f"python-can cannot use {self._interface}"
                    self._fail(f"--interface, --can-option: {used}: {_in_words(error)}")
                    return
                self._wait_for(f"cannot open {self._channel}: {_in_words(error)}")
                self._stop.wait(REOPEN_PERIOD)
                continue
            self._opened += 1
            with bus:
                self._use(bus)
            self._stop.wait(REOPEN_PERIOD)

    def _use(self, bus: can.BusABC) -> None:
        """Read from an open bus until it is lost or the process stops."""
        self._heard_at, errors = time.monotonic(), 0
        batch: list[can.Message] = []
        while not self._stop.is_set():
            try:
                received = bus.recv(0.0 if batch else _READ_TIMEOUT)
                errors = 0
            except Exception as error:  # a stranger's bytes must not end this thread
                errors += 1
                self._faults.add(WireError("malformed", f"CAN bus: {_in_words(error)}", "CAN bus"))
                if errors >= MAX_ERRORS:
                    return
                continue
            if received is not None:
                batch.append(received)
                if len(batch) < MAX_BATCH:
                    continue
            now = time.monotonic()
            self._on_batch(bus, batch, now)
            batch = []
            if now - self._heard_at > QUIET_LINE:
                self._wait_for(f"{self._channel} is open, but no joystick frames come; is the chair on, at 125 kbit/s?")

    def _on_batch(self, bus: can.BusABC, batch: list[can.Message], now: float) -> None:
        """Take all frames that had arrived, in order. Only the newest frame of a joystick may be followed by a power.

        After a pause of this process old frames at rest come first, and the person may have moved the joystick since.
        """
        contents = [content for received in batch if (content := self._content(received, now)) is not None]
        sticks = [content for content in contents if isinstance(content, Stick)]
        if any(_is_deflected(stick) for stick in sticks):
            self._deflected_at = now
        newest = {stick.device: stick for stick in sticks} if len(batch) < MAX_BATCH else {}
        for content in contents:
            if isinstance(content, Stick):
                self._on_stick(bus, content, now, is_newest=content is newest.get(content.device))
            else:
                self._note(content)
        if contents:
            self._say(now)

    def _content(self, received: can.Message, now: float) -> Content | None:
        """Return what a frame says, or None for an own one that came back, and for one that says nothing."""
        is_plain = received.is_extended_id and not (
            received.is_remote_frame or received.is_error_frame or received.is_fd
        )
        frame = Frame(received.arbitration_id, bytes(received.data), is_plain)
        if self._is_echo(frame, now):
            return None
        try:
            return decode_frame(frame)
        except WireError as error:
            self._faults.add(error)
            return None

    def _is_echo(self, frame: Frame, now: float) -> bool:
        """Return whether a frame is one that this driver sent."""
        if self._interface not in _ECHOING:
            return False
        while self._sent and now - self._sent[0][0] > ECHO_TIME:
            self._sent.popleft()
        for entry in self._sent:
            if entry[1] == frame:
                self._sent.remove(entry)
                return True
        return False

    def _on_stick(self, bus: can.BusABC, stick: Stick, now: float, *, is_newest: bool) -> None:
        forward, turn = stick.forward, stick.turn
        is_at_rest = not _is_deflected(stick)
        if self._device is None or now - self._heard_at > QUIET_LINE:
            self._device = stick.device
        if stick.device != self._device:  # an attendant's joystick: its deflection counts, its rest does not
            if not is_at_rest:
                self._motion.obey(forward, turn)
            return
        injected = self._injection(now) if is_at_rest and is_newest else None
        if injected is not None and self._send(bus, joystick_frame(stick.device, *injected), now):
            self._motion.obey(*injected)
        else:
            self._motion.obey(forward, turn)
        self._heard_at, self._reason = now, ""
        left, right = self._motion.advance(now)
        if now - self._read_at < 0.9 * READING_PERIOD:
            return
        self._read_at = now
        self._seq += 1
        self._readings.append(
            Reading(
                epoch="1", seq=self._seq, stamp=now, received=now, left=left, right=right, forward=forward, turn=turn
            )
        )
        self.connected.set()

    def _injection(self, now: float) -> tuple[float, float] | None:
        """Return forward and turn to send after a frame of the joystick at rest, or None for nothing."""
        if not (self._inject and self._accepted) or self._stop.is_set():
            return None
        if now - self._power_at > CONTROLLER_WATCHDOG or self._power == (0.0, 0.0):
            return None
        # A person has just steered: the chair does not drive on at once when the joystick is let go.
        return None if now - self._deflected_at < INTERRUPTION else self._power

    def _send(self, bus: can.BusABC, frame: Frame, now: float) -> bool:
        import can  # noqa: PLC0415

        try:
            bus.send(can.Message(arbitration_id=frame.identifier, is_extended_id=True, data=frame.data), timeout=0.005)
        except Exception as error:  # as in `_use`
            if self._unsent == 0:
                self._tell(f"a frame could not be sent; is {self._channel} in listen-only mode? {_in_words(error)}")
            self._unsent += 1
            return False
        self._injected += 1
        self._sent.append((now, frame))
        return True

    def _note(self, content: Content) -> None:
        match content:
            case SpeedLimit(share):
                self._motion.speed_limit = share
            case Battery(percent):
                self._battery = percent
            case MotorCurrent(value):
                self._current = max(self._current, value)

    def _say(self, now: float) -> None:
        """Report battery, speed setting and motor current, if one has changed."""
        if now - self._said[0] < STATUS_PERIOD or self._battery is None:
            return
        speed = round(100.0 * self._motion.speed_limit)
        line = f"battery={self._battery} speed={speed} current_max={self._current}"
        if line != self._said[1]:
            self._said = (now, line)
            self._status(line)
            self._current = 0


def _is_deflected(stick: Stick) -> bool:
    return max(abs(stick.forward), abs(stick.turn)) >= DEAD_ZONE


def _in_words(error: Exception) -> str:
    return (str(error) or type(error).__name__)[:200]
