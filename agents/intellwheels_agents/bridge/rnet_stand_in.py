"""A stand-in for a chair with R-Net electronics on a CAN bus: its joystick module and its motors.

    python -m intellwheels_agents.bridge.rnet_stand_in --interface udp_multicast --channel 239.74.163.2
    iw-bridge rnet --interface udp_multicast --channel 239.74.163.2 ...

It sends the frames that `rnet_frames.py` lists. Its motors obey the newest joystick frame of a period of 10 ms, whoever
sent it, and stop 0.2 s after the last one. Faults are commanded on standard input or a named pipe; `FAULTS` lists them.
Standard output has `ready channel=...`, and `moving ms=...`, `stopped ms=... silence=...` as they happen, as of the
firmware stand-in.
"""

from __future__ import annotations

import argparse
import random
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from intellwheels_agents.bridge.command_pipe import CommandPipe
from intellwheels_agents.bridge.joystick_chair import JoystickChair
from intellwheels_agents.bridge.rnet_frames import (
    BATTERY,
    BITRATE,
    CURRENT,
    FULL,
    HEARTBEAT,
    JOYSTICK,
    SPEED,
    Frame,
    Stick,
    decode_frame,
    joystick_frame,
)
from intellwheels_agents.bridge.rnet_options import add_bus_options, bus_options, check_bus
from intellwheels_schemas.command_parser import CommandParser, number, readable_file, whole
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.process import add_process_options, stop_on_signals

PROGRAM: Final = "python -m intellwheels_agents.bridge.rnet_stand_in"
PERIOD: Final = 0.01
"""Seconds between two frames of the joystick."""
SMOOTHING: Final = 0.05
"""Seconds within which the motors take the strongest deflection: their inertia bridges single frames at rest."""
FAULTS: Final = """\
faults and other events, one a line:
  stick F T       the user deflects the joystick forward by F and to the left by T, in [-100, 100]
  speed P         the user chooses a top speed of P percent
  battery P       the battery has P percent
  silence S       the joystick module sends nothing for S seconds
  count           print how many frames on the bus were not its own: `foreign frames=N`
  garbage S       frames with wrong lengths and values are on the bus for S seconds
"""


class RnetChair:
    """The chair without its bus: frames in, frames out, the time as an argument. Pure but for its random garbage.

    Attributes:
        chair: Its motors.
        foreign: Number of frames that came from others.
    """

    def __init__(self, device: int, top_speed: float) -> None:
        self.chair = JoystickChair(top_speed)
        self.foreign = 0
        self._device = device
        self._stick = (0.0, 0.0)
        self._speed, self._battery = 100, 87
        self._until: dict[str, float] = {}
        self._next = dict.fromkeys(("joystick", "heartbeat", "slow"), 0.0)
        self._own: deque[Frame] = deque(maxlen=1000)
        self._sticks: deque[tuple[float, float, float]] = deque(maxlen=100)
        self._random = random.Random(1)  # noqa: S311 - garbage, not secrets

    def command(self, line: str) -> None:
        """Obey a line of standard input.

        Raises:
            ValueError: It is none of `FAULTS`.
        """
        word, *numbers = line.split() or [""]
        values = [float(text) for text in numbers]
        match word, values:
            case "silence" | "garbage", [seconds]:
                self._until[word] = self.chair.clock + seconds
            case "stick", [forward, left]:
                self._stick = forward / FULL, left / FULL
            case "speed", [percent]:
                self._speed = int(percent)
            case "battery", [percent]:
                self._battery = int(percent)
            case "count", []:
                self.chair.messages.append(f"foreign frames={self.foreign}")
            case _:
                raise ValueError(line)

    def receive(self, frame: Frame) -> None:
        """Take a frame from the bus; one that this chair sent comes back on some buses, and counts once."""
        if frame in self._own:
            self._own.remove(frame)
            return
        self.foreign += 1
        try:
            content = decode_frame(frame)
        except WireError:
            return
        if isinstance(content, Stick) and content.device == self._device:
            self._sticks.append((self.chair.clock, content.forward, content.turn))

    def step(self, seconds: float) -> list[Frame]:
        """Advance by some seconds; return the frames to send."""
        now = self.chair.clock + seconds
        frames = []
        if not self._has("silence"):
            if self._is_due("joystick", PERIOD, now):
                frames.append(joystick_frame(self._device, *self._stick))
                self._sticks.append((now, *self._stick))
            if self._is_due("heartbeat", 0.1, now):
                frames.append(Frame(HEARTBEAT, b"\x87" * 8))
        if self._is_due("slow", 1.0, now):
            device = self._device << 8
            frames.append(Frame(SPEED | device, bytes([self._speed])))
            frames.append(Frame(BATTERY | device, bytes([self._battery])))
            current = round(200.0 * max(abs(one) for one in self.chair.stick))
            frames.append(Frame(CURRENT | device, current.to_bytes(2, "little")))
        if self._has("garbage"):
            frames.append(self._garbage())
        self._own.extend(frames)
        self._obey(now)
        self.chair.step(seconds)
        return frames

    def _obey(self, now: float) -> None:
        while self._sticks and now - self._sticks[0][0] > SMOOTHING:
            self._sticks.popleft()
        if self._sticks:
            _, forward, turn = max(self._sticks, key=lambda one: max(abs(one[1]), abs(one[2])))
            share = self._speed / FULL
            self.chair.command(share * forward, share * turn)

    def _garbage(self) -> Frame:
        """Return a frame with a known identifier that is none of the known ones."""
        kinds = (JOYSTICK | 0x100, SPEED | 0x100, BATTERY | 0x100, CURRENT | 0x100, HEARTBEAT)
        while True:
            frame = Frame(self._random.choice(kinds), self._random.randbytes(self._random.randrange(9)))
            try:
                decode_frame(frame)
            except WireError:
                return frame

    def _has(self, fault: str) -> bool:
        return self._until.get(fault, 0.0) > self.chair.clock

    def _is_due(self, what: str, period: float, now: float) -> bool:
        if now < self._next[what]:
            return False
        self._next[what] = max(self._next[what] + period, now - period)
        return True


def parser() -> CommandParser:
    """Return the command line."""
    result = CommandParser(
        prog=PROGRAM,
        description="Play a chair with R-Net electronics on a CAN bus, for iw-bridge rnet.",
        epilog=FAULTS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_bus_options(result)
    result.add_argument(
        "--ask", type=readable_file, metavar="PIPE", help="named pipe to read faults from (default: standard input)"
    )
    result.add_argument(
        "--device", type=whole(0, 15), default=1, metavar="X", help="number of the joystick, in [0, 15] (default: 1)"
    )
    result.add_argument(
        "--top-speed", type=number("m/s", 0.1, 5.0), default=1.0, metavar="V",
        help="speed at full deflection, in m/s, in [0.1, 5] (default: 1)",
    )  # fmt: skip
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the stand-in and return its exit code."""
    command = parser()
    given = command.parse_args(arguments)
    if given.channel is None:
        command.error("--channel: expected a CAN bus such as can0, got none")
    lacking = missing_extra("rnet")
    if lacking is not None:
        _log(lacking)
        return 2
    try:
        check_bus(given.interface, given.channel)
        options = bus_options(given.can_option)
    except WireError as error:
        _log(error.text)
        return 2
    stop = stop_on_signals(given.lifeline)
    chair = RnetChair(given.device, given.top_speed)
    commands = CommandPipe(
        given.ask, chair.command, lambda line: _log(f"expected a fault and its numbers, got {line!r}")
    )
    try:
        _use_bus(given.interface, given.channel, options, chair, commands.poll, stop)
    except OSError as error:
        _log(str(error))
        return 1
    return 0


def _use_bus(
    interface: str,
    channel: str,
    options: Mapping[str, Any],
    chair: RnetChair,
    poll: Callable[[float], None],
    stop: threading.Event,
) -> None:
    import can  # noqa: PLC0415 - an optional dependency, which agents do not need

    def take(bus: can.BusABC) -> None:
        while True:
            try:
                received = bus.recv(0.0)
            except (can.CanError, ValueError):
                continue
            if received is None:
                return
            chair.receive(Frame(received.arbitration_id, bytes(received.data), received.is_extended_id))

    with can.Bus(interface=interface, channel=channel, bitrate=BITRATE, **options) as bus:
        _print(f"ready channel={channel}")
        last = time.monotonic()
        while not stop.is_set():
            poll(PERIOD / 4.0)
            take(bus)
            now = time.monotonic()
            for frame in chair.step(min(now - last, 2.0 * PERIOD)):
                bus.send(can.Message(arbitration_id=frame.identifier, is_extended_id=True, data=frame.data))
            last = now
            for line in chair.chair.take_messages():
                _print(line)


def _log(line: str) -> None:
    print(f"{PROGRAM}: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


if __name__ == "__main__":
    sys.exit(main())
