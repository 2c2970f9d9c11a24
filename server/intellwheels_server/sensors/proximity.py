"""Proximity sensors: the nearest distance in a wedge. See `kernels.sensing` for how it is found."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Proximity, ProximityReading, Robot, Status
from intellwheels_server.kernels.arrays import Floats, Ints
from intellwheels_server.kernels.elementary import sincos
from intellwheels_server.kernels.sensing import (
    CREW_COLUMNS,
    EYE_COLUMNS,
    OK,
    SAMPLE_WIDTH,
    STATION_COLUMNS,
    sense_proximity,
)
from intellwheels_server.sensors.kind import Fitted, View

_STATUS: tuple[Status, ...] = ("ok", "none", "near", "fault")
# Exact where a heading is: a sensor that looks to the side looks to the side.
_QUARTERS = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}


def unit_vector(degrees: float) -> tuple[float, float]:
    """Return cosine and sine of an angle in degrees, exact for quarter turns."""
    quarter = _QUARTERS.get(degrees % 360.0)
    if quarter is not None:
        return quarter
    sine, cosine = sincos(math.radians(degrees))
    return cosine, sine


@dataclass(frozen=True)
class ProximityBlock:
    """All proximity sensors: what `sense_proximity` takes of them."""

    stations: Floats
    crews: Ints
    eyes: Floats
    timetable: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        sense_proximity(
            tick,
            view.numbers,
            view.parts,
            view.part_start,
            *view.walls,
            self.stations,
            self.crews,
            self.eyes,
            self.timetable,
            samples,
        )


class ProximityKind:
    """The kind that serves `Proximity`."""

    field = "proximity"
    width = SAMPLE_WIDTH

    def check(self, where: str, declaration: Proximity, robot: Robot) -> None:  # noqa: ARG002 - as `Kind` has it
        """Refuse models that are not simulated yet."""
        if declaration.model != "ideal":
            text = f"{where}.Model: expected ideal, got '{declaration.model}', which is not simulated yet"
            raise RequestRefusedError("value", text)

    def compile(self, fitted: Sequence[Fitted], timetable: Ints) -> ProximityBlock:
        """Return the block; sensors of one body and one mount share a station."""
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
        return ProximityBlock(
            stations=np.array(stations, dtype=np.float64).reshape(-1, STATION_COLUMNS),
            crews=np.array(crews, dtype=np.int64).reshape(-1, CREW_COLUMNS),
            eyes=np.array(eyes, dtype=np.float64).reshape(-1, EYE_COLUMNS),
            timetable=timetable,
        )

    def reading(self, declaration: Proximity, tick: int | None, sample: Sequence[float]) -> ProximityReading:
        """Return the distance, or why there is none."""
        status, distance = sample
        if status == OK:
            return ProximityReading(id=declaration.id, tick=tick, value=distance)
        return ProximityReading(id=declaration.id, tick=tick, status=_STATUS[int(status)])


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
