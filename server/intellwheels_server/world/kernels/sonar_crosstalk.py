"""Crosstalk of sonars: one that fires in the same tick may take the chirp of another for its own echo.

This needs two sonars that face each other with nothing between them. The sound travels one way only, so half the way
counts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls
from intellwheels_server.world.kernels.line_of_sight import in_sight
from intellwheels_server.world.kernels.noise import uniform
from intellwheels_server.world.kernels.proximity_wedges import BEAM_FARTHEST, BEAM_HALF_COS, BEAM_HALF_SIN, BEAM_Z
from intellwheels_server.world.kernels.sample_schedule import KEY0, KEY1
from intellwheels_server.world.kernels.spatial_query import PlacedBodies

# Columns of a sonar's errors, float64[sensors, 2]: share of samples that fail; share of chirps taken for an echo.
SONAR_DROPOUT, SONAR_CROSSTALK = 0, 1

# Draw of a sensor and tick.
_CROSSTALK_DRAW = 1


class Sonars(NamedTuple):
    """All sonars at a tick.

    Attributes:
        beams: float64[sensors, 9], columns of `proximity_wedges`.
        errors: float64[sensors, 2], columns `SONAR_DROPOUT`, `SONAR_CROSSTALK`.
        schedule: int64[sensors, 8].
        owners: int64[sensors], the body of each.
        poses: float64[sensors, 4], position, m, and unit vector of the direction, in the world, of sonars that fire.
        due: int64[k], sonars that fire, ascending.
    """

    beams: Floats
    errors: Floats
    schedule: Ints
    owners: Ints
    poses: Floats
    due: Ints


@njit(cache=True, error_model="numpy")
def hear_others(tick: int, sonars: Sonars, placed: PlacedBodies, walls: Walls, heard: Floats) -> None:
    """Shorten distances to half the way to the nearest sonar that chirps at a sonar prone to crosstalk.

    Args:
        tick: The tick.
        sonars: All sonars.
        placed: The bodies.
        walls: The walls.
        heard: float64[sensors], m, in and out.
    """
    beams, errors, schedule, owners, poses, due = sonars
    part_start, boxes, (pieces, links, edges, cells, frame) = placed.part_start, placed.boxes, walls
    opaque = np.ones(part_start.shape[0] - 1, np.int64)
    order = due[np.argsort(poses[due, 0])]
    ordered_x = poses[order, 0]
    for sensor in due:
        share = errors[sensor, SONAR_CROSSTALK]
        if share <= 0.0:
            continue
        key0, key1 = np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1])
        if uniform(key0, key1, tick, _CROSSTALK_DRAW) >= share:
            continue
        x, y, z = poses[sensor, 0], poses[sensor, 1], beams[sensor, BEAM_Z]
        farthest = beams[sensor, BEAM_FARTHEST]
        first = np.searchsorted(ordered_x, x - farthest)
        for at in range(first, order.shape[0]):
            other = order[at]
            dx, dy = poses[other, 0] - x, poses[other, 1] - y
            if dx > farthest:
                break
            square = dx * dx + dy * dy
            if other == sensor or square > farthest * farthest or 0.25 * square >= heard[sensor] * heard[sensor]:
                continue
            ahead = poses[sensor, 2] * dx + poses[sensor, 3] * dy
            aside = poses[sensor, 2] * dy - poses[sensor, 3] * dx
            if not beams[sensor, BEAM_HALF_SIN] * ahead >= beams[sensor, BEAM_HALF_COS] * abs(aside):
                continue
            ahead = -(poses[other, 2] * dx + poses[other, 3] * dy)
            aside = poses[other, 2] * dy - poses[other, 3] * dx
            if not beams[other, BEAM_HALF_SIN] * ahead >= beams[other, BEAM_HALF_COS] * abs(aside):
                continue
            opaque[owners[sensor]] = opaque[owners[other]] = 0
            seen = in_sight(
                x, y, z, poses[other, 0], poses[other, 1], boxes, part_start, opaque, pieces, links, edges, cells,
                frame,
            )  # fmt: skip
            opaque[owners[sensor]] = opaque[owners[other]] = 1
            if seen:
                heard[sensor] = 0.5 * math.sqrt(square)
