"""Proximity sensors: the nearest distance in a wedge, as it is, as an infrared sensor or as a sonar tells it.

`ideal` tells the exact distance. `infrared` measures by triangulation: its voltage is V = c / d, so that noise of
the voltage becomes a standard deviation that grows with the square of the distance; it never tells beyond its range.
`sonar` hears only what echoes: see `kernels.echoes`. Kernels of `kernels.sensing` find the distances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final, NamedTuple

import numpy as np
from numba import njit

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Proximity, ProximityReading, Robot, Status
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.echoes import sense_sonars
from intellwheels_server.world.kernels.noise import normal, uniform
from intellwheels_server.world.kernels.sensing import (
    CREW_COLUMNS,
    EYE_COLUMNS,
    FAULT,
    OK,
    SAMPLE_WIDTH,
    STATION_COLUMNS,
    sense_proximity,
)
from intellwheels_server.world.kernels.timetable import KEY0, KEY1, due_slot
from intellwheels_server.world.sensors.angles import unit_vector
from intellwheels_server.world.sensors.kind import Fitted, View

VOLT_METRES: Final = 0.47
"""c of an infrared sensor, V m: SIMULATION.md's 10 mV are then 2 mm at 0.3 m and 48 mm at 1.5 m."""

_STATUS: tuple[Status, ...] = ("ok", "none", "near", "fault")

# Columns of an infrared block, float64[sensors, 4]: standard deviation over the square of the distance, 1/m; share of
# samples that fail; range, m.
_SIGMA, _DROPOUT, _NEAREST, _FARTHEST = 0, 1, 2, 3


@njit(cache=True, error_model="numpy")
def _spoil(tick: int, infrared: Floats, timetable: Ints, samples: Floats) -> None:
    """Make the exact samples that were taken at a tick those of infrared sensors."""
    for sensor in range(infrared.shape[0]):
        slot = due_slot(timetable, sensor, tick, SAMPLE_WIDTH)
        if slot < 0:
            continue
        key0, key1 = np.uint64(timetable[sensor, KEY0]), np.uint64(timetable[sensor, KEY1])
        if samples[slot] == OK:
            exact = samples[slot + 1]
            told = exact + infrared[sensor, _SIGMA] * exact * exact * normal(key0, key1, tick, 0)
            samples[slot + 1] = min(max(told, infrared[sensor, _NEAREST]), infrared[sensor, _FARTHEST])
        if infrared[sensor, _DROPOUT] > 0.0 and uniform(key0, key1, tick, 1) < infrared[sensor, _DROPOUT]:
            samples[slot] = FAULT
            samples[slot + 1] = 0.0


class _Lookouts(NamedTuple):
    """Sensors by the frames they look from, as kernels take them."""

    stations: Floats
    crews: Ints
    eyes: Floats


@dataclass(frozen=True)
class ProximityBlock:
    """All proximity sensors: those that are no sonars, errors of the infrared ones among them, and sonars."""

    seeing: _Lookouts
    seeing_times: Ints
    infrared: Floats
    infrared_times: Ints
    sonars: _Lookouts
    ears: Floats
    sonar_times: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        numbers, parts, part_start = view.numbers, view.parts, view.part_start
        if len(self.seeing_times):
            of = self.seeing
            sense_proximity(
                tick,
                numbers,
                parts,
                part_start,
                *view.walls,
                of.stations,
                of.crews,
                of.eyes,
                self.seeing_times,
                samples,
            )
        if len(self.infrared_times):
            _spoil(tick, self.infrared, self.infrared_times, samples)
        if len(self.sonar_times):
            of = self.sonars
            sense_sonars(
                tick, numbers, parts, part_start, *view.walls, of.stations, of.crews, of.eyes, self.ears,
                self.sonar_times, samples,
            )  # fmt: skip


class ProximityKind:
    """The kind that serves `Proximity`."""

    field = "proximity"

    def check(self, where: str, declaration: Proximity, robot: Robot) -> None:  # noqa: ARG002 - as `Kind` has it
        """Refuse errors that a model has not, and a firing group that its rate has no room for."""
        if declaration.model == "ideal" and declaration.dropout > 0.0:
            raise RequestRefusedError(
                "value", f"{where}.Dropout: expected 0 of the model ideal, got {declaration.dropout}"
            )
        if declaration.model != "sonar" and declaration.crosstalk > 0.0:
            text = f"{where}.Crosstalk: expected 0 of the model {declaration.model}, got {declaration.crosstalk}"
            raise RequestRefusedError("value", text)
        if not declaration.group < declaration.every:
            text = f"{where}.Group: expected less than Every {declaration.every}, got {declaration.group}"
            raise RequestRefusedError("value", text)

    def width(self, declaration: Proximity) -> int:  # noqa: ARG002 - as `Kind` has it
        """Return the numbers in a sample."""
        return SAMPLE_WIDTH

    def memory(self, declaration: Proximity) -> int:  # noqa: ARG002 - as `Kind` has it
        """Return 0: it remembers nothing."""
        return 0

    def compile(self, fitted: Sequence[Fitted], timetable: Ints) -> ProximityBlock:
        """Return the block."""
        models = [sensor.declaration.model for sensor in fitted]
        sonar = np.array([model == "sonar" for model in models])
        infrared = np.array([model == "infrared" for model in models])
        errors = [_infrared(one.declaration) for one in fitted if one.declaration.model == "infrared"]
        ears = [
            (one.declaration.dropout, one.declaration.crosstalk) for one in fitted if one.declaration.model == "sonar"
        ]
        return ProximityBlock(
            seeing=_lookouts([one for one in fitted if one.declaration.model != "sonar"]),
            seeing_times=timetable[~sonar],
            infrared=np.array(errors, dtype=np.float64).reshape(-1, 4),
            infrared_times=timetable[infrared],
            sonars=_lookouts([one for one in fitted if one.declaration.model == "sonar"]),
            ears=np.array(ears, dtype=np.float64).reshape(-1, 2),
            sonar_times=timetable[sonar],
        )

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> ProximityReading:
        """Return the distance, or why there is none."""
        status, distance = sample
        if status == OK:
            return ProximityReading(id=sensor.declaration.id, tick=tick, value=distance)
        return ProximityReading(id=sensor.declaration.id, tick=tick, status=_STATUS[int(status)])


def _infrared(declaration: Proximity) -> tuple[float, ...]:
    sigma = declaration.noise_volts / VOLT_METRES
    return sigma, declaration.dropout, declaration.min_range, declaration.max_range


def _lookouts(fitted: Sequence[Fitted]) -> _Lookouts:
    """Return the sensors; those of one body and one mount share a station."""
    stations: list[tuple[float, float, float, float]] = []
    crews: list[tuple[int, bool, int, int]] = []
    eyes: list[tuple[float, ...]] = []
    for (body, mount), group in groupby(fitted, key=lambda sensor: (sensor.body, sensor.declaration.mount)):
        sensors = list(group)
        begin = len(eyes)
        eyes.extend(_eye(sensor.declaration) for sensor in sensors)
        reach = max(
            math.sqrt(sensor.declaration.x**2 + sensor.declaration.y**2) + sensor.declaration.max_range
            for sensor in sensors
        )
        start = sensors[0].start
        stations.append((start.x, start.y, start.heading, reach))
        crews.append((body, mount == "start", begin, len(eyes)))
    return _Lookouts(
        stations=np.array(stations, dtype=np.float64).reshape(-1, STATION_COLUMNS),
        crews=np.array(crews, dtype=np.int64).reshape(-1, CREW_COLUMNS),
        eyes=np.array(eyes, dtype=np.float64).reshape(-1, EYE_COLUMNS),
    )


def _eye(declaration: Proximity) -> tuple[float, ...]:
    half_cos, half_sin = unit_vector(0.5 * declaration.cone_deg)
    return (
        declaration.x,
        declaration.y,
        declaration.z,
        *unit_vector(declaration.direction_deg),
        half_cos,
        half_sin,
        declaration.min_range,
        declaration.max_range,
    )
