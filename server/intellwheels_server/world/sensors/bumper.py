"""Bumpers: whether the body touches something, anywhere around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from numba import njit

from intellwheels_schemas.messages import Bumper, BumperReading, Robot
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.rows import TOUCHING
from intellwheels_server.world.kernels.timetable import BODY, due_slot
from intellwheels_server.world.sensors.kind import Fitted, View


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, timetable: Ints, samples: Floats) -> None:
    for sensor in range(timetable.shape[0]):
        slot = due_slot(timetable, sensor, tick, 1)
        if slot >= 0:
            samples[slot] = numbers[TOUCHING, timetable[sensor, BODY]]


@dataclass(frozen=True)
class BumperBlock:
    """All bumpers."""

    timetable: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.timetable, samples)


class BumperKind:
    """The kind that serves `Bumper`."""

    field = "bumper"

    def check(self, where: str, declaration: Bumper, robot: Robot) -> None:
        """Refuse none."""

    def width(self, declaration: Bumper) -> int:  # noqa: ARG002 - as `Kind` has it
        """Return the numbers in a sample."""
        return 1

    def memory(self, declaration: Bumper) -> int:  # noqa: ARG002 - as `Kind` has it
        """Return 0: it remembers nothing."""
        return 0

    def compile(self, fitted: Sequence[Fitted], timetable: Ints) -> BumperBlock:  # noqa: ARG002 - as `Kind` has it
        """Return the block."""
        return BumperBlock(timetable)

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> BumperReading:
        """Return whether it is pressed."""
        return BumperReading(id=sensor.declaration.id, tick=tick, value=sample[0] != 0.0)
