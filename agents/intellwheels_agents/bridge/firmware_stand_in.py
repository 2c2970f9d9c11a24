"""A stand-in for a chair's controller on a pseudo-terminal. Real firmware must do the same; copy what you need.

    python -m intellwheels_agents.bridge.firmware_stand_in --link /tmp/chair
    iw-bridge serial --port /tmp/chair ...

It sends telemetry 50 times a second and obeys motor powers. Its own watchdog stops the motors 0.2 s after the last
valid power, by its own clock, and trusts neither the line nor the bridge. `PROTOCOL.md` describes the lines.

Faults and other events are commanded on standard input or a named pipe; `FAULTS` lists them.
Standard output has `ready port=...`, `powered ms=...` at the first valid power since the start, `moving ms=...`, and
`stopped ms=... silence=...` when the motors stop: silence is -1 after a command, or the milliseconds since the last
valid power when the watchdog stopped them.
"""

from __future__ import annotations

import argparse
import os
import random
import select
import sys
import time
import tty
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from intellwheels_agents.bridge.line_protocol import (
    LineSplitter,
    Message,
    PositionFix,
    PowerLine,
    Telemetry,
    decode_line,
    encode_line,
)
from intellwheels_agents.bridge.timeouts import CONTROLLER_WATCHDOG
from intellwheels_agents.bridge.wrapping_counter import MAX_SIGNED, MODULUS, to_signed, to_unsigned
from intellwheels_schemas.command_parser import CommandParser, number, readable_file, whole
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.output_paths import check_output_file
from intellwheels_schemas.process import add_process_options, stop_on_signals

PROGRAM: Final = "python -m intellwheels_agents.bridge.firmware_stand_in"
"""How it is started, and what its errors begin with."""
STEP: Final = 0.005
"""Seconds of one step of its loop. The watchdog fires a step early rather than late."""
MAX_STEP: Final = 0.02
"""Longest step of its clock, in seconds. A controller is never delayed, but this process may be."""
TELEMETRY_PERIOD: Final = 0.02
MOTOR_LAG: Final = 0.1
"""Seconds in which a wheel comes within 1/e of the commanded speed."""
FAULTS: Final = """\
faults and other events, one a line:
  cut S        no data passes for S seconds
  noise S      garbage passes in both directions for S seconds
  unplug S     the pseudo-terminal disappears for S seconds
  boot         the controller restarts
  stick F T    the joystick is at forward F and turn T, in thousandths
  fix X Y SD   the controller sends a position and its standard deviation, in mm

Standard output has `ready port=...`, `powered ms=...` at the first valid power, `moving ms=...` when the motors start,
and `stopped ms=... silence=...` when they stop: silence is the time in ms since the last command if the watchdog
stopped them, and -1 if a command did.
"""


class Controller:
    """The controller without its terminal: bytes in, bytes out, the time as an argument. Pure.

    Attributes:
        clock: Seconds since its start.
        power: Motor powers, in thousandths.
        joystick: Forward and turn, in thousandths, or None without one.
        messages: Lines for people, not yet printed.
    """

    def __init__(self, boot: int, sonars: int, counts: float, wrap_in: float | None = None) -> None:
        """Start.

        Args:
            boot: A number that differs at each start.
            sonars: Number of sonars; they see nothing.
            counts: Encoder counts a second at full power.
            wrap_in: Seconds after which all counters have wrapped, at half power or more; None to start at 0.
        """
        self.clock = 0.0
        self.power = (0, 0)
        self.joystick: tuple[int, int] | None = None
        self.messages: list[str] = []
        self._boot = boot
        self._sonars = sonars
        self._counts = counts
        self._splitter = LineSplitter()
        self._last_power = float("-inf")
        self._speed = [0.0, 0.0]
        self._travel = [0.0, 0.0]
        self._seq = self._ms_offset = self._count_offset = 0
        if wrap_in is not None:
            self._seq = MODULUS - round(wrap_in / TELEMETRY_PERIOD)
            self._ms_offset = MODULUS - round(1000.0 * wrap_in)
            self._count_offset = MAX_SIGNED - round(wrap_in * counts / 4.0)
        self._next_telemetry = 0.0

    def step(self, seconds: float, data: bytes) -> bytes:
        """Advance by some seconds, with the bytes received; return the bytes to send."""
        self.clock += seconds
        for line in self._splitter.feed(data):
            try:
                message = decode_line(line)
            except WireError:
                continue
            if isinstance(message, PowerLine):
                if self._last_power < 0.0:
                    self.messages.append(f"powered ms={round(1000.0 * self.clock)}")
                self._last_power = self.clock
                self._set_power((message.left, message.right), -1)
        silence = self.clock - self._last_power
        if silence + STEP >= CONTROLLER_WATCHDOG and self.power != (0, 0):
            self._set_power((0, 0), round(1000.0 * silence))
        self._move(seconds)
        if self.clock + STEP / 2.0 < self._next_telemetry:
            return b""
        # The next is due a period after this one was due, not after it was sent: a step is a quarter of the period.
        self._next_telemetry = max(self._next_telemetry + TELEMETRY_PERIOD, self.clock - TELEMETRY_PERIOD)
        self._seq += 1
        return encode_line(self._telemetry())

    def position_fix(self, x: int, y: int, sd: int) -> bytes:
        """Return the line of a position from outside, in millimetres."""
        return encode_line(PositionFix(self._boot, self._ms(), x, y, sd))

    def _set_power(self, power: tuple[int, int], silence: int) -> None:
        if power == (0, 0) and self.power != (0, 0):
            self.messages.append(f"stopped ms={round(1000.0 * self.clock)} silence={silence}")
        elif power != (0, 0) and self.power == (0, 0):
            self.messages.append(f"moving ms={round(1000.0 * self.clock)}")
        self.power = power

    def _move(self, seconds: float) -> None:
        share = min(1.0, seconds / MOTOR_LAG)
        for wheel in range(2):
            self._speed[wheel] += share * (self.power[wheel] / 1000.0 - self._speed[wheel])
            self._travel[wheel] += self._speed[wheel] * self._counts * seconds

    def _ms(self) -> int:
        return to_unsigned(round(1000.0 * self.clock) + self._ms_offset)

    def _telemetry(self) -> Message:
        left, right = (to_signed(round(travel) + self._count_offset) for travel in self._travel)
        seq = to_unsigned(self._seq)
        return Telemetry(self._boot, seq, self._ms(), left, right, 24_800, self.joystick, ("n",) * self._sonars)


class Terminal:
    """The pseudo-terminal."""

    def __init__(self, link: Path | None) -> None:
        self._link = link
        self.name = ""
        self._master = self._slave = -1
        self.plug()

    @property
    def is_plugged(self) -> bool:
        """Whether the terminal exists."""
        return self._master >= 0

    def plug(self) -> None:
        """Create the terminal, and point the link at it."""
        self._master, self._slave = os.openpty()
        # The slave stays open here too: otherwise reads from the master fail while no program is connected.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.name = os.ttyname(self._slave)
        if self._link is not None:
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(self.name)

    def unplug(self) -> None:
        """Remove the terminal and its link. The system may give its number to another terminal at once."""
        if self.is_plugged:
            if self._link is not None:
                self._link.unlink(missing_ok=True)
            os.close(self._master)
            os.close(self._slave)
            self._master = self._slave = -1

    def read(self) -> bytes:
        """Return the bytes received, without waiting."""
        if not self.is_plugged:
            return b""
        try:
            return os.read(self._master, 4096)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send bytes. Those that find no room are lost, as on any line."""
        if self.is_plugged and data:
            try:
                os.write(self._master, data)
            except BlockingIOError:
                return


class FaultyController:
    """A controller on its terminal, with the faults that were commanded."""

    def __init__(self, terminal: Terminal, sonars: int, counts: float, wrap_in: float | None = None) -> None:
        self._terminal = terminal
        self._boot = 1
        self._equipment = (sonars, counts)
        self.controller = Controller(self._boot, *self._equipment, wrap_in)
        self._random = random.Random(1)  # noqa: S311 - garbage, not secrets
        self._cut = self._noise = self._unplugged = 0.0

    def command(self, line: str) -> None:
        """Obey a line of standard input."""
        word, *numbers = line.split() or [""]
        try:
            values = [float(text) for text in numbers]
            whole_values = [int(value) for value in values]
        except (ValueError, OverflowError):
            word, values, whole_values = "", [], []
        match word, values:
            case "cut", [seconds]:
                self._cut = seconds
            case "noise", [seconds]:
                self._noise = seconds
            case "unplug", [seconds]:
                self._terminal.unplug()
                self._unplugged = seconds
            case "boot", []:
                self._boot += 1
                self.controller = Controller(self._boot, *self._equipment)
            case "stick", [_, _]:
                self.controller.joystick = (whole_values[0], whole_values[1])
            case "fix", [_, _, _]:
                self._terminal.write(self.controller.position_fix(*whole_values))
            case _:
                _log(f"expected cut, noise, unplug, boot, stick or fix with their numbers, got {line!r}")

    def step(self, seconds: float) -> list[str]:
        """Advance by some seconds; return the lines to print."""
        data = self._terminal.read()
        if self._noise > 0.0:
            data = self._garbled(data)
        if self._cut > 0.0:
            data = b""
        out = self.controller.step(seconds, data)
        if self._noise > 0.0:
            out = self._garbled(out)
        if self._cut <= 0.0:
            self._terminal.write(out)
        self._cut = max(0.0, self._cut - seconds)
        self._noise = max(0.0, self._noise - seconds)
        if self._unplugged > 0.0:
            self._unplugged -= seconds
            if self._unplugged <= 0.0:
                self._terminal.plug()
        messages, self.controller.messages = self.controller.messages, []
        return messages

    def _garbled(self, data: bytes) -> bytes:
        """Return bytes with noise: half of them replaced, and a few inserted in front."""
        noise = bytes(b if self._random.random() < 0.5 else self._random.randrange(256) for b in data)
        return noise + self._random.randbytes(self._random.randrange(4))


def parser() -> CommandParser:
    """Return the command line."""
    result = CommandParser(
        prog=PROGRAM,
        description="Play the controller of a chair on a pseudo-terminal, to which iw-bridge serial connects.",
        epilog=FAULTS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("--link", type=Path, metavar="PATH", help="make this symbolic link to the pseudo-terminal")
    result.add_argument(
        "--ask", type=readable_file, metavar="PIPE", help="named pipe to read faults from (default: standard input)"
    )
    result.add_argument(
        "--sonars", type=whole(0, 64), default=8, metavar="N", help="number of sonars, in [0, 64] (default: 8)"
    )
    result.add_argument(
        "--counts", type=number("a number", 0.0, 1e6, low_open=True), default=1730.0, metavar="N",
        help="encoder counts a second at full power (default: 1730, which is 1 m/s on 0.368 m wheels with 2000 a turn)",
    )  # fmt: skip
    result.add_argument(
        "--wrap-in",
        type=number("seconds", 0.0, 1e6),
        metavar="S",
        help="start with counters that all wrap within S seconds at half power",
    )
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the stand-in and return its exit code."""
    given = parser().parse_args(arguments)
    try:
        _check_link(given.link)
    except WireError as error:
        _log(error.text)
        return 2
    stop = stop_on_signals(given.lifeline)
    terminal = Terminal(given.link)
    controller = FaultyController(terminal, given.sonars, given.counts, given.wrap_in)
    _print(f"ready port={given.link or terminal.name}")
    # Opened for writing too, so that the pipe does not end with its first writer.
    source = os.open(given.ask, os.O_RDWR) if given.ask is not None else 0
    last = time.monotonic()
    is_open, rest = True, ""
    while not stop.is_set():
        if select.select([source] if is_open else [], [], [], STEP)[0]:
            data = os.read(source, 4096)
            is_open = bool(data)
            *lines, rest = (rest + data.decode("ascii", "replace")).split("\n")
            for line in lines:
                controller.command(line)
        now = time.monotonic()
        for line in controller.step(min(now - last, MAX_STEP)):
            _print(line)
        last = now
    terminal.unplug()
    if given.link is not None:
        given.link.unlink(missing_ok=True)
    return 0


def _check_link(link: Path | None) -> None:
    """Check that a symbolic link can be made. An old link of that name is replaced, a file is not.

    Raises:
        WireError: It cannot.
    """
    if link is not None and link.exists() and not link.is_symlink():
        raise WireError("value", f"--link: expected a path without a file, got {link}", "--link")
    if link is None or not link.is_symlink():
        check_output_file(link, "--link")


def _log(line: str) -> None:
    print(f"{PROGRAM}: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


if __name__ == "__main__":
    sys.exit(main())
