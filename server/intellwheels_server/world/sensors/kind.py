"""The base class of the kinds of sensors.

A kind is one file of this package. It names the declaration that it serves. It checks declarations, takes the samples
of all its sensors from the world's arrays in one call, and turns a sample into a reading.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, Final, NamedTuple, Protocol, runtime_checkable

import msgspec
from numpy.typing import NDArray

from intellwheels_schemas.messages import Map, Position, Record, Robot
from intellwheels_schemas.rules import SENSOR_RECORDS
from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls

Declaration = Any
"""One of the declaration classes; each kind knows its own."""


class View(msgspec.Struct, frozen=True, gc=False):
    """The world at a tick, as sensors can see it.

    Attributes:
        numbers: float64[NUMBER_ROWS, n], of which sensors read the rows up to `TOUCHING` of `kernels.rows`.
        parts: Part block of the bodies.
        part_start: int64[n + 1], the first part of each body and the end.
        walls: The walls and obstacles of the map.
        period: Simulated time of a tick, s.
        threads: Threads that may share the work. The samples are the same for any number.
    """

    numbers: Floats
    parts: Floats
    part_start: Ints
    walls: Walls
    period: float
    threads: int = 1


class ManyViews(NamedTuple):
    """Many worlds, each at a tick, as sensors can see them. The first axis is the world.

    Attributes:
        numbers: float64[worlds, NUMBER_ROWS, n].
        parts: float64[worlds, parts, 6].
        part_start: int64[n + 1], the same in all worlds.
        walls: The walls and obstacles of the map, the same in all worlds.
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
        robot: The body's robot.
        start: Pose at which the body joined.
        declaration: The sensor.
        floor: The map, for its names.
    """

    robot: Robot
    start: Position
    declaration: Declaration
    floor: Map


Array = NDArray[Any]
"""An array of a block, float64 or int64."""


class Written(NamedTuple):
    """How a sample is written as a message without making a reading of it.

    Attributes:
        fields: The fields of the reading that are numbers of the sample, in its order and behind the code if there is
            one, each with `DECIMAL`, `HEADING` or `WHOLE` of `kernels.measures_text`.
        codes: Values that the first number of a sample can have, if all else in a reading follows from it; 0 if the
            first number is the first field.
        lowest: The lowest of these values; the others follow it one by one.
    """

    fields: tuple[tuple[str, int], ...] = ()
    codes: int = 0
    lowest: int = 0


class Block(Protocol):
    """All sensors of one kind, compiled.

    A block may also have the methods of `StackableBlock`, for the sensors of many worlds in one call.
    """

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""


@runtime_checkable
class StackableBlock(Block, Protocol):
    """A block that can be sampled in many worlds at once. Its function must not hold Python's lock."""

    def stackable(self) -> tuple[Array, ...] | None:
        """Return the arrays that `take_many` needs; None if this block must be sampled alone."""

    @staticmethod
    def take_many(
        ticks: Ints, views: ManyViews, arrays: Sequence[Array], samples: Floats, first: int, end: int
    ) -> None:
        """Store the samples that are due in the worlds from `first` to before `end`, exactly as `take` does in each.

        Args:
            ticks: int64[worlds], the tick of each world.
            views: The worlds.
            arrays: What `stackable` returned in each world, stacked: the first axis is the world.
            samples: float64[worlds, ...], written.
            first: The first world.
            end: One past the last.
        """


READING_BYTES: Final = 512
"""Largest number of bytes of a reading that has no list of numbers."""


class Kind(ABC):
    """A kind of sensor. A subclass states its declaration, `compile` and `reading`; the rest has defaults.

    Attributes:
        declaration: The record that declares such a sensor.
        field: The field of `Robot` and of `Sensors` that lists its sensors; found from the declaration.
        sample_width: Numbers in a sample.
        restricted: Whether the simulation must allow it (`Setup.truth`).

    Raises:
        TypeError: While a subclass is defined whose declaration no field of both `Robot` and `Sensors` lists.
    """

    declaration: ClassVar[type[Record]]
    field: ClassVar[str]
    sample_width: ClassVar[int] = 1
    restricted: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        fields = [field for field, records in SENSOR_RECORDS.items() if records.declaration is cls.declaration]
        if len(fields) != 1:
            raise TypeError(
                f"{cls.__name__}.declaration: expected a record that one field of Robot and Sensors lists, "
                f"got {cls.declaration.__name__}"
            )
        cls.field = fields[0]

    def check_fields(self, where: str, declaration: Declaration, /) -> None:  # noqa: B027 - most refuse none
        """Refuse fields that contradict each other, whoever measures; by default none.

        Args:
            where: As `check` takes it.
            declaration: The declaration, of a simulated sensor or of one of a real robot.

        Raises:
            RequestRefusedError: What contradicts what.
        """

    def check(self, where: str, declaration: Declaration, floor: Map, /) -> None:  # noqa: B027 - most refuse none
        """Refuse a declaration that is well-formed but cannot be simulated; by default none.

        Args:
            where: The path of the declaration in the message, such as `Robot.Proximity[2]`.
            declaration: The declaration, of a simulated sensor, which has passed `check_fields`.
            floor: The map, for its names.

        Raises:
            RequestRefusedError: Why it cannot be simulated.
        """

    def check_timing(self, where: str, declaration: Declaration, period: float, /) -> None:  # noqa: B027 - as above
        """Refuse a rate or a latency that cannot be simulated with this period; by default none.

        Args:
            where: As `check` takes it.
            declaration: The declaration, of a simulated sensor, which has passed `check`.
            period: Simulated time of a tick, s.

        Raises:
            RequestRefusedError: Why it cannot be simulated.
        """

    def width(self, _declaration: Declaration, /) -> int:
        """Return the numbers in a sample; by default `sample_width`."""
        return self.sample_width

    def memory(self, _declaration: Declaration, /) -> int:
        """Return the numbers that the sensor remembers from tick to tick; by default 0.

        They are stored behind its samples, start as 0 and are part of the hash. A second sampling at the same tick must
        not change them.
        """
        return 0

    def rays(self, _declaration: Declaration, /) -> float:
        """Return how many rays of a lidar cost as much as one sample; by default 0: most kinds cost next to nothing."""
        return 0.0

    def reading_bytes(self, _declaration: Declaration, /) -> int:
        """Return the largest number of bytes of a reading, in either encoding; by default `READING_BYTES`."""
        return READING_BYTES

    def phase(self, _declaration: Declaration, /) -> int:
        """Return the ticks between joining and the first sample; by default 0."""
        return 0

    def stream(self, sensor: Fitted) -> str:
        """Return the name of the sensor's noise stream; by default its id."""
        return str(sensor.declaration.id)

    def examples(self, _floor: Map, /) -> tuple[Declaration, ...]:
        """Return declarations that together need every kernel of the kind, to compile them; by default one of id only.

        Args:
            _floor: A map with at least one named place.
        """
        return (self.declaration(id=self.field),)

    def written(self, _sensor: Fitted, /) -> Written | None:
        """Return how its samples are written without making a reading; by default None: a reading is made of each.

        What is written this way must be what the codec writes of `reading`.
        """
        return None

    @abstractmethod
    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> Block:
        """Return the block of at least one sensor.

        Args:
            fitted: The sensors by body, those mounted on the body before those left at its start.
            schedule: int64[sensors, 8], in the same order.
        """

    def piece(self, fitted: Sequence[Fitted], /) -> Any:
        """Return what `assemble` needs of the sensors of one body; by default the sensors.

        It is made once for each body. A kind with many sensors prepares arrays here, so that a join need not make those
        of all other bodies again.

        Args:
            fitted: As `compile` takes them.
        """
        return fitted

    def assemble(self, pieces: Sequence[Any], schedule: Ints, /) -> Block:
        """Return the block of the sensors of all bodies that have any; by default what `compile` makes.

        Args:
            pieces: The piece of each such body, in the order of the bodies.
            schedule: int64[sensors, 8], in the same order.
        """
        return self.compile([sensor for piece in pieces for sensor in piece], schedule)

    @abstractmethod
    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> Record:
        """Return the reading of a sample.

        Args:
            sensor: The sensor.
            tick: When the sample was taken, None if at the tick of the measures.
            sample: As many numbers as `width` says.
        """
