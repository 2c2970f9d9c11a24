"""A stand-in for a chair's controller, on a pseudo-terminal: what a lab's firmware must do, to be copied.

    python -m intellwheels_agents.bridge.firmware_stand_in --link /tmp/chair
    iw-bridge serial --port /tmp/chair ...

50 times a second it says its telemetry; it obeys powers, and gives none once 0.2 s passed without a valid one: its own
watchdog, by its own clock, which trusts neither the line nor the bridge. `PROTOCOL.md` has the lines.

Faults are asked for on standard input, or a named pipe, one a line: `cut S` (nothing passes for S seconds),
`noise S` (garbage both ways), `unplug S` (the terminal is gone), `boot` (counts begin anew), `stick F T`
(thousandths), `fix X Y SD` (mm).
On standard output: `ready port=...`, `moving ms=...`, and `stopped ms=... silence=...` when it stands by command
(silence -1) or by its watchdog (milliseconds since the last valid power).
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

from intellwheels_agents.bridge.line_protocol import Located, Message, PowerLine, Splitter, Telemetry, read, written
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.process import add_process_options, stop_on_signals

WATCHDOG: Final = 0.2
"""Seconds without a valid power after which the motors get none."""
TURN: Final = 0.005
"""Seconds of a turn of its loop; the watchdog fires a turn early rather than late."""
SLOWEST: Final = 0.02
"""Seconds its clock goes on in a turn at most: a controller is never kept waiting, this process may be."""
TELEMETRY: Final = 0.02
LAG: Final = 0.1
"""Seconds in which a wheel comes within 1/e of the speed asked for."""


class Controller:
    """The controller without its terminal: bytes in, bytes out, time passed in. Pure.

    Attributes:
        clock: Seconds since its start.
        power: What the motors give, in thousandths.
        told: Lines for people.
    """

    def __init__(self, boot: int, sonars: int, counts: float) -> None:
        """Start.

        Args:
            boot: A number that is another at each start.
            sonars: How many it has; they see nothing.
            counts: Encoder counts a second at full power.
        """
        self.clock = 0.0
        self.power = (0, 0)
        self.stick: tuple[int, int] | None = None
        self.told: list[str] = []
        self._boot = boot
        self._sonars = sonars
        self._counts = counts
        self._splitter = Splitter()
        self._heard = float("-inf")
        self._speed = [0.0, 0.0]
        self._rolled = [0.0, 0.0]
        self._seq = 0
        self._next = 0.0

    def turn(self, seconds: float, data: bytes) -> bytes:
        """Let so much time pass, with what came on the line; return what goes out."""
        self.clock += seconds
        for line in self._splitter.feed(data):
            try:
                message = read(line)
            except WireError:
                continue
            if isinstance(message, PowerLine):
                self._heard = self.clock
                self._give((message.left, message.right), -1)
        silence = self.clock - self._heard
        if silence + TURN >= WATCHDOG and self.power != (0, 0):
            self._give((0, 0), round(1000.0 * silence))
        self._roll(seconds)
        if self.clock + TURN / 2.0 < self._next:
            return b""
        # By its timetable, not by when it came to it: a turn is a quarter of that.
        self._next = max(self._next + TELEMETRY, self.clock - TELEMETRY)
        self._seq += 1
        return written(self._telemetry())

    def located(self, x: int, y: int, sd: int) -> bytes:
        """Return the line of a position from outside, in millimetres."""
        return written(Located(self._boot, round(1000.0 * self.clock), x, y, sd))

    def _give(self, power: tuple[int, int], silence: int) -> None:
        if power == (0, 0) and self.power != (0, 0):
            self.told.append(f"stopped ms={round(1000.0 * self.clock)} silence={silence}")
        elif power != (0, 0) and self.power == (0, 0):
            self.told.append(f"moving ms={round(1000.0 * self.clock)}")
        self.power = power

    def _roll(self, seconds: float) -> None:
        share = min(1.0, seconds / LAG)
        for wheel in range(2):
            self._speed[wheel] += share * (self.power[wheel] / 1000.0 - self._speed[wheel])
            self._rolled[wheel] += self._speed[wheel] * self._counts * seconds

    def _telemetry(self) -> Message:
        left, right = (round(rolled) for rolled in self._rolled)
        ms = round(1000.0 * self.clock)
        return Telemetry(self._boot, self._seq, ms, left, right, 24_800, self.stick, ("n",) * self._sonars)


class Terminal:
    """The pseudo-terminal, with its faults."""

    def __init__(self, link: Path | None) -> None:
        self._link = link
        self.name = ""
        self._ours = self._theirs = -1
        self.plug()

    @property
    def is_plugged(self) -> bool:
        """Whether there is a terminal."""
        return self._ours >= 0

    def plug(self) -> None:
        """Make a terminal, and let the link lead to it."""
        self._ours, self._theirs = os.openpty()
        # This side keeps the other's end open: without, its own reads fail while nobody is there.
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        self.name = os.ttyname(self._theirs)
        if self._link is not None:
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(self.name)

    def unplug(self) -> None:
        """Take the terminal away."""
        if self.is_plugged:
            os.close(self._ours)
            os.close(self._theirs)
            self._ours = self._theirs = -1

    def read(self) -> bytes:
        """Return what came, waiting no time."""
        if not self.is_plugged:
            return b""
        try:
            return os.read(self._ours, 4096)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send; what finds no room is lost, as on any line."""
        if self.is_plugged and data:
            try:
                os.write(self._ours, data)
            except BlockingIOError:
                return


class Bench:
    """The loop: time, terminal, controller, and the faults that are asked for."""

    def __init__(self, terminal: Terminal, sonars: int, counts: float) -> None:
        self._terminal = terminal
        self._boot = 1
        self._fit = (sonars, counts)
        self.controller = Controller(self._boot, *self._fit)
        self._random = random.Random(1)  # noqa: S311 - garbage, not secrets
        self._cut = self._noise = self._unplugged = 0.0

    def ask(self, line: str) -> None:
        """Do what a line of standard input asks for."""
        word, *numbers = line.split() or [""]
        values = [float(number) for number in numbers]
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
                self.controller = Controller(self._boot, *self._fit)
            case "stick", [forward, turn]:
                self.controller.stick = (int(forward), int(turn))
            case "fix", [x, y, sd]:
                self._terminal.write(self.controller.located(int(x), int(y), int(sd)))
            case _:
                sys.stderr.write(f"firmware: expected cut, noise, unplug, boot, stick or fix, got {line!r}\n")

    def turn(self, seconds: float) -> list[str]:
        """Let time pass; return what is to be said to people."""
        came = self._terminal.read()
        if self._noise > 0.0:
            came = self._garbage(came)
        if self._cut > 0.0:
            came = b""
        out = self.controller.turn(seconds, came)
        if self._noise > 0.0:
            out = self._garbage(out)
        if self._cut <= 0.0:
            self._terminal.write(out)
        self._cut = max(0.0, self._cut - seconds)
        self._noise = max(0.0, self._noise - seconds)
        if self._unplugged > 0.0:
            self._unplugged -= seconds
            if self._unplugged <= 0.0:
                self._terminal.plug()
        told, self.controller.told = self.controller.told, []
        return told

    def _garbage(self, data: bytes) -> bytes:
        """Return what noise makes of bytes: half of them others, and some where there were none."""
        noise = bytes(b if self._random.random() < 0.5 else self._random.randrange(256) for b in data)
        return noise + self._random.randbytes(self._random.randrange(4))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the stand-in and return its exit code."""
    parser = argparse.ArgumentParser(prog="firmware", description="A stand-in for a chair's controller.")
    parser.add_argument("--link", type=Path, metavar="PATH", help="a symbolic link that leads to the terminal")
    parser.add_argument("--ask", type=Path, metavar="PIPE", help="where faults are asked for (default: standard input)")
    parser.add_argument("--sonars", type=int, default=8, metavar="N", help="how many it has (default: 8)")
    parser.add_argument(
        "--counts", type=float, default=1730.0, metavar="N",
        help="encoder counts a second at full power (default: 1730, 1 m/s on wheels of 0.368 m with 2000 a turn)",
    )  # fmt: skip
    add_process_options(parser)
    given = parser.parse_args(arguments)
    stop = stop_on_signals(given.lifeline)
    terminal = Terminal(given.link)
    bench = Bench(terminal, given.sonars, given.counts)
    _say(f"ready port={given.link or terminal.name}")
    # Open for writing too: a pipe must not end when one writer does.
    source = os.open(given.ask, os.O_RDWR) if given.ask is not None else 0
    last = time.monotonic()
    asked, rest = True, ""
    while not stop.is_set():
        if select.select([source] if asked else [], [], [], TURN)[0]:
            data = os.read(source, 4096)
            asked = bool(data)
            *lines, rest = (rest + data.decode("ascii", "replace")).split("\n")
            for line in lines:
                bench.ask(line)
        now = time.monotonic()
        for line in bench.turn(min(now - last, SLOWEST)):
            _say(line)
        last = now
    terminal.unplug()
    if given.link is not None:
        given.link.unlink(missing_ok=True)
    return 0


def _say(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


if __name__ == "__main__":
    sys.exit(main())
