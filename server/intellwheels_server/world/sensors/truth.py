"""Truth: the true pose and twist, for simulations that allow it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from numba import njit

from intellwheels_schemas.messages import Truth, TruthReading
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.measures_text import DECIMAL, HEADING
from intellwheels_server.world.kernels.sample_schedule import BODY, due_slot
from intellwheels_server.world.sensors.angles import written_heading
from intellwheels_server.world.sensors.kind import Fitted, Kind, View, Written


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, schedule: Ints, samples: Floats) -> None:
    for sensor in range(schedule.shape[0]):
        slot = due_slot(schedule, sensor, tick, 5)
        if slot < 0:
            continue
        body = schedule[sensor, BODY]
        samples[slot] = numbers[rows.X, body]
        samples[slot + 1] = numbers[rows.Y, body]
        samples[slot + 2] = numbers[rows.HEADING, body]
        samples[slot + 3] = numbers[rows.SPEED, body]
        samples[slot + 4] = numbers[rows.TURN_RATE, body]


@dataclass(frozen=True)
class TruthBlock:
    """All truth sensors."""

    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.schedule, samples)


class TruthKind(Kind):
    """The kind that serves `Truth`."""

    declaration = Truth
    restricted = True
    sample_width = 5

    def compile(self, _fitted: Sequence[Fitted], schedule: Ints, /) -> TruthBlock:
        """Return the block."""
        return TruthBlock(schedule)

    def written(self, _sensor: Fitted, /) -> Written:
        """Return pose and twist."""
        return Written(
            (("x", DECIMAL), ("y", DECIMAL), ("heading", HEADING), ("speed", DECIMAL), ("turn_rate", DECIMAL))
        )

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> TruthReading:
        """Return pose and twist."""
        x, y, heading, speed, turn_rate = sample
        return TruthReading(
            id=sensor.declaration.id,
            tick=tick,
            x=x,
            y=y,
            heading=written_heading(heading),
            speed=speed,
            turn_rate=turn_rate,
        )
