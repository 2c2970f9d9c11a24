"""Beacons: the bearing of a named place of the map from a point of the body, if it can be seen from there.

It is seen within the cone and the range, unless a wall or another body stands between at the sensor's height.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Beacon, BeaconReading, Map, Place
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.elementary import atan2, sincos, wrap
from intellwheels_server.world.kernels.line_of_sight import in_sight
from intellwheels_server.world.kernels.measures_text import HEADING
from intellwheels_server.world.kernels.noise import normal
from intellwheels_server.world.kernels.sample_schedule import BODY, KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.sensor_errors import BIAS_MEMORY, memory_of, walk
from intellwheels_server.world.kernels.spatial_query import place_boxes
from intellwheels_server.world.sensors.angles import unit_vector, written_heading
from intellwheels_server.world.sensors.kind import Fitted, Kind, View, Written

# Columns of the settings, float64[sensors, 13]: the place, NaN where the map has none; the point and height; direction
# and half the cone; range, m; noise, walk and step, rad.
_PLACE_X, _PLACE_Y, _X, _Y, _Z, _COS, _SIN, _HALF_COS, _HALF_SIN, _RANGE = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9
_SIGMA, _WALK, _STEP = 10, 11, 12

# A sample: 1 if it is seen, and the bearing, rad.
_WIDTH = 2


def find_place(floor: Map, name: str) -> Place | None:
    """Return the place of that name, or None if the map has none."""
    places = () if floor.grid is None else floor.grid.position
    return next((place for place in places if place.name == name), None)


@njit(cache=True, error_model="numpy")
def _take(
    tick: int,
    period: float,
    numbers: Floats,
    parts: Floats,
    part_start: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    settings: Floats,
    schedule: Ints,
    samples: Floats,
) -> None:
    any_due = False
    for sensor in range(schedule.shape[0]):
        if settings[sensor, _WALK] > 0.0:
            walk(schedule, sensor, tick, _WIDTH, 1, settings[sensor, _WALK], 0.0, period, samples)
        any_due |= due_slot(schedule, sensor, tick, _WIDTH) >= 0
    if not any_due:
        return
    boxes, _ = place_boxes(numbers, parts, part_start)
    opaque = np.ones(numbers.shape[1], np.int64)
    for sensor in range(schedule.shape[0]):
        slot = due_slot(schedule, sensor, tick, _WIDTH)
        if slot < 0:
            continue
        samples[slot] = samples[slot + 1] = 0.0
        body = schedule[sensor, BODY]
        s, c = sincos(numbers[rows.HEADING, body])
        x = numbers[rows.X, body] + (c * settings[sensor, _X] - s * settings[sensor, _Y])
        y = numbers[rows.Y, body] + (s * settings[sensor, _X] + c * settings[sensor, _Y])
        dx, dy = settings[sensor, _PLACE_X] - x, settings[sensor, _PLACE_Y] - y
        # From here on in the body frame.
        forward, left = c * dx + s * dy, c * dy - s * dx
        if not forward * forward + left * left <= settings[sensor, _RANGE] * settings[sensor, _RANGE]:
            continue
        ahead = settings[sensor, _COS] * forward + settings[sensor, _SIN] * left
        aside = settings[sensor, _COS] * left - settings[sensor, _SIN] * forward
        if not settings[sensor, _HALF_SIN] * ahead >= settings[sensor, _HALF_COS] * abs(aside):
            continue
        opaque[body] = 0
        seen = in_sight(
            x, y, settings[sensor, _Z], settings[sensor, _PLACE_X], settings[sensor, _PLACE_Y], boxes, part_start,
            opaque, pieces, links, edges, cells, frame,
        )  # fmt: skip
        opaque[body] = 1
        if not seen:
            continue
        bearing = atan2(left, forward)
        if settings[sensor, _WALK] > 0.0:
            bearing += samples[memory_of(schedule, sensor, _WIDTH) + 1]
        if settings[sensor, _SIGMA] > 0.0:
            key0, key1 = np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1])
            bearing += settings[sensor, _SIGMA] * normal(key0, key1, tick, 0)
        if settings[sensor, _STEP] > 0.0:
            bearing = settings[sensor, _STEP] * np.floor(bearing / settings[sensor, _STEP] + 0.5)
        samples[slot] = 1.0
        samples[slot + 1] = wrap(bearing)


@dataclass(frozen=True)
class BeaconBlock:
    """All beacons."""

    settings: Floats
    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(
            tick,
            view.period,
            view.numbers,
            view.parts,
            view.part_start,
            *view.walls,
            self.settings,
            self.schedule,
            samples,
        )


class BeaconKind(Kind):
    """The kind that serves `Beacon`."""

    declaration = Beacon
    sample_width = _WIDTH

    def check(self, where: str, declaration: Beacon, floor: Map, /) -> None:
        """Refuse a beacon at a place that the map does not have."""
        if find_place(floor, declaration.place) is None:
            text = f"{where}.Place: expected a place of map '{floor.name}', got '{declaration.place}'"
            raise RequestRefusedError("no-place", text)

    def examples(self, floor: Map, /) -> tuple[Beacon, ...]:
        """Return a beacon at the first place of the map."""
        place = floor.grid.position[0].name if floor.grid is not None else ""
        return (Beacon(id=self.field, place=place),)

    def memory(self, declaration: Beacon, /) -> int:
        """Return the memory of the random walk of the bias, if it has one."""
        return BIAS_MEMORY if declaration.walk_deg > 0.0 else 0

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> BeaconBlock:
        """Return the block."""
        return BeaconBlock(np.array([_settings(sensor) for sensor in fitted], dtype=np.float64), schedule)

    def written(self, _sensor: Fitted, /) -> Written:
        """Return whether it is seen as the code, and the bearing."""
        return Written((("value", HEADING),), codes=2)

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> BeaconReading:
        """Return the bearing in the body frame, rad, or that it is not seen."""
        if sample[0] == 0.0:
            return BeaconReading(id=sensor.declaration.id, tick=tick, status="none")
        return BeaconReading(id=sensor.declaration.id, tick=tick, value=written_heading(sample[1]))


def _settings(sensor: Fitted) -> tuple[float, ...]:
    one: Beacon = sensor.declaration
    place = find_place(sensor.floor, one.place)
    return (
        math.nan if place is None else place.x,
        math.nan if place is None else place.y,
        one.x,
        one.y,
        one.z,
        *unit_vector(one.direction_deg),
        *unit_vector(0.5 * one.cone_deg),
        one.max_range,
        *(math.radians(degrees) for degrees in (one.noise_deg, one.walk_deg, one.step_deg)),
    )
