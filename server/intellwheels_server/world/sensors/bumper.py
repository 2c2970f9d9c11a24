"""Bumpers: whether the body touches something, on any side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from numba import njit

from intellwheels_schemas.messages import Bumper, BumperReading
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.sample_schedule import BODY, due_slot
from intellwheels_server.world.sensors.kind import Fitted, Kind, View, Written


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, schedule: Ints, samples: Floats) -> None:
    for sensor in range(schedule.shape[0]):
        slot = due_slot(schedule, sensor, tick, 1)
        if slot >= 0:
            samples[slot] = numbers[rows.TOUCHING, schedule[sensor, BODY]]


@dataclass(frozen=True)
class BumperBlock:
    """All bumpers."""

    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.schedule, samples)


class BumperKind(Kind):
    """The kind that serves `Bumper`."""

    declaration = Bumper

    def compile(self, _fitted: Sequence[Fitted], schedule: Ints, /) -> BumperBlock:
        """Return the block."""
        return BumperBlock(schedule)

    def written(self, _sensor: Fitted, /) -> Written:
        """Return whether it is pressed as the code."""
        return Written(codes=2)

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> BumperReading:
        """Return whether it is pressed."""
        return BumperReading(id=sensor.declaration.id, tick=tick, value=sample[0] != 0.0)
