"""The driver `luci`: a chair with a LUCI unit on its network. The only file that knows grpc.

One thread keeps a connection and opens it again whenever it is lost or silent. Each stream of the chair has a thread;
another one sends overrides of the joystick, one at a time, so that an old one never arrives after a newer one.

Nothing is sent before the simulator has accepted the bridge. `CHAIRS.md` describes values, frames and assumptions.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from intellwheels_agents.bridge.fault_notes import FaultNotes
from intellwheels_agents.bridge.hardware_driver import Reading, RealHardware
from intellwheels_agents.bridge.line_lock import LineLock, names_of
from intellwheels_agents.bridge.luci_readings import (
    STICK,
    Point,
    WheelTurns,
    motion_of,
    nearest,
    points_of,
    stick_of,
)
from intellwheels_agents.bridge.luci_schema import AUTONOMOUS_REMOTE, IMU_MPU, SERVICE, message, parsed
from intellwheels_agents.bridge.override_check import OverrideCheck
from intellwheels_agents.bridge.timeouts import (
    CONNECT_TIMEOUT,
    CONTROLLER_WATCHDOG,
    POWER_PERIOD,
    QUIET_LINE,
    REOPEN_PERIOD,
    STREAM_TIMEOUT,
)
from intellwheels_agents.bridge.wrapping_counter import WrappingCounter
from intellwheels_agents.user_input import unmixed
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.process import start_network_thread

if TYPE_CHECKING:
    import grpc

MAX_READINGS: Final = 6000
"""Readings kept until they are read: a minute at 100 Hz."""
MAX_MESSAGE: Final = 256 * 1024
"""Bytes of the largest message that is read; one with 1000 radar points has 45 kB."""
CALL_TIMEOUT: Final = 0.2
"""Seconds after which an override counts as not delivered."""
_SLICE: Final = 0.05
_OPTIONS: Final = (
    ("grpc.max_receive_message_length", MAX_MESSAGE),
    ("grpc.enable_http_proxy", 0),
    # The system drops a connection on which nothing is acknowledged, and with it the overrides that still wait there.
    # Otherwise they would reach the chair when the network returns. No more pings than the default of a server allows.
    ("grpc.keepalive_time_ms", 300_000),
    ("grpc.keepalive_timeout_ms", round(1000.0 * QUIET_LINE)),
    # Each connection makes its own attempt: this driver does the waiting between two.
    ("grpc.use_local_subchannel_pool", 1),
)


class LuciDriver(RealHardware):
    """The driver `luci`."""

    def __init__(
        self,
        address: str,
        chair: Robot,
        stop: threading.Event,
        *,
        centre: int = STICK,
        reversed_wheels: Sequence[str] = (),
        waiting: Callable[[str], None] = lambda _reason: None,
        tell: Callable[[str], None] = lambda _text: None,
    ) -> None:
        """Prepare to connect.

        Args:
            address: HOST:PORT of the unit.
            chair: Gives the sonars, the counts of a turn and the top speed of the wheels.
            stop: Ends every thread, and is set when the driver gives up.
            centre: The override on the wire of a joystick at rest.
            reversed_wheels: Those of `left` and `right` whose encoder counts down forward.
            waiting: Called with the reason whenever the driver starts to wait for the unit or its encoders.
            tell: Called with what was wrong with a message, once for each kind.
        """
        super().__init__(stop, waiting, MAX_READINGS)
        self._address = address
        self._sonars = chair.proximity
        # Longer silences may hide half a turn of a wheel, after which its angle no longer tells how far it turned.
        self._longest_gap = 0.5 * math.pi * chair.wheel_diameter / max(chair.top_speed, 0.1)
        self._centre = centre
        self._faults = FaultNotes(tell)
        self._locks: list[LineLock] = []
        self._accepted = threading.Event()
        self._turns = WheelTurns(chair.encoder_ticks, frozenset(reversed_wheels))
        self._edge = WrappingCounter()
        self._encoders_at: float | None = None
        self._epoch = self._seq = 0
        self._points: dict[str, tuple[float, list[Point]]] = {}
        self._motion: tuple[float, tuple[float, float, float]] | None = None
        self._stick: tuple[float, tuple[float, float]] | None = None
        self._lock = threading.Lock()
        self._power = (0.0, 0.0)
        self._power_at = float("-inf")
        self._new_power = threading.Event()
        self._check = OverrideCheck()
        self._heard_at = 0.0
        self._opened = self._unsent = 0
        self._refused: set[str] = set()
        self._tell = tell
        self._thread: threading.Thread | None = None

    # ------------------------------------------------------------ the driver

    def start(self) -> None:
        """Start looking for the unit, unless another bridge on this machine uses it."""
        self._locks = [LineLock(f"luci/{name}") for name in names_of(self._address)]
        if not all(lock.take() for lock in self._locks):
            self._fail(f"{self._address} is in use by another iw-bridge")
            return
        self._thread = start_network_thread("luci", self._run)

    def write(self, left: float, right: float) -> None:
        """Set the motor powers. The thread that sends overrides takes them."""
        power = unmixed(left, right)
        changed = power != self._power
        self._power, self._power_at = power, time.monotonic()
        if changed:
            self._new_power.set()

    def begin_run(self, run: str) -> None:  # noqa: ARG002 - as `Driver` has it
        """Allow sending: the simulator has accepted the bridge."""
        self._accepted.set()

    def faults(self) -> dict[str, int]:
        """Return the number of faults so far, by name."""
        return {"garbage": self._faults.count, "reopened": max(self._opened - 1, 0), "unwritten": self._unsent}

    def close(self) -> None:
        """Wait for the threads to end. If overrides were sent, the last one is the centre. `stop` is set already."""
        if self._thread is not None:
            self._thread.join(timeout=2.0)
        for lock in self._locks:
            lock.release()

    # ------------------------------------------------------------ the connection

    def _run(self) -> None:
        import grpc  # noqa: PLC0415 - an optional dependency, which agents do not need

        while not self._stop.is_set():
            with grpc.insecure_channel(self._address, options=_OPTIONS) as channel:
                self._heard_at = 0.0
                self._use(channel)
            self._stop.wait(REOPEN_PERIOD)

    def _use(self, channel: grpc.Channel) -> None:
        """Use a connection until it is lost, silent, or the process stops."""
        ended, began = threading.Event(), time.monotonic()
        streams: tuple[tuple[str, str, dict[str, int], str, Callable[[Any], None]], ...] = (
            ("EncoderStream", "Empty", {}, "EncoderData", self._on_encoders),
            ("ImuStream", "ImuCtrl", {"imu": IMU_MPU}, "ImuData", self._on_imu),
            ("UltrasonicStream", "Empty", {}, "UltrasonicDistances", self._on_ultrasonic),
            ("RadarStream", "Empty", {}, "RadarPoints", self._on_radar),
            ("UserJoystickStream", "Empty", {}, "JoystickData", self._on_user_joystick),
            ("ActiveScalingStream", "Empty", {}, "ActiveScaling", self._on_active_scaling),
        )
        # A thread that is inside grpc when Python ends may abort the process.
        threads = [start_network_thread(one[0], partial(self._read, channel, ended, *one)) for one in streams]
        threads.append(start_network_thread("overrides", partial(self._steer, channel, ended)))
        while not (self._stop.is_set() or ended.wait(_SLICE)):
            now = time.monotonic()
            if now - max(self._heard_at, began) > QUIET_LINE:
                self._wait_for(f"{self._address} sends no valid encoder data; check the encoder board of the chair")
                # A connection takes its time; one that has worked is made anew at once.
                if self._heard_at > 0.0 or now - began > CONNECT_TIMEOUT:
                    break
        ended.set()
        self._new_power.set()
        threads[-1].join(timeout=1.0)  # its last override must leave before the connection closes
        channel.close()
        for thread in threads[:-1]:
            thread.join(timeout=1.0)

    def _read(
        self,
        channel: grpc.Channel,
        ended: threading.Event,
        method: str,
        request: str,
        fields: dict[str, int],
        kind: str,
        handle: Callable[[Any], None],
    ) -> None:
        """Read a stream until the connection ends; a stream that ends alone is opened again."""
        import grpc  # noqa: PLC0415

        call = channel.unary_stream(SERVICE + method)
        while not ended.is_set():
            try:
                # The bytes are parsed here: grpc would end the stream at the first malformed message.
                for data in call(message(request, **fields).SerializeToString()):
                    try:
                        handle(parsed(kind, data))
                    except WireError as error:
                        self._faults.add(error)
                    if ended.is_set():
                        return
            except (grpc.RpcError, ValueError) as error:  # a closed channel is a ValueError
                if ended.is_set() or not isinstance(error, grpc.RpcError):
                    return
                code = error.code()
                if code == grpc.StatusCode.UNIMPLEMENTED and method != "EncoderStream":
                    self._faults.add(WireError("value", f"{method}: the chair does not have it", method))
                    return
                if code == grpc.StatusCode.RESOURCE_EXHAUSTED:
                    text = f"{kind}: expected a message of at most {MAX_MESSAGE} bytes: {error.details()}"
                    self._faults.add(WireError("too-long", text, f"{kind} size"))
                elif method == "EncoderStream":
                    why = "nobody answers" if code == grpc.StatusCode.UNAVAILABLE else f"{code.name.lower()}"
                    self._wait_for(f"{why} at {self._address}")
            if method == "EncoderStream":
                ended.set()
                return
            ended.wait(REOPEN_PERIOD)

    # ------------------------------------------------------------ overrides

    def _steer(self, channel: grpc.Channel, ended: threading.Event) -> None:
        """Send overrides from the join on until the connection ends; at the end the centre, if the process stops."""
        import grpc  # noqa: PLC0415

        def call(method: str, request: str, **fields: int) -> bool:
            sent = message(request, source=AUTONOMOUS_REMOTE, **fields).SerializeToString()
            try:
                channel.unary_unary(SERVICE + method)(sent, timeout=CALL_TIMEOUT)
            except ValueError:  # a closed channel
                return False
            except grpc.RpcError as error:
                code = error.code()
                if method not in self._refused and code.name not in ("CANCELLED", "UNAVAILABLE"):
                    self._refused.add(method)
                    self._tell(f"{method}: expected the unit to accept it, got {code.name.lower()}: {error.details()}")
                return False
            return True

        def override(forward: float, turn: float) -> None:
            now = time.monotonic()
            with self._lock:
                self._check.sent(forward, turn, now)
            values = {
                "forward_back": self._centre + round(STICK * forward),
                "left_right": self._centre - round(STICK * turn),
            }
            self._unsent += not call("JsOverride", "RemoteJsValues", **values)

        while not self._accepted.wait(_SLICE):
            if ended.is_set() or self._stop.is_set():
                return
        has_source = False
        while not (ended.is_set() or self._stop.is_set()):
            has_source = has_source or call("AddInputSource", "InputSourceRequest")
            if has_source:
                override(*self._in_force())
            self._new_power.wait(POWER_PERIOD)
            self._new_power.clear()
        if has_source and self._stop.is_set():
            # After a wrong answer to the check, nobody knows what the chair takes for the centre.
            if self.failure is None:
                override(0.0, 0.0)
            call("RemoveInputSource", "InputSourceRequest")

    def _in_force(self) -> tuple[float, float]:
        """Return forward and turn; zero if the bridge's own writer has stopped."""
        return self._power if time.monotonic() - self._power_at <= CONTROLLER_WATCHDOG else (0.0, 0.0)

    # ------------------------------------------------------------ the streams

    def _on_active_scaling(self, message: Any) -> None:
        joystick = message.joystick
        if joystick.source != AUTONOMOUS_REMOTE or not self._accepted.is_set():
            return
        # A value out of range is no reason to drop the report: a wrong centre may cause it.
        forward, turn = joystick.forward_back / STICK, -joystick.left_right / STICK
        with self._lock:
            is_explained = self._check.is_explained(forward, turn, time.monotonic())
        if not is_explained and self.failure is None:
            self._fail(
                f"the chair drives with forward {forward:g} and turn {turn:g}, which this bridge did not send: another "
                f"program steers it, or its joystick does not rest at {self._centre} (--joystick-centre)"
            )

    def _on_user_joystick(self, message: Any) -> None:
        self._stick = time.monotonic(), stick_of(message, "JoystickData")

    def _on_imu(self, message: Any) -> None:
        if message.source != IMU_MPU:  # the one in the footplate
            return
        self._motion = time.monotonic(), motion_of(message)

    def _on_ultrasonic(self, message: Any) -> None:
        self._points["ultrasonic"] = time.monotonic(), points_of(message, "UltrasonicDistances")

    def _on_radar(self, message: Any) -> None:
        self._points[f"radar {message.source % 4}"] = time.monotonic(), points_of(message, "RadarPoints")

    def _on_encoders(self, message: Any) -> None:
        now, edge = time.monotonic(), message.edge_timestamp
        stamp = self._stamp(edge, now)
        try:
            left, right = self._turns.update(message.left_angle, message.right_angle)
        except WireError:
            self._encoders_at = None if self._turns.is_lost else self._encoders_at
            raise
        self._encoders_at = stamp
        self._seq += 1
        stick = _fresh(self._stick, now)
        self._readings.append(
            Reading(
                epoch=str(self._epoch), seq=self._seq, stamp=stamp, received=now, left=left, right=right,
                proximity=nearest(self._sonars, self._fresh_points(now)),
                forward=None if stick is None else stick[0],
                turn=None if stick is None else stick[1],
                motion=_fresh(self._motion, now),
            )
        )  # fmt: skip
        if self._heard_at == 0.0:
            self._opened += 1
        self._heard_at, self._reason = now, ""
        self.connected.set()

    def _stamp(self, edge: int, now: float) -> float:
        """Return the time of a message in seconds: of the encoder board's clock, or of arrival if it has none.

        A new epoch begins if the board has restarted, or a wheel may have made half a turn unseen.
        """
        last = self._encoders_at
        restarted = edge > 0 and self._edge.is_behind(edge)
        stamp = self._edge.extend(edge) / 1000.0 if edge > 0 else now
        if last is None or restarted or stamp - last > self._longest_gap:
            self._epoch += 1
            self._turns.forget_angles()
            if restarted:
                self._edge.reset()
                stamp = self._edge.extend(edge) / 1000.0
        return stamp

    def _fresh_points(self, now: float) -> list[Point] | None:
        """Return the newest points of every sensor, or None when no sensor sends any."""
        fresh = [points for at, points in list(self._points.values()) if now - at <= STREAM_TIMEOUT]
        return [point for points in fresh for point in points] if fresh else None


def _fresh(stamped: tuple[float, Any] | None, now: float) -> Any:
    return stamped[1] if stamped is not None and now - stamped[0] <= STREAM_TIMEOUT else None
