"""What every proximity sensor of every body sees in one tick: the nearest distance in its wedge.

One call does all of them. Sensors that look from the same frame make a station; what lies within a station's
reach is gathered once, by uniform grids over bodies and walls, and each of its sensors then tests the
gathered boxes and wall pieces whose z range holds its height. A sensor never sees its own body.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import END_EDGE, FIRST_EDGE, HEADING, Floats, Ints, X, Y
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.surroundings import (
    CENTRE_X,
    CENTRE_Y,
    COS,
    EXTENT_X,
    EXTENT_Y,
    HIGH,
    LANES,
    LONG,
    LOW,
    SIN,
    SLACK,
    WIDE,
    gather,
    grid_of,
    place_boxes,
)  # fmt: skip
from intellwheels_server.world.kernels.timetable import due_slot
from intellwheels_server.world.kernels.wedge import box_in_wedge, polygon_in_wedge

# Columns of a station block, float64[stations, 4]: pose in the world of one that is fixed there, and how far
# from it its sensors see.
STATION_X, STATION_Y, STATION_HEADING, REACH = 0, 1, 2, 3
STATION_COLUMNS = 4

# Columns of a crew block, int64[stations, 4]: body that owns the station, 1 for one fixed in the world, its
# first sensor and one past its last.
OWNER, FIXED, BEGIN, END = 0, 1, 2, 3
CREW_COLUMNS = 4

# Columns of an eye block, float64[sensors, 9], in the station's frame: place, unit vector of the direction,
# cosine and sine of half the cone, range.
EYE_X, EYE_Y, EYE_Z, EYE_COS, EYE_SIN, HALF_COS, HALF_SIN, NEAREST, FARTHEST = 0, 1, 2, 3, 4, 5, 6, 7, 8
EYE_COLUMNS = 9

# A proximity sample: status and distance in metres, 0 without OK. Statuses in the order of the wire's.
OK, NONE, NEAR, FAULT = 0.0, 1.0, 2.0, 3.0
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
    # Every box is measured, since that takes less time on vectors than choosing does when the choice
    # cannot be predicted.
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


@njit(cache=True, error_model="numpy")
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
    stations: Floats,
    crews: Ints,
    eyes: Floats,
    timetable: Ints,
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
        stations: float64[stations, 4].
        crews: int64[stations, 4].
        eyes: float64[sensors, 9].
        timetable: int64[sensors, 8].
        samples: float64[...], written: status and distance in metres.
    """
    if crews.shape[0] == 0:
        return
    boxes, extents = place_boxes(pose, parts, part_start)
    low_x, low_y, size, columns, rows, cell_start, cell_bodies = grid_of(extents)
    widest_x = extents[:, 2].max()
    widest_y = extents[:, 3].max()

    # What is near a station: boxes, and wall pieces that are none.
    most = boxes.shape[0] + pieces.shape[0] + LANES
    solids = np.empty((pieces.shape[0], 10))
    around = np.empty((10, most))
    squares = np.empty(most)
    polygons = np.empty(pieces.shape[0], np.int64)
    gathered_for = np.full(pieces.shape[0], -1, np.int64)

    for station in range(crews.shape[0]):
        begin = crews[station, BEGIN]
        end = crews[station, END]
        owner = crews[station, OWNER]
        any_due = False
        for sensor in range(begin, end):
            if due_slot(timetable, sensor, tick, SAMPLE_WIDTH) >= 0:
                any_due = True
                break
        if not any_due:
            continue
        if crews[station, FIXED] != 0:
            x = stations[station, STATION_X]
            y = stations[station, STATION_Y]
            s, c = sincos(stations[station, STATION_HEADING])
        else:
            x = pose[X, owner]
            y = pose[Y, owner]
            s, c = sincos(pose[HEADING, owner])
        reach = stations[station, REACH] + SLACK
        _, near, polygon_count = gather(
            x, y, reach, owner, station, part_start, boxes, extents, low_x, low_y, size, columns, rows, cell_start,
            cell_bodies, widest_x, widest_y, pieces, links, edges, cells, frame, solids, gathered_for, around, polygons,
        )  # fmt: skip

        for sensor in range(begin, end):
            slot = due_slot(timetable, sensor, tick, SAMPLE_WIDTH)
            if slot < 0:
                continue
            eye_x = x + (c * eyes[sensor, EYE_X] - s * eyes[sensor, EYE_Y])
            eye_y = y + (s * eyes[sensor, EYE_X] + c * eyes[sensor, EYE_Y])
            eye_z = eyes[sensor, EYE_Z]
            direction_x = c * eyes[sensor, EYE_COS] - s * eyes[sensor, EYE_SIN]
            direction_y = s * eyes[sensor, EYE_COS] + c * eyes[sensor, EYE_SIN]
            half_cos = eyes[sensor, HALF_COS]
            half_sin = eyes[sensor, HALF_SIN]
            square = _nearest_box(
                around, near, eye_x, eye_y, eye_z, direction_x, direction_y, half_cos, half_sin, squares
            )
            longest = eyes[sensor, FARTHEST]
            limit = min(square, longest * longest) + SLACK
            for at in range(polygon_count):
                piece = polygons[at]
                gap_x = max(abs(solids[piece, CENTRE_X] - eye_x) - solids[piece, EXTENT_X], 0.0)
                gap_y = max(abs(solids[piece, CENTRE_Y] - eye_y) - solids[piece, EXTENT_Y], 0.0)
                if gap_x * gap_x + gap_y * gap_y > limit:
                    continue
                if not solids[piece, LOW] <= eye_z < solids[piece, HIGH]:
                    continue
                square = min(
                    square,
                    polygon_in_wedge(
                        edges,
                        links[piece, FIRST_EDGE],
                        links[piece, END_EDGE],
                        eye_x,
                        eye_y,
                        direction_x,
                        direction_y,
                        half_cos,
                        half_sin,
                    ),
                )
                limit = min(limit, square + SLACK)

            nearest = math.sqrt(square)
            if nearest > longest:
                samples[slot] = NONE
                samples[slot + 1] = 0.0
            elif nearest < eyes[sensor, NEAREST] or nearest == 0.0:
                samples[slot] = NEAR
                samples[slot + 1] = 0.0
            else:
                samples[slot] = OK
                samples[slot + 1] = nearest
