"""What a kind of sensor is.

A kind is one file of this package. It says which declaration it serves, what a declaration must
fulfil, how the samples of all its sensors are taken from the world's arrays in one call, and
how a sample becomes a reading.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

from intellwheels_schemas.messages import Map, Position, Record, Robot
from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls

Declaration = Any
"""One of the declaration classes; each kind knows its own."""


class View(NamedTuple):
    """What sensors can know of the world at a tick.

    Attributes:
        numbers: float64[NUMBER_ROWS, n], of which sensors read the rows up to `TOUCHING` of `kernels.rows`.
        parts: Part block of the bodies.
        part_start: int64[n + 1], the first part of each body and the end.
        walls: The floor.
        period: Simulated time of a tick, s.
    """

    numbers: Floats
    parts: Floats
    part_start: Ints
    walls: Walls
    period: float


class Fitted(NamedTuple):
    """A sensor on a body.

    Attributes:
        body: Index of the body.
        robot: The body's robot.
        start: Where the body joined.
        declaration: The sensor.
        floor: The map, for what is named on it.
    """

    body: int
    robot: Robot
    start: Position
    declaration: Declaration
    floor: Map


class Block(Protocol):
    """All sensors of one kind, compiled."""

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""


class Kind(Protocol):
    """A kind of sensor."""

    @property
    def field(self) -> str:
        """The field of `Robot` and of `Sensors` that lists its sensors."""

    def width(self, declaration: Declaration) -> int:
        """Return the numbers in a sample."""

    def memory(self, declaration: Declaration) -> int:
        """Return the numbers that the sensor remembers from tick to tick, behind its samples; they begin as 0.

        They are part of the hash. Sensing twice at one tick must leave them as sensing once does.
        """

    def check(self, where: str, declaration: Declaration, robot: Robot) -> None:
        """Refuse a declaration that is well-formed but cannot be.

        Args:
            where: The declaration's place in the wire's names: `Robot.Proximity[2]`.
            declaration: The declaration.
            robot: The whole robot.

        Raises:
            RequestRefusedError: Why it cannot be.
        """

    def compile(self, fitted: Sequence[Fitted], timetable: Ints) -> Block:
        """Return the block of at least one sensor.

        Args:
            fitted: The sensors by body, those mounted on the body before those left at its start.
            timetable: int64[sensors, 8], in the same order.
        """

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> Record:
        """Return the reading of a sample; `tick` only where it is not the tick of the measures."""
