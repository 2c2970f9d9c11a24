"""Proximity sensors: the nearest distance in a wedge, exact or as an infrared sensor or a sonar measures it.

`ideal` gives the exact distance. `infrared` measures by triangulation: its voltage is V = c / d, so noise of the
voltage becomes a standard deviation that grows with the square of the distance. It never reports beyond its range.
`sonar` hears only echoes: see `kernels.sonar_echoes`. It has the figures of a device of
`intellwheels_schemas.sonar_devices`, or the beam that its declaration says. Kernels of `kernels.proximity_wedges` find
the distances of the others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import groupby
from typing import Final, NamedTuple, get_args

import numpy as np
from numba import njit

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Map, Model, Proximity, ProximityReading, Status
from intellwheels_schemas.sonar_devices import (
    DEVICES,
    FREQUENCY,
    SPEED_OF_SOUND,
    SURE_SHARE,
    THIN_DISTANCE,
    THIN_WIDTH,
    reading_time,
    sample_time,
    ticks_for,
)
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.measures_text import DECIMAL
from intellwheels_server.world.kernels.noise import normal, uniform
from intellwheels_server.world.kernels.proximity_wedges import (
    BEAM_COLUMNS,
    GROUP_COLUMNS,
    MOUNT_COLUMNS,
    SAMPLE_WIDTH,
    STATUS_FAULT,
    STATUS_OK,
    sense_proximity,
    sense_proximity_many,
)
from intellwheels_server.world.kernels.sample_schedule import KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.sonar_beam import FIGURE_COLUMNS
from intellwheels_server.world.kernels.sonar_echoes import sense_sonars
from intellwheels_server.world.sensors.angles import unit_vector
from intellwheels_server.world.sensors.kind import Array, Fitted, Kind, ManyViews, View, Written
from intellwheels_server.world.shared_work import parts_of, share

WEDGE_RAYS: Final = 2.0
"""Rays of a lidar that cost as much as an exact or infrared wedge."""
SONAR_RAYS: Final = 10.0
"""Rays of a lidar that cost as much as a sonar."""
CROSSTALK_RAYS: Final = 15.0
"""Rays of a lidar that cost as much as looking for the pings of others, measured with eight sonars on each body."""
FEWEST_SHARED: Final = 200
"""Bodies with sensors from which on a second thread takes less time than it costs."""
VOLT_METRES: Final = 0.47
"""c of an infrared sensor, V m: MODEL.md's 10 mV are then 2 mm at 0.3 m and 48 mm at 1.5 m."""

_STATUS: tuple[Status, ...] = ("ok", "none", "near", "fault")

# Columns of an infrared block, float64[sensors, 4]: standard deviation over the square of the distance, 1/m; share of
# samples that fail; range, m.
_SIGMA, _DROPOUT, _NEAREST, _FARTHEST = 0, 1, 2, 3


@njit(cache=True, error_model="numpy")
def _spoil(tick: int, infrared: Floats, schedule: Ints, samples: Floats) -> None:
    """Turn the exact samples that were taken at a tick into those of infrared sensors."""
    for sensor in range(infrared.shape[0]):
        slot = due_slot(schedule, sensor, tick, SAMPLE_WIDTH)
        if slot < 0:
            continue
        key0, key1 = np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1])
        if samples[slot] == STATUS_OK:
            exact = samples[slot + 1]
            told = exact + infrared[sensor, _SIGMA] * exact * exact * normal(key0, key1, tick, 0)
            samples[slot + 1] = min(max(told, infrared[sensor, _NEAREST]), infrared[sensor, _FARTHEST])
        if infrared[sensor, _DROPOUT] > 0.0 and uniform(key0, key1, tick, 1) < infrared[sensor, _DROPOUT]:
            samples[slot] = STATUS_FAULT
            samples[slot + 1] = 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def _spoil_many(ticks: Ints, samples: Floats, first: int, end: int, infrared: Floats, schedule: Ints) -> None:
    """Turn the exact samples of some worlds, of which every array has a row each, into those of infrared sensors."""
    for world in range(first, end):
        _spoil(ticks[world], infrared[world], schedule[world], samples[world])


class _Grouped(NamedTuple):
    """Sensors grouped by their mounts, as kernels take them."""

    mounts: Floats
    groups: Ints
    beams: Floats


@dataclass(frozen=True)
class ProximityBlock:
    """All proximity sensors: ideal and infrared ones, the errors of the infrared ones, and sonars."""

    seeing: _Grouped
    seeing_schedule: Ints
    infrared: Floats
    infrared_schedule: Ints
    sonars: _Grouped
    sonar_figures: Floats
    sonar_schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        numbers, parts, part_start = view.numbers, view.parts, view.part_start
        if len(self.seeing_schedule):
            if view.threads > 1 and len(self.seeing.groups) >= FEWEST_SHARED:
                share(partial(self._see, tick, view, samples), parts_of(len(self.seeing.groups), view.threads))
            else:
                sense_proximity(
                    tick, numbers, parts, part_start, *view.walls, *self.seeing, self.seeing_schedule, samples
                )  # fmt: skip
        if len(self.infrared_schedule):
            _spoil(tick, self.infrared, self.infrared_schedule, samples)
        if len(self.sonar_schedule):
            of = self.sonars
            sense_sonars(
                tick, view.period, numbers, parts, part_start, *view.walls, of.mounts, of.groups, of.beams,
                self.sonar_figures, self.sonar_schedule, samples,
            )  # fmt: skip

    def _see(self, tick: int, view: View, samples: Floats, first: int, end: int) -> None:
        """Store the exact samples of some mounts."""
        mounts, groups, beams = self.seeing
        sense_proximity(
            tick, view.numbers, view.parts, view.part_start, *view.walls, mounts[first:end], groups[first:end], beams,
            self.seeing_schedule, samples,
        )  # fmt: skip

    def stackable(self) -> tuple[Array, ...] | None:
        """Return the arrays that `take_many` needs; None if there is a sonar."""
        if len(self.sonar_schedule):
            return None
        return *self.seeing, self.seeing_schedule, self.infrared, self.infrared_schedule

    @staticmethod
    def take_many(
        ticks: Ints, views: ManyViews, arrays: Sequence[Array], samples: Floats, first: int, end: int
    ) -> None:
        """Store the samples that are due in some worlds."""
        *seeing, infrared, infrared_schedule = arrays
        sense_proximity_many(
            ticks, views.numbers, samples, first, end, views.parts, views.part_start, *(*views.walls, *seeing)
        )  # fmt: skip
        if infrared.shape[1]:
            _spoil_many(ticks, samples, first, end, infrared, infrared_schedule)


class ProximityKind(Kind):
    """The kind that serves `Proximity`."""

    declaration = Proximity
    sample_width = SAMPLE_WIDTH

    def phase(self, declaration: Proximity, /) -> int:
        """Return the ticks that its firing group waits."""
        return declaration.group

    def examples(self, _floor: Map, /) -> tuple[Proximity, ...]:
        """Return a sensor of each model."""
        return tuple(
            Proximity(
                id=model,
                x=0.5,
                y=0.0,
                z=0.4,
                direction_deg=0.0,
                cone_deg=30.0,
                max_range=4.0,
                model=model,
                every=50 if model == "sonar" else 1,
                latency=int(model == "sonar"),
                crosstalk=float(model == "sonar"),
            )
            for model in get_args(Model)
        )

    def check_fields(self, where: str, declaration: Proximity, /) -> None:
        """Refuse what the model does not have, a firing group without a tick at this rate, and what no device is."""
        if declaration.model == "ideal" and declaration.dropout > 0.0:
            raise RequestRefusedError(
                "value", f"{where}.Dropout: expected 0 with the model ideal, got {declaration.dropout}"
            )
        if declaration.model != "sonar":
            for name, value in (
                ("Crosstalk", declaration.crosstalk),
                ("PingDelay", declaration.ping_delay),
                ("SecondPingDelay", declaration.second_ping_delay),
            ):
                if value > 0.0:
                    text = f"{where}.{name}: expected 0 with the model {declaration.model}, got {value}"
                    raise RequestRefusedError("value", text)
            if declaration.device is not None:
                text = f"{where}.Device: expected none with the model {declaration.model}, got '{declaration.device}'"
                raise RequestRefusedError("value", text)
        _check_device(where, declaration)
        if not declaration.group < declaration.every:
            text = f"{where}.Group: expected less than Every {declaration.every}, got {declaration.group}"
            raise RequestRefusedError("value", text)

    def check_timing(self, where: str, declaration: Proximity, period: float, /) -> None:
        """Refuse a sonar that pings again while it still listens, or whose reading comes before its last echo can."""
        if declaration.model != "sonar":
            return
        delays = declaration.ping_delay, declaration.second_ping_delay
        wanted = reading_time(declaration.max_range, *delays)
        least = ticks_for(wanted, period)
        if declaration.latency < least:
            text = f"{where}.Latency: expected at least {least}, as the last echo is back after {wanted:.3g} s"
            raise RequestRefusedError("value", f"{text}, got {declaration.latency}")
        name, wanted = declaration.device, sample_time(declaration.device, declaration.max_range, *delays)
        least = ticks_for(wanted, period)
        if declaration.every < least:
            text = f"{where}.Every: expected at least {least}, as {name or 'a sonar'} pings once in {wanted:.3g} s"
            raise RequestRefusedError("value", f"{text}, got {declaration.every}")

    def rays(self, declaration: Proximity, /) -> float:
        """Return the rays of a lidar that cost as much, measured with wedges of 30 degrees and 4 m."""
        if declaration.model != "sonar":
            return WEDGE_RAYS
        return SONAR_RAYS + (CROSSTALK_RAYS if declaration.crosstalk > 0.0 else 0.0)

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> ProximityBlock:
        """Return the block."""
        models = [sensor.declaration.model for sensor in fitted]
        sonar = np.array([model == "sonar" for model in models])
        infrared = np.array([model == "infrared" for model in models])
        infrared_errors = [_infrared(one.declaration) for one in fitted if one.declaration.model == "infrared"]
        sonar_figures = [_figures(one.declaration) for one in fitted if one.declaration.model == "sonar"]
        return ProximityBlock(
            seeing=_grouped([one for one in fitted if one.declaration.model != "sonar"]),
            seeing_schedule=schedule[~sonar],
            infrared=np.array(infrared_errors, dtype=np.float64).reshape(-1, 4),
            infrared_schedule=schedule[infrared],
            sonars=_grouped([one for one in fitted if one.declaration.model == "sonar"]),
            sonar_figures=np.array(sonar_figures, dtype=np.float64).reshape(-1, FIGURE_COLUMNS),
            sonar_schedule=schedule[sonar],
        )

    def written(self, _sensor: Fitted, /) -> Written:
        """Return the status as the code, and the distance."""
        return Written((("value", DECIMAL),), codes=len(_STATUS))

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> ProximityReading:
        """Return the distance, or why there is none."""
        status, distance = sample
        if status == STATUS_OK:
            return ProximityReading(id=sensor.declaration.id, tick=tick, value=distance)
        return ProximityReading(id=sensor.declaration.id, tick=tick, status=_STATUS[int(status)])


def _infrared(declaration: Proximity) -> tuple[float, ...]:
    sigma = declaration.noise_volts / VOLT_METRES
    return sigma, declaration.dropout, declaration.min_range, declaration.max_range


def _check_device(where: str, declaration: Proximity) -> None:
    """Refuse a beam or a range that the device does not have."""
    if declaration.device is None:
        return
    name, device = declaration.device, DEVICES[declaration.device]
    if declaration.cone_deg != device.cone_deg:
        text = f"{where}.ConeDeg: expected {device.cone_deg:g} of {name}, got {declaration.cone_deg:g}"
        raise RequestRefusedError("value", text)
    if declaration.min_range < device.min_range:
        text = f"{where}.MinRange: expected at least {device.min_range:g} of {name}, got {declaration.min_range:g}"
        raise RequestRefusedError("value", text)
    if declaration.max_range > device.max_range:
        text = f"{where}.MaxRange: expected at most {device.max_range:g} of {name}, got {declaration.max_range:g}"
        raise RequestRefusedError("value", text)


def _figures(declaration: Proximity) -> tuple[float, ...]:
    """Return the row of a sonar in a figure block of `kernels.sonar_beam`."""
    limit_deg = 0.5 * declaration.cone_deg
    sure_deg, frequency = SURE_SHARE * limit_deg, FREQUENCY
    if declaration.device is not None:
        device = DEVICES[declaration.device]
        sure_deg, limit_deg, frequency = device.sure_deg, device.limit_deg, device.frequency
    return (
        declaration.dropout,
        declaration.crosstalk,
        math.radians(sure_deg),
        math.radians(limit_deg),
        # Slightly less, so that the thing of the source is heard whatever is rounded.
        (1.0 - 1e-9) * THIN_WIDTH / (THIN_DISTANCE * THIN_DISTANCE * THIN_DISTANCE),
        SPEED_OF_SOUND / frequency,
        declaration.ping_delay,
        declaration.second_ping_delay,
    )


def _grouped(fitted: Sequence[Fitted]) -> _Grouped:
    """Return the sensors grouped: those of one body and one frame share a mount."""
    mounts: list[tuple[float, float, float, float]] = []
    groups: list[tuple[int, bool, int, int]] = []
    beams: list[tuple[float, ...]] = []
    for (body, mount), group in groupby(fitted, key=lambda sensor: (sensor.body, sensor.declaration.mount)):
        sensors = list(group)
        begin = len(beams)
        own, reach = _beams(tuple([sensor.declaration for sensor in sensors]))
        beams.extend(own)
        start = sensors[0].start
        mounts.append((start.x, start.y, start.heading, reach))
        groups.append((body, mount == "start", begin, len(beams)))
    return _Grouped(
        mounts=np.array(mounts, dtype=np.float64).reshape(-1, MOUNT_COLUMNS),
        groups=np.array(groups, dtype=np.int64).reshape(-1, GROUP_COLUMNS),
        beams=np.array(beams, dtype=np.float64).reshape(-1, BEAM_COLUMNS),
    )


@lru_cache(maxsize=256)  # most bodies have the sensors of another one, and every join compiles all of them again
def _beams(declarations: tuple[Proximity, ...]) -> tuple[tuple[tuple[float, ...], ...], float]:
    """Return the beams of the sensors of a mount, and how far from it they reach, m."""
    reach = max(math.sqrt(one.x * one.x + one.y * one.y) + one.max_range for one in declarations)
    return tuple(_beam(one) for one in declarations), reach


def _beam(declaration: Proximity) -> tuple[float, ...]:
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
