"""The lines between a bridge and a chair's controller, read and written. Pure. PROTOCOL.md describes them for people.

A line is printable ASCII: fields separated by one space, then `*`, four hex digits of CRC-16 and a line feed. A line
with a wrong checksum or wrong fields is dropped as a whole, so garbage never moves a motor.
"""

from __future__ import annotations

import binascii
from dataclasses import dataclass
from typing import Final

from intellwheels_agents.bridge.hardware_driver import Fix
from intellwheels_agents.bridge.wrapping_counter import MAX_SIGNED, MAX_UNSIGNED, MIN_SIGNED
from intellwheels_schemas.errors import WireError

MAX_LINE: Final = 512
"""Bytes of the longest line: enough for 64 sonars."""
NO_JOYSTICK: Final = "-"


@dataclass(frozen=True, slots=True)
class Telemetry:
    """A line `T` from the controller.

    Attributes:
        boot: A number that differs after each start of the controller.
        seq: Grows by one a line; an unsigned 32-bit counter that wraps to 0.
        ms: Milliseconds since the start; an unsigned 32-bit counter that wraps to 0 after 49.7 days.
        left, right: Encoder counts since the start, forward positive; signed 32-bit counters that wrap.
        battery: Millivolts.
        joystick: Forward and turn of the chair's joystick in thousandths, or None without one.
        ranges: One entry a sonar: millimetres, or `n` no object, `c` too close, `f` failed.
    """

    boot: int
    seq: int
    ms: int
    left: int
    right: int
    battery: int
    joystick: tuple[int, int] | None
    ranges: tuple[int | str, ...]


@dataclass(frozen=True, slots=True)
class PositionFix:
    """A line `F`: a position from outside the chair, in millimetres."""

    boot: int
    ms: int
    x: int
    y: int
    sd: int

    def to_fix(self) -> Fix:
        """Return the position in metres."""
        return Fix(self.x / 1000.0, self.y / 1000.0, self.sd / 1000.0)


@dataclass(frozen=True, slots=True)
class PowerLine:
    """A line `P` from the bridge: motor powers in thousandths."""

    left: int
    right: int


Message = Telemetry | PositionFix | PowerLine


def encode_line(message: Message) -> bytes:
    """Return a message as a line, line feed included."""
    match message:
        case Telemetry():
            joystick = (NO_JOYSTICK, NO_JOYSTICK) if message.joystick is None else message.joystick
            fields: tuple[object, ...] = (
                "T", message.boot, message.seq, message.ms, message.left, message.right, message.battery, *joystick,
                *message.ranges,
            )  # fmt: skip
        case PositionFix():
            fields = ("F", message.boot, message.ms, message.x, message.y, message.sd)
        case PowerLine():
            fields = ("P", message.left, message.right)
    body = " ".join(str(each) for each in fields).encode("ascii")
    return b"%s*%04X\n" % (body, checksum(body))


def checksum(body: bytes) -> int:
    """Return the CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF. That of `123456789` is 0x29B1."""
    return binascii.crc_hqx(body, 0xFFFF)


def decode_line(line: bytes) -> Message:
    """Return the message in a line, which comes without its line feed.

    Raises:
        WireError: `malformed`, when the line is not valid.
    """
    body, star, given = line.rstrip(b"\r").rpartition(b"*")
    if not star or len(given) != 4 or given != b"%04X" % checksum(body):
        raise WireError("malformed", f"line: expected one that ends in * and its checksum, got {line[:40]!r}")
    kind, *fields = body.decode("ascii", "replace").split(" ")
    if kind == "T" and len(fields) >= 8:
        joystick = None
        if fields[6:8] != [NO_JOYSTICK, NO_JOYSTICK]:
            joystick = _integer("forward", fields[6], -1000, 1000), _integer("turn", fields[7], -1000, 1000)
        boot, seq, ms, battery = (
            _unsigned(name, fields[i]) for name, i in (("boot", 0), ("seq", 1), ("ms", 2), ("battery", 5))
        )
        left, right = (_integer(name, fields[i], MIN_SIGNED, MAX_SIGNED) for name, i in (("left", 3), ("right", 4)))
        return Telemetry(boot, seq, ms, left, right, battery, joystick, tuple(_range(text) for text in fields[8:]))
    if kind == "F" and len(fields) == 5:
        boot, ms, sd = (_unsigned(name, fields[i]) for name, i in (("boot", 0), ("ms", 1), ("sd", 4)))
        x, y = (_integer(name, fields[i], -10_000_000, 10_000_000) for name, i in (("x", 2), ("y", 3)))
        return PositionFix(boot, ms, x, y, sd)
    if kind == "P" and len(fields) == 2:
        return PowerLine(_integer("left", fields[0], -1000, 1000), _integer("right", fields[1], -1000, 1000))
    raise WireError("malformed", f"line: expected T, F or P and its fields, got {line[:40]!r}")


def _integer(name: str, text: str, low: int, high: int) -> int:
    digits = text.removeprefix("-")
    if digits.isascii() and digits.isdigit() and len(digits) <= 10 and low <= int(text) <= high:
        return int(text)
    raise WireError("malformed", f"line.{name}: expected a whole number in [{low}, {high}], got {text[:20]!r}")


def _unsigned(name: str, text: str) -> int:
    return _integer(name, text, 0, MAX_UNSIGNED)


def _range(text: str) -> int | str:
    return text if text in ("n", "c", "f") else _integer("range", text, 0, 20_000_000)


class LineSplitter:
    """Splits the received bytes into lines.

    Attributes:
        too_long: Number of lines dropped because they were longer than `MAX_LINE`.
    """

    def __init__(self) -> None:
        self.too_long = 0
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Return the lines that are complete now, without line feeds; empty ones are left out."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > MAX_LINE:
            self.too_long += 1
            self._rest = b""
        return [line for line in lines if line]
