"""The frames of an R-Net bus that a bridge reads, and the one that it may send. Pure.

R-Net is CAN at 125 kbit/s. These frames have extended identifiers; X is the number of a device on the bus:

    02000X00   joystick: right and forward, int8 in [-100, 100]; every 10 ms
    0A040X00   highest speed: uint8 in [0, 100] percent; on change
    03C30F0F   heartbeat of the joystick module: 8 bytes; every 100 ms
    1C0C0X00   battery: uint8 in [0, 100] percent; every second
    14300X00   motor current: uint16, little-endian, in the chair's own unit; every 200 ms

Source:
    The frames published by the project can2RNET, which were found by observation. The maker documents none of them.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Final, Literal

from intellwheels_schemas.errors import WireError

BITRATE: Final = 125_000
"""Bits a second on an R-Net bus."""
FULL: Final = 100
"""Full deflection of the joystick, and 100 percent."""
JOYSTICK: Final = 0x02000000
SPEED: Final = 0x0A040000
HEARTBEAT: Final = 0x03C30F0F
BATTERY: Final = 0x1C0C0000
CURRENT: Final = 0x14300000
ANY_DEVICE: Final = 0x1FFFF0FF
"""Mask of an identifier without the number of the device."""
EXACT: Final = 0x1FFFFFFF
FILTERS: Final = tuple(
    {"can_id": identifier, "can_mask": EXACT if identifier == HEARTBEAT else ANY_DEVICE, "extended": True}
    for identifier in (JOYSTICK, SPEED, HEARTBEAT, BATTERY, CURRENT)
)
"""What a bus hands on, as python-can takes it."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A CAN frame.

    Attributes:
        identifier: Its arbitration id.
        data: Its bytes.
        is_plain: Whether it is a data frame of classic CAN with an extended identifier.
    """

    identifier: int
    data: bytes
    is_plain: bool = True


@dataclass(frozen=True, slots=True)
class Stick:
    """A joystick: forward and turn in [-1, 1], turn positive to the left; `device` is the X of its identifier."""

    device: int
    forward: float
    turn: float


@dataclass(frozen=True, slots=True)
class SpeedLimit:
    """The highest speed that the user has chosen, as a share of the chair's."""

    share: float


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """The joystick module is there."""


@dataclass(frozen=True, slots=True)
class Battery:
    """The charge of the battery, in percent."""

    percent: int


@dataclass(frozen=True, slots=True)
class MotorCurrent:
    """The current of the motors, in the chair's own unit."""

    value: int


Content = Stick | SpeedLimit | Heartbeat | Battery | MotorCurrent


def decode_frame(frame: Frame) -> Content | None:
    """Return what a frame says, or None for one that a bridge does not read.

    Raises:
        WireError: `malformed` or `value`, when it has the identifier of a known frame, but not its form.
    """
    kind = HEARTBEAT if frame.identifier == HEARTBEAT else frame.identifier & ANY_DEVICE
    if kind not in _FORMS:
        return None
    name, size = _FORMS[kind]
    if not frame.is_plain:
        raise _wrong(name, "a data frame of classic CAN with an extended identifier", "another one", "malformed")
    if len(frame.data) != size:
        raise _wrong(name, f"{size} bytes", f"{len(frame.data)}", "malformed")
    if kind == JOYSTICK:
        right, forward = struct.unpack("bb", frame.data)
        if not (abs(right) <= FULL and abs(forward) <= FULL):
            raise _wrong(name, f"deflections in [-{FULL}, {FULL}]", f"{right} and {forward}")
        return Stick((frame.identifier >> 8) & 0xF, forward / FULL, -right / FULL)
    if kind == SPEED:
        return SpeedLimit(_percent(name, frame.data) / FULL)
    if kind == BATTERY:
        return Battery(_percent(name, frame.data))
    if kind == CURRENT:
        return MotorCurrent(int.from_bytes(frame.data, "little"))
    return Heartbeat()


def joystick_frame(device: int, forward: float, turn: float) -> Frame:
    """Return the joystick frame of a device for a deflection in [-1, 1], turn positive to the left."""
    right, ahead = (max(-FULL, min(FULL, round(FULL * one))) for one in (-turn, forward))
    return Frame(JOYSTICK | (device & 0xF) << 8, struct.pack("bb", right, ahead))


_FORMS: Final = {
    JOYSTICK: ("joystick", 2),
    SPEED: ("speed", 1),
    HEARTBEAT: ("heartbeat", 8),
    BATTERY: ("battery", 1),
    CURRENT: ("motor current", 2),
}
"""Name and number of bytes of each kind."""


def _percent(name: str, data: bytes) -> int:
    if data[0] > FULL:
        raise _wrong(name, f"a percentage in [0, {FULL}]", str(data[0]))
    return data[0]


def _wrong(name: str, expected: str, got: str, code: Literal["malformed", "value"] = "value") -> WireError:
    where = f"R-Net {name}"
    return WireError(code, f"{where}: expected {expected}, got {got}", where)
