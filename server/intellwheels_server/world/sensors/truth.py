"""Truth: the pose and twist as they are, for agents that may know them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from numba import njit

from intellwheels_schemas.messages import Robot, Truth, TruthReading
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.rows import HEADING, SPEED, TURN_RATE, X, Y
from intellwheels_server.world.kernels.timetable import BODY, due_slot
from intellwheels_server.world.sensors.kind import Fitted, View


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, timetable: Ints, samples: Floats) -> None:
    for sensor in range(timetable.shape[0]):
        slot = due_slot(timetable, sensor, tick, 5)
        if slot < 0:
            continue
        body = timetable[sensor, BODY]
        samples[slot] = numbers[X, body]
        samples[slot + 1] = numbers[Y, body]
        samples[slot + 2] = numbers[HEADING, body]
        samples[slot + 3] = numbers[SPEED, body]
        samples[slot + 4] = numbers[TURN_RATE, body]


@dataclass(frozen=True)
class TruthBlock:
    """All truth sensors."""

    timetable: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.timetable, samples)


class TruthKind:
    """The kind that serves `Truth`."""

    field = "truth"

    def check(self, where: str, declaration: Truth, robot: Robot) -> None:
        """Refuse none; whether truth is allowed is the simulation's to say, see `check_sensors`."""

    def width(self, declaration: Truth) -> int:  # noqa: ARG002 - as `Kind` has it
        """Return the numbers in a sample."""
        return 5

    def memory(self, declaration: Truth) -> int:  # noqa: ARG002 - as `Kind` has it
        """Return 0: it remembers nothing."""
        return 0

    def compile(self, fitted: Sequence[Fitted], timetable: Ints) -> TruthBlock:  # noqa: ARG002 - as `Kind` has it
        """Return the block."""
        return TruthBlock(timetable)

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> TruthReading:
        """Return pose and twist."""
        x, y, heading, speed, turn_rate = sample
        return TruthReading(
            id=sensor.declaration.id, tick=tick, x=x, y=y, heading=heading, speed=speed, turn_rate=turn_rate
        )
