"""The lines between a bridge and a chair's controller; PROTOCOL.md has them for people. Pure.

A line is printable ASCII, fields apart by one space, `*` and four hex digits of CRC-16, and a line feed. What has
another sum, or does not read, is dropped whole: garbage moves no motor.
"""

from __future__ import annotations

import binascii
from dataclasses import dataclass
from typing import Final

from intellwheels_agents.bridge.hardware_driver import Fix
from intellwheels_schemas.errors import WireError

LONGEST: Final = 512
"""Bytes of a line: 64 sonars have room."""
MOST_COUNT: Final = 2**53 - 1
NO_STICK: Final = "-"


@dataclass(frozen=True, slots=True)
class Telemetry:
    """A line `T` of the controller.

    Attributes:
        boot: A number that is another after each start of the controller.
        seq: Grows by one a line.
        ms: Milliseconds since its start.
        left, right: Encoder counts since its start.
        battery: Millivolts.
        stick: Forward and turn of its joystick in thousandths, or None without one.
        ranges: A sonar each: millimetres, or `n` nothing there, `c` too close, `f` failed.
    """

    boot: int
    seq: int
    ms: int
    left: int
    right: int
    battery: int
    stick: tuple[int, int] | None
    ranges: tuple[int | str, ...]


@dataclass(frozen=True, slots=True)
class Located:
    """A line `F`: a position from outside, in millimetres."""

    boot: int
    ms: int
    x: int
    y: int
    sd: int

    def fix(self) -> Fix:
        """Return it in metres."""
        return Fix(self.x / 1000.0, self.y / 1000.0, self.sd / 1000.0)


@dataclass(frozen=True, slots=True)
class PowerLine:
    """A line `P` of the bridge: powers in thousandths."""

    left: int
    right: int


Message = Telemetry | Located | PowerLine


def written(message: Message) -> bytes:
    """Return a message as a line."""
    match message:
        case Telemetry():
            stick = (NO_STICK, NO_STICK) if message.stick is None else message.stick
            fields: tuple[object, ...] = (
                "T", message.boot, message.seq, message.ms, message.left, message.right, message.battery, *stick,
                *message.ranges,
            )  # fmt: skip
        case Located():
            fields = ("F", message.boot, message.ms, message.x, message.y, message.sd)
        case PowerLine():
            fields = ("P", message.left, message.right)
    body = " ".join(str(each) for each in fields).encode("ascii")
    return b"%s*%04X\n" % (body, checksum(body))


def checksum(body: bytes) -> int:
    """Return CRC-16/CCITT-FALSE: polynomial 0x1021, beginning with 0xFFFF; of `123456789` it is 0x29B1."""
    return binascii.crc_hqx(body, 0xFFFF)


def read(line: bytes) -> Message:
    """Return the message of a line, without its line feed.

    Raises:
        WireError: `malformed`, when it is none.
    """
    body, star, told = line.rstrip(b"\r").rpartition(b"*")
    if not star or len(told) != 4 or told != b"%04X" % checksum(body):
        raise WireError("malformed", f"line: expected one that ends in * and its sum, got {line[:40]!r}")
    kind, *fields = body.decode("ascii", "replace").split(" ")
    if kind == "T" and len(fields) >= 8:
        stick = None
        if fields[6:8] != [NO_STICK, NO_STICK]:
            stick = _whole("forward", fields[6], -1000, 1000), _whole("turn", fields[7], -1000, 1000)
        boot, seq, ms, battery = (
            _whole(name, fields[i], 0, MOST_COUNT) for name, i in (("boot", 0), ("seq", 1), ("ms", 2), ("battery", 5))
        )
        left, right = (_whole(name, fields[i], -MOST_COUNT, MOST_COUNT) for name, i in (("left", 3), ("right", 4)))
        return Telemetry(boot, seq, ms, left, right, battery, stick, tuple(_range(text) for text in fields[8:]))
    if kind == "F" and len(fields) == 5:
        boot, ms, sd = (_whole(name, fields[i], 0, MOST_COUNT) for name, i in (("boot", 0), ("ms", 1), ("sd", 4)))
        x, y = (_whole(name, fields[i], -10_000_000, 10_000_000) for name, i in (("x", 2), ("y", 3)))
        return Located(boot, ms, x, y, sd)
    if kind == "P" and len(fields) == 2:
        return PowerLine(_whole("left", fields[0], -1000, 1000), _whole("right", fields[1], -1000, 1000))
    raise WireError("malformed", f"line: expected T, F or P and its fields, got {line[:40]!r}")


def _whole(name: str, text: str, low: int, high: int) -> int:
    digits = text.removeprefix("-")
    if digits.isascii() and digits.isdigit() and len(digits) <= 16 and low <= int(text) <= high:
        return int(text)
    raise WireError("malformed", f"line.{name}: expected a whole number in [{low}, {high}], got {text[:20]!r}")


def _range(text: str) -> int | str:
    return text if text in ("n", "c", "f") else _whole("range", text, 0, 20_000_000)


class Splitter:
    """Cuts what arrives into lines.

    Attributes:
        overlong: Lines that were dropped because they never ended.
    """

    def __init__(self) -> None:
        self.overlong = 0
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Return the lines that are whole now, without their line feeds and the empty ones."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > LONGEST:
            self.overlong += 1
            self._rest = b""
        return [line for line in lines if line]
