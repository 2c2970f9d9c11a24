"""The check's view of a program and of the network: events, and the `Probe` that yields them. Pure declarations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Literal, NamedTuple, Protocol, TypeAlias

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Role


class JoinRequest(NamedTuple):
    """The program asked to join.

    Attributes:
        data: The payload of its query.
        encoding: The encoding of its query, as on the wire.
        answer: Answers the query: payload, encoding, and whether the join is granted.
    """

    data: bytes
    encoding: str
    answer: Callable[[bytes, Encoding, bool], None]


NO_CREWS: Final = "iw-check-agent checks single agents only, not crews"


class CrewRequest(NamedTuple):
    """The program asked to join as a crew, and was refused: a crew is not checked."""

    crew: str


class ActionsPut(NamedTuple):
    """The program put something on its `actions` key.

    Attributes:
        data: The payload.
        encoding: The encoding of the put, as on the wire.
        blocks: Whether this put, or an earlier one of the program, had the congestion control block.
    """

    data: bytes
    encoding: str
    blocks: bool = False


class TokenChange(NamedTuple):
    """A liveliness token of the program appeared or disappeared."""

    role: Role
    instance: str
    alive: bool


class LeaveRequest(NamedTuple):
    """The program asked to leave, and was answered."""


class ProgramExit(NamedTuple):
    """The program's process ended. A negative code is the signal that ended it."""

    code: int


ProgramEvent: TypeAlias = JoinRequest | CrewRequest | ActionsPut | TokenChange | LeaveRequest | ProgramExit


class Probe(Protocol):
    """A program under test, and the simulator that it sees."""

    def now(self) -> float:
        """Return the seconds of a monotonic clock."""
        ...

    def start_program(self) -> None:
        """Start the program."""
        ...

    def interrupt_program(self) -> None:
        """Send the program SIGTERM."""
        ...

    def kill_program(self) -> None:
        """Kill the program and forget everything that arrived from it."""
        ...

    def output(self) -> str:
        """Return what the program printed since its start, on standard output and standard error."""
        ...

    def start_simulator(self) -> None:
        """Make the simulator present. Does nothing if it is."""
        ...

    def stop_simulator(self) -> None:
        """Make the simulator disappear with its connections."""
        ...

    def put(self, kind: Literal["measures", "error"], data: bytes, encoding: Encoding) -> None:
        """Publish a message for the program."""
        ...

    def next_event(self, timeout: float) -> ProgramEvent | None:
        """Return the next event, or None if there is none within `timeout` seconds."""
        ...
