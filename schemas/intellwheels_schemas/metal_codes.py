"""Codes that let a motor and a real robot's pose obey nobody but their own simulator and bridge.

A code is the first half of HMAC-SHA256 (RFC 2104, FIPS 180-4) over one line of ASCII, with the `Key` that only the
bridge got in its `Joined`. The line has a word, then fields with one space between them. A real number is written as
the 16 hex digits of its IEEE 754 double, big-endian, so that no two languages round it differently. An absent field
is `-`.

    power <run> <tick> <seq> <left motor> <right motor> <state>
    pose <run> <tick> <seq> <x> <y> <heading> <stamp>
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
import struct
from typing import Final

from intellwheels_schemas.messages import Pose, PowerInForce

KEY_BYTES: Final = 32
CODE_DIGITS: Final = 32


def new_key() -> str:
    """Return a new key: 64 hex digits."""
    return secrets.token_hex(KEY_BYTES)


def power_line(power: PowerInForce) -> str:
    """Return the line that the code of a power covers."""
    return _line("power", power.run, power.tick, power.seq, power.left_motor, power.right_motor, power.state)


def pose_line(pose: Pose) -> str:
    """Return the line that the code of a pose covers."""
    return _line("pose", pose.run, pose.tick, pose.seq, pose.x, pose.y, pose.heading, pose.stamp)


def code_of(key: str, line: str) -> str:
    """Return the code of a line: 32 hex digits.

    Raises:
        ValueError: The key is not hex.
    """
    return hmac.new(bytes.fromhex(key), line.encode("ascii"), hashlib.sha256).hexdigest()[:CODE_DIGITS]


def is_genuine(key: str | None, line: str, code: str | None) -> bool:
    """Return whether a message has the code that its key makes. Without a key no message is genuine."""
    return key is not None and code is not None and hmac.compare_digest(code_of(key, line), code)


def _line(*fields: str | int | float | None) -> str:
    return " ".join(map(_text, fields))


def _text(field: str | int | float | None) -> str:
    if field is None:
        return "-"
    return struct.pack(">d", field).hex() if isinstance(field, float) else str(field)
