"""Measurements of all proximity sensors of all bodies in one tick: the nearest distance in the wedge of each.

One call serves all of them. Sensors that are fixed to the same frame, a body or its start, share a mount. Things
within the reach of a mount are gathered once, by uniform grids over bodies and walls. Each sensor of the mount then
tests the gathered boxes and wall pieces whose z range contains its height. A sensor never sees its own body.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import END_EDGE, FIRST_EDGE, Floats, Ints, Walls
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.grid_search import Place
from intellwheels_server.world.kernels.sample_schedule import due_slot
from intellwheels_server.world.kernels.spatial_query import (
    CENTRE_X,
    CENTRE_Y,
    COS,
    EXTENT_X,
    EXTENT_Y,
    HIGH,
    LONG,
    LOW,
    SIN,
    SLACK,
    WIDE,
    Nearby,
    PlacedBodies,
    gather_bodies,
    gather_walls,
    place_bodies,
    room_for,
)
from intellwheels_server.world.kernels.wedge_distance import box_in_wedge, polygon_in_wedge

# Columns of a mount block, float64[mounts, 4]: pose in the world of a mount that is fixed there, and how far from it
# its sensors see.
MOUNT_X, MOUNT_Y, MOUNT_HEADING, MOUNT_REACH = 0, 1, 2, 3
MOUNT_COLUMNS = 4

# Columns of a group block, int64[mounts, 4]: body that owns the mount, 1 for one fixed in the world, its first sensor
# and one past its last.
GROUP_OWNER, GROUP_FIXED, GROUP_BEGIN, GROUP_END = 0, 1, 2, 3
GROUP_COLUMNS = 4

# Columns of a beam block, float64[sensors, 9], in the mount's frame: place, unit vector of the direction, cosine and
# sine of half the cone, range.
BEAM_X, BEAM_Y, BEAM_Z, BEAM_COS, BEAM_SIN = 0, 1, 2, 3, 4
BEAM_HALF_COS, BEAM_HALF_SIN, BEAM_NEAREST, BEAM_FARTHEST = 5, 6, 7, 8
BEAM_COLUMNS = 9

# A proximity sample: status and distance in metres, 0 without STATUS_OK. Statuses in the order of the wire's.
STATUS_OK, STATUS_NONE, STATUS_NEAR, STATUS_FAULT = 0.0, 1.0, 2.0, 3.0
SAMPLE_WIDTH = 2


@njit(cache=True, error_model="numpy")
def _nearest_box(
    around: Floats,
    count: int,
    x: float,
    y: float,
    z: float,
    direction_x: float,
    direction_y: float,
    half_cos: float,
    half_sin: float,
    squares: Floats,
) -> float:
    """Return the square of the distance at which a wedge sees the nearest of some boxes, inf if it sees none.

    Args:
        around: float64[10, ...], the columns of a block of boxes as rows.
        count: How many boxes, a multiple of `LANES`.
        x: Apex, m.
        y: Apex, m.
        z: Height, m.
        direction_x: Direction of the wedge, a unit vector.
        direction_y: The same.
        half_cos: Cosine of half the cone.
        half_sin: Sine of half the cone.
        squares: float64[>= count], scratch.
    """
    # Every box is measured: on vectors this takes less time than a choice that cannot be predicted.
    for at in range(count):
        c = around[COS, at]
        s = around[SIN, at]
        dx = x - around[CENTRE_X, at]
        dy = y - around[CENTRE_Y, at]
        square = box_in_wedge(
            c * dx + s * dy,
            c * dy - s * dx,
            c * direction_x + s * direction_y,
            c * direction_y - s * direction_x,
            half_cos,
            half_sin,
            around[LONG, at],
            around[WIDE, at],
        )
        squares[at] = square if (around[LOW, at] <= z) & (z < around[HIGH, at]) else np.inf
    least0 = least1 = least2 = least3 = np.inf
    for at in range(0, count, 4):
        least0 = min(least0, squares[at])
        least1 = min(least1, squares[at + 1])
        least2 = min(least2, squares[at + 2])
        least3 = min(least3, squares[at + 3])
    return min(least0, least1, least2, least3)


class Beam(NamedTuple):
    """A sensor's wedge in the world.

    Attributes:
        x: Apex, m.
        y: Apex, m.
        z: Height, m.
        direction_x: Direction, a unit vector.
        direction_y: The same.
        half_cos: Cosine of half the cone.
        half_sin: Sine of half the cone, >= 0.
        farthest: Range, m.
    """

    x: float
    y: float
    z: float
    direction_x: float
    direction_y: float
    half_cos: float
    half_sin: float
    farthest: float


@njit(cache=True, error_model="numpy")
def mount_pose(mounts: Floats, groups: Ints, pose: Floats, mount: int) -> tuple[float, float, float, float]:
    """Return the position of a mount, m, and the cosine and sine of its heading.

    Args:
        mounts: float64[mounts, 4].
        groups: int64[mounts, 4].
        pose: float64[>= 3, n].
        mount: Its number.
    """
    owner = groups[mount, GROUP_OWNER]
    x, y, heading = pose[rows.X, owner], pose[rows.Y, owner], pose[rows.HEADING, owner]
    if groups[mount, GROUP_FIXED] != 0:
        x, y, heading = mounts[mount, MOUNT_X], mounts[mount, MOUNT_Y], mounts[mount, MOUNT_HEADING]
    s, c = sincos(heading)
    return x, y, c, s


@njit(cache=True, error_model="numpy", inline="always")
def beam_at(beams: Floats, sensor: int, x: float, y: float, c: float, s: float) -> Beam:
    """Return a sensor's wedge in the world, given the pose of its mount."""
    return Beam(
        x + (c * beams[sensor, BEAM_X] - s * beams[sensor, BEAM_Y]),
        y + (s * beams[sensor, BEAM_X] + c * beams[sensor, BEAM_Y]),
        beams[sensor, BEAM_Z],
        c * beams[sensor, BEAM_COS] - s * beams[sensor, BEAM_SIN],
        s * beams[sensor, BEAM_COS] + c * beams[sensor, BEAM_SIN],
        beams[sensor, BEAM_HALF_COS],
        beams[sensor, BEAM_HALF_SIN],
        beams[sensor, BEAM_FARTHEST],
    )


# Inlined, so that the compiler sees that the buffers do not overlap: loops over them then run on vectors.
@njit(cache=True, error_model="numpy", inline="always")
def _sense_all(
    tick: int, number: int, pose: Floats, placed: PlacedBodies, walls: Walls, nearby: Nearby, squares: Floats,
    mounts: Floats, groups: Ints, beams: Floats, schedule: Ints, samples: Floats,
) -> None:  # fmt: skip
    """Store the samples that all proximity sensors of a world take at a tick.

    The number is that of the first mount among all that use the same buffers.
    """
    part_start, boxes, extents, cell_start, cell_bodies, grid = placed
    pieces, links, edges, cells, frame = walls
    around, polygons, solids, filled, found, found_for = nearby
    for mount in range(groups.shape[0]):
        begin, end = groups[mount, GROUP_BEGIN], groups[mount, GROUP_END]
        any_due = False
        for sensor in range(begin, end):
            if due_slot(schedule, sensor, tick, SAMPLE_WIDTH) >= 0:
                any_due = True
                break
        if not any_due:
            continue
        x, y, c, s = mount_pose(mounts, groups, pose, mount)
        place = Place(x, y, mounts[mount, MOUNT_REACH] + SLACK, groups[mount, GROUP_OWNER], number + mount)
        of_bodies = gather_bodies(place, part_start, boxes, extents, cell_start, cell_bodies, grid, around, found)
        near, polygon_count = gather_walls(
            place, pieces, links, edges, cells, frame, of_bodies, around, polygons, solids, filled, found, found_for
        )
        # The loop over sensors calls nothing that takes many arrays: passing them costs as much as a sensor.
        for sensor in range(begin, end):
            slot = due_slot(schedule, sensor, tick, SAMPLE_WIDTH)
            if slot < 0:
                continue
            beam = beam_at(beams, sensor, x, y, c, s)
            square = _nearest_box(
                around, near, beam.x, beam.y, beam.z, beam.direction_x, beam.direction_y, beam.half_cos, beam.half_sin,
                squares,
            )  # fmt: skip
            limit = min(square, beam.farthest * beam.farthest) + SLACK
            for at in range(polygon_count):
                piece = polygons[at]
                gap_x = max(abs(solids[piece, CENTRE_X] - beam.x) - solids[piece, EXTENT_X], 0.0)
                gap_y = max(abs(solids[piece, CENTRE_Y] - beam.y) - solids[piece, EXTENT_Y], 0.0)
                if gap_x * gap_x + gap_y * gap_y > limit or not solids[piece, LOW] <= beam.z < solids[piece, HIGH]:
                    continue
                square = min(
                    square,
                    polygon_in_wedge(
                        edges, links[piece, FIRST_EDGE], links[piece, END_EDGE], beam.x, beam.y,
                        beam.direction_x, beam.direction_y, beam.half_cos, beam.half_sin,
                    ),
                )  # fmt: skip
                limit = min(limit, square + SLACK)
            nearest = math.sqrt(square)
            samples[slot + 1] = 0.0
            if nearest > beam.farthest:
                samples[slot] = STATUS_NONE
            elif nearest < beams[sensor, BEAM_NEAREST] or nearest == 0.0:
                samples[slot] = STATUS_NEAR
            else:
                samples[slot] = STATUS_OK
                samples[slot + 1] = nearest


@njit(cache=True, error_model="numpy", nogil=True)
def sense_proximity(
    tick: int,
    pose: Floats,
    parts: Floats,
    part_start: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    mounts: Floats,
    groups: Ints,
    beams: Floats,
    schedule: Ints,
    samples: Floats,
) -> None:
    """Store the samples that all proximity sensors take at a tick.

    Args:
        tick: The tick.
        pose: Pose block of the bodies, float64[>= 3, n]: further rows do not matter.
        parts: Part block of the bodies.
        part_start: int64[n + 1], the first part of each body and the end.
        pieces: Of the walls.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
        mounts: float64[mounts, 4], columns `MOUNT_X` to `MOUNT_REACH`.
        groups: int64[mounts, 4], columns `GROUP_OWNER` to `GROUP_END`.
        beams: float64[sensors, 9], columns `BEAM_X` to `BEAM_FARTHEST`.
        schedule: int64[sensors, 8].
        samples: float64[...], written: status and distance in metres.
    """
    if groups.shape[0] == 0:
        return
    placed, walls = place_bodies(pose, parts, part_start), Walls(pieces, links, edges, cells, frame)
    nearby = room_for(placed, walls)
    squares = np.empty(nearby.around.shape[1])
    _sense_all(tick, 0, pose, placed, walls, nearby, squares, mounts, groups, beams, schedule, samples)


@njit(cache=True, error_model="numpy", nogil=True)
def sense_proximity_many(
    ticks: Ints, numbers: Floats, samples: Floats, first: int, end: int, parts: Floats, part_start: Ints,
    pieces: Floats, links: Ints, edges: Floats, cells: Ints, frame: Floats, mounts: Floats, groups: Ints, beams: Floats,
    schedule: Ints,
) -> None:  # fmt: skip
    """Store the samples of all proximity sensors of the worlds from `first` to before `end`.

    The arguments are those of `sense_proximity`, stacked: the first axis is the world. The worlds share the walls, and
    have as many parts of each body.
    """
    if groups.shape[1] == 0 or first >= end:
        return
    walls = Walls(pieces, links, edges, cells, frame)
    nearby = room_for(place_bodies(numbers[first], parts[first], part_start), walls)
    squares = np.empty(nearby.around.shape[1])
    for world in range(first, end):
        placed = place_bodies(numbers[world], parts[world], part_start)
        _sense_all(
            ticks[world], world * groups.shape[1], numbers[world], placed, walls, nearby, squares, mounts[world],
            groups[world], beams[world], schedule[world], samples[world],
        )  # fmt: skip
