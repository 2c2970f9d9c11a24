"""The arrays of proximity sensors, of one body and of all.

Those of a body are made once. Bodies that come or go only put them together anew.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import groupby
from operator import attrgetter
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from intellwheels_schemas.messages import Position, Proximity
from intellwheels_schemas.sonar_devices import (
    DEVICES,
    FREQUENCY,
    SPEED_OF_SOUND,
    SURE_SHARE,
    THIN_DISTANCE,
    THIN_WIDTH,
)
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.proximity_wedges import (
    BEAM_COLUMNS,
    GROUP_BEGIN,
    GROUP_COLUMNS,
    GROUP_END,
    GROUP_OWNER,
    MOUNT_COLUMNS,
    MOUNT_REACH,
)
from intellwheels_server.world.kernels.sonar_beam import FIGURE_COLUMNS
from intellwheels_server.world.sensors.angles import unit_vector

VOLT_METRES: Final = 0.47
"""c of an infrared sensor, V m: MODEL.md's 10 mV are then 2 mm at 0.3 m and 48 mm at 1.5 m."""

# Columns of an infrared block, float64[sensors, 4]: standard deviation over the square of the distance, 1/m; share of
# samples that fail; range, m.
SIGMA, DROPOUT, NEAREST, FARTHEST = 0, 1, 2, 3


class Grouped(NamedTuple):
    """Sensors grouped by their mounts, as kernels take them."""

    mounts: Floats
    groups: Ints
    beams: Floats


class Piece(NamedTuple):
    """The sensors of one body, whose index counts as 0 and whose sensors count from 0.

    Attributes:
        seeing: Ideal and infrared ones.
        sonars: Sonars.
        infrared: float64[infrared ones, 4].
        sonar_figures: float64[sonars, FIGURE_COLUMNS].
        sonar: bool[sensors], whether each is a sonar.
        is_infrared: bool[sensors], whether each is an infrared one.
    """

    seeing: Grouped
    sonars: Grouped
    infrared: Floats
    sonar_figures: Floats
    sonar: NDArray[np.bool_]
    is_infrared: NDArray[np.bool_]


def piece_of(declarations: Sequence[Proximity], start: Position) -> Piece:
    """Return the arrays of the sensors of a body, mounted on the body before those left at its start."""
    own = _declared(tuple(declarations))
    return own._replace(seeing=_started(own.seeing, start), sonars=_started(own.sonars, start))


@lru_cache(maxsize=256)  # most bodies have the sensors of another one
def _declared(declarations: tuple[Proximity, ...]) -> Piece:
    """Return the arrays of the sensors of a body with index 0 that starts at the origin."""
    seeing = [one for one in declarations if one.model != "sonar"]
    sonars = [one for one in declarations if one.model == "sonar"]
    infrared = [one for one in seeing if one.model == "infrared"]
    return Piece(
        seeing=_grouped(seeing),
        sonars=_grouped(sonars),
        infrared=np.array([_infrared(one) for one in infrared], dtype=np.float64).reshape(-1, 4),
        sonar_figures=np.array([_figures(one) for one in sonars], dtype=np.float64).reshape(-1, FIGURE_COLUMNS),
        sonar=np.array([one.model == "sonar" for one in declarations]),
        is_infrared=np.array([one.model == "infrared" for one in declarations]),
    )


def _grouped(declarations: Sequence[Proximity]) -> Grouped:
    """Return the sensors of a body grouped: those of one frame share a mount."""
    mounts: list[tuple[float, float, float, float]] = []
    groups: list[tuple[int, bool, int, int]] = []
    for mount, group in groupby(declarations, key=attrgetter("mount")):
        sensors = list(group)
        begin = groups[-1][GROUP_END] if groups else 0
        reach = max(math.sqrt(one.x * one.x + one.y * one.y) + one.max_range for one in sensors)
        mounts.append((0.0, 0.0, 0.0, reach))
        groups.append((0, mount == "start", begin, begin + len(sensors)))
    return Grouped(
        mounts=np.array(mounts, dtype=np.float64).reshape(-1, MOUNT_COLUMNS),
        groups=np.array(groups, dtype=np.int64).reshape(-1, GROUP_COLUMNS),
        beams=np.array([_beam(one) for one in declarations], dtype=np.float64).reshape(-1, BEAM_COLUMNS),
    )


def _started(grouped: Grouped, start: Position) -> Grouped:
    """Return the sensors of a body that starts at a pose."""
    mounts = grouped.mounts.copy()
    mounts[:, :MOUNT_REACH] = start.x, start.y, start.heading
    return grouped._replace(mounts=mounts)


def joined(grouped: Sequence[Grouped], bodies: Ints) -> Grouped:
    """Return the sensors of bodies as one, with the index of each body and with sensors counted through."""
    groups = np.concatenate([one.groups for one in grouped])
    counts = [len(one.groups) for one in grouped]
    groups[:, GROUP_OWNER] = np.repeat(bodies, counts)
    firsts = np.cumsum([0, *[len(one.beams) for one in grouped[:-1]]])
    groups[:, GROUP_BEGIN : GROUP_END + 1] += np.repeat(firsts, counts)[:, np.newaxis]
    return Grouped(
        mounts=np.concatenate([one.mounts for one in grouped]),
        groups=groups,
        beams=np.concatenate([one.beams for one in grouped]),
    )


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


def _infrared(declaration: Proximity) -> tuple[float, ...]:
    sigma = declaration.noise_volts / VOLT_METRES
    return sigma, declaration.dropout, declaration.min_range, declaration.max_range


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
