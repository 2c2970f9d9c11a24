"""What the harness asks of its caller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from intellwheels_schemas.codec import Encoding


@dataclass(frozen=True, slots=True)
class RequestJoin:
    """Query `join/<agent>` with this encoded `Robot`."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class Reappear:
    """Replace the liveliness token by one of this instance."""

    instance: str


@dataclass(frozen=True, slots=True)
class Publish:
    """Put this on the agent's `actions` key, or on `pose` for a body."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class RequestLeave:
    """Query `leave/<agent>` with this encoded `Leave`."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class Print:
    """Print a line on standard output, for a script that waits for it."""

    line: str


@dataclass(frozen=True, slots=True)
class Log:
    """Write a line to the log."""

    line: str


@dataclass(frozen=True, slots=True)
class Exit:
    """End the process with this code; `text` explains it to a person if the code is not 0."""

    code: int
    text: str = ""


@dataclass(frozen=True, slots=True)
class AskClock:
    """Query `clock`."""


@dataclass(frozen=True, slots=True)
class AskBody:
    """Query `body/<agent>`."""


Output: TypeAlias = RequestJoin | Reappear | Publish | RequestLeave | AskClock | AskBody | Print | Log | Exit
Payload: TypeAlias = tuple[bytes, Encoding]
"""An encoded message as it arrived, and its encoding."""
