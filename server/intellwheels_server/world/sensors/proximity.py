"""Proximity sensors: the nearest distance in a wedge, exact or as an infrared sensor or a sonar measures it.

`ideal` gives the exact distance. `infrared` measures by triangulation: its voltage is V = c / d, so noise of the
voltage becomes a standard deviation that grows with the square of the distance. It never reports beyond its range.
`sonar` hears only echoes: see `kernels.sonar_echoes`. It has the figures of a device of
`intellwheels_schemas.sonar_devices`, or the beam that its declaration says. Kernels of `kernels.proximity_wedges` find
the distances of the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from operator import itemgetter
from typing import Final, get_args

import numpy as np
from numba import njit

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Map, Model, Proximity, ProximityReading, Status
from intellwheels_schemas.sonar_devices import (
    DEVICES,
    reading_time,
    sample_time,
    ticks_for,
)
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.measures_text import DECIMAL
from intellwheels_server.world.kernels.noise import normal, uniform
from intellwheels_server.world.kernels.proximity_wedges import (
    SAMPLE_WIDTH,
    STATUS_FAULT,
    STATUS_OK,
    sense_proximity,
    sense_proximity_many,
)
from intellwheels_server.world.kernels.sample_schedule import BODY, KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.sonar_echoes import sense_sonars
from intellwheels_server.world.sensors.kind import Array, Fitted, Kind, ManyViews, View, Written
from intellwheels_server.world.sensors.proximity_arrays import (
    DROPOUT,
    FARTHEST,
    NEAREST,
    SIGMA,
    Grouped,
    Piece,
    joined,
    piece_of,
)
from intellwheels_server.world.shared_work import parts_of, share

WEDGE_RAYS: Final = 2.0
"""Rays of a lidar that cost as much as an exact or infrared wedge."""
SONAR_RAYS: Final = 10.0
"""Rays of a lidar that cost as much as a sonar."""
CROSSTALK_RAYS: Final = 15.0
"""Rays of a lidar that cost as much as looking for the pings of others, measured with eight sonars on each body."""
FEWEST_SHARED: Final = 200
"""Bodies with sensors from which on a second thread takes less time than it costs."""

_STATUS: tuple[Status, ...] = ("ok", "none", "near", "fault")


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
            told = exact + infrared[sensor, SIGMA] * exact * exact * normal(key0, key1, tick, 0)
            samples[slot + 1] = min(max(told, infrared[sensor, NEAREST]), infrared[sensor, FARTHEST])
        if infrared[sensor, DROPOUT] > 0.0 and uniform(key0, key1, tick, 1) < infrared[sensor, DROPOUT]:
            samples[slot] = STATUS_FAULT
            samples[slot + 1] = 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def _spoil_many(ticks: Ints, samples: Floats, first: int, end: int, infrared: Floats, schedule: Ints) -> None:
    """Turn the exact samples of some worlds, of which every array has a row each, into those of infrared sensors."""
    for world in range(first, end):
        _spoil(ticks[world], infrared[world], schedule[world], samples[world])


@dataclass(frozen=True)
class ProximityBlock:
    """All proximity sensors: ideal and infrared ones, the errors of the infrared ones, and sonars."""

    seeing: Grouped
    seeing_schedule: Ints
    infrared: Floats
    infrared_schedule: Ints
    sonars: Grouped
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
        by_body = groupby(zip(schedule[:, BODY].tolist(), fitted, strict=True), key=itemgetter(0))
        return self.assemble([self.piece([sensor for _, sensor in group]) for _, group in by_body], schedule)

    def piece(self, fitted: Sequence[Fitted], /) -> Piece:
        """Return the arrays of one body."""
        return piece_of([sensor.declaration for sensor in fitted], fitted[0].start)

    def assemble(self, pieces: Sequence[Piece], schedule: Ints, /) -> ProximityBlock:
        """Return the block."""
        firsts = np.cumsum([0, *[len(piece.sonar) for piece in pieces[:-1]]])
        bodies = schedule[firsts, BODY]
        sonar = np.concatenate([piece.sonar for piece in pieces])
        return ProximityBlock(
            seeing=joined([piece.seeing for piece in pieces], bodies),
            seeing_schedule=schedule[~sonar],
            infrared=np.concatenate([piece.infrared for piece in pieces]),
            infrared_schedule=schedule[np.concatenate([piece.is_infrared for piece in pieces])],
            sonars=joined([piece.sonars for piece in pieces], bodies),
            sonar_figures=np.concatenate([piece.sonar_figures for piece in pieces]),
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
