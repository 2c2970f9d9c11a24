"""What every proximity sensor of every body sees in one tick: the nearest distance in its wedge.

One call does all of them. Sensors that look from the same frame make a station; what lies within a station's
reach is gathered once, by uniform grids over bodies and walls, and each of its sensors then tests the
gathered boxes and wall pieces whose z range holds its height. A sensor never sees its own body.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.kernels.arrays import (
    BOTTOM,
    CELL,
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    HALF_LENGTH,
    HALF_WIDTH,
    HEADING,
    NORMAL_X,
    NORMAL_Y,
    ORIGIN_X,
    ORIGIN_Y,
    PART_X,
    PART_Y,
    PIECE_BOTTOM,
    PIECE_TOP,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    TOP,
    Floats,
    Ints,
    X,
    Y,
)
from intellwheels_server.kernels.elementary import sincos
from intellwheels_server.kernels.grid import cell_of
from intellwheels_server.kernels.timetable import due_slot
from intellwheels_server.kernels.wedge import box_in_wedge, polygon_in_wedge

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

# Columns of a block of boxes in the world, float64[boxes, 10]: centre, half extents along the axes, z range, unit
# vector of its length, half length and width. A wall piece that is no box has NaN for its half length.
CENTRE_X, CENTRE_Y, EXTENT_X, EXTENT_Y, LOW, HIGH, COS, SIN, LONG, WIDE = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9

# Slack of the culling tests, far above rounding and far below anything built, m.
_SLACK = 1e-9

# The gathered boxes are filled up to a multiple of this: the widest vectors there are.
_LANES = 8

# Corners of a rectangle are rounded; an angle this far from right moves no wall by 1e-10 m.
_SQUARE = 1e-14


@njit(cache=True, error_model="numpy")
def _place_boxes(pose: Floats, parts: Floats, part_start: Ints) -> tuple[Floats, Floats]:
    """Return all parts as boxes in the world and the extent of each body.

    Returns:
        float64[parts, 10], columns `CENTRE_X` to `WIDE`; float64[n, 4]: centre and half extents in x and y.
    """
    count = pose.shape[1]
    boxes = np.empty((parts.shape[0], 10))
    extents = np.empty((count, 4))
    for body in range(count):
        x = pose[X, body]
        y = pose[Y, body]
        s, c = sincos(pose[HEADING, body])
        low_x = low_y = np.inf
        high_x = high_y = -np.inf
        for part in range(part_start[body], part_start[body + 1]):
            half_length = parts[part, HALF_LENGTH]
            half_width = parts[part, HALF_WIDTH]
            centre_x = x + (c * parts[part, PART_X] - s * parts[part, PART_Y])
            centre_y = y + (s * parts[part, PART_X] + c * parts[part, PART_Y])
            extent_x = abs(c) * half_length + abs(s) * half_width
            extent_y = abs(s) * half_length + abs(c) * half_width
            boxes[part, CENTRE_X] = centre_x
            boxes[part, CENTRE_Y] = centre_y
            boxes[part, EXTENT_X] = extent_x
            boxes[part, EXTENT_Y] = extent_y
            boxes[part, LOW] = parts[part, BOTTOM]
            boxes[part, HIGH] = parts[part, TOP]
            boxes[part, COS] = c
            boxes[part, SIN] = s
            boxes[part, LONG] = half_length
            boxes[part, WIDE] = half_width
            low_x = min(low_x, centre_x - extent_x)
            high_x = max(high_x, centre_x + extent_x)
            low_y = min(low_y, centre_y - extent_y)
            high_y = max(high_y, centre_y + extent_y)
        if low_x > high_x:  # a body without parts is nowhere to be seen
            low_x = high_x = x
            low_y = high_y = y
        extents[body, 0] = 0.5 * (low_x + high_x)
        extents[body, 1] = 0.5 * (low_y + high_y)
        extents[body, 2] = 0.5 * (high_x - low_x)
        extents[body, 3] = 0.5 * (high_y - low_y)
    return boxes, extents


@njit(cache=True, error_model="numpy")
def _fill_solid(piece: int, pieces: Floats, links: Ints, edges: Floats, solids: Floats) -> None:
    """Store a wall piece as a box; one that is no rectangle gets its bounding box and NaN for its half length."""
    centre_x = 0.5 * (pieces[piece, PIECE_X0] + pieces[piece, PIECE_X1])
    centre_y = 0.5 * (pieces[piece, PIECE_Y0] + pieces[piece, PIECE_Y1])
    first = links[piece, FIRST_EDGE]
    end = links[piece, END_EDGE]
    c = edges[first, NORMAL_X]
    s = edges[first, NORMAL_Y]
    rectangle = end - first == 4
    for edge in range(first + 1, end):
        c, s = -s, c
        rectangle &= (abs(edges[edge, NORMAL_X] - c) < _SQUARE) & (abs(edges[edge, NORMAL_Y] - s) < _SQUARE)
    length = width = 0.0
    for edge in range(first, end):
        dx = edges[edge, EDGE_X] - centre_x
        dy = edges[edge, EDGE_Y] - centre_y
        length = max(length, abs(c * dx + s * dy))
        width = max(width, abs(c * dy - s * dx))
    solids[piece, CENTRE_X] = centre_x
    solids[piece, CENTRE_Y] = centre_y
    solids[piece, EXTENT_X] = 0.5 * (pieces[piece, PIECE_X1] - pieces[piece, PIECE_X0])
    solids[piece, EXTENT_Y] = 0.5 * (pieces[piece, PIECE_Y1] - pieces[piece, PIECE_Y0])
    solids[piece, LOW] = pieces[piece, PIECE_BOTTOM]
    solids[piece, HIGH] = pieces[piece, PIECE_TOP]
    solids[piece, COS] = c
    solids[piece, SIN] = s
    solids[piece, LONG] = length if rectangle else np.nan
    solids[piece, WIDE] = width


@njit(cache=True, error_model="numpy")
def _grid_of(extents: Floats) -> tuple[float, float, float, int, int, Ints, Ints]:
    """Return a grid over the centres of at least one body: origin, cell size, columns, rows, starts and bodies.

    The cells of a row follow one another, and so do their bodies.
    """
    count = extents.shape[0]
    low_x = extents[:, 0].min()
    low_y = extents[:, 1].min()
    width = extents[:, 0].max() - low_x
    height = extents[:, 1].max() - low_y
    # About two bodies a cell: (width / size + 1)(height / size + 1) = wanted + 1.
    wanted = max(1.0, 0.5 * count)
    span = width + height
    size = (span + math.sqrt(span * span + 4.0 * wanted * width * height)) / (2.0 * wanted)
    if not size > 0.0:
        size = 1.0
    columns = int(width / size) + 1
    rows = int(height / size) + 1
    cell_start = np.zeros(columns * rows + 1, np.int64)
    home = np.empty(count, np.int64)
    for body in range(count):
        column = cell_of(extents[body, 0], low_x, size, columns)
        cell = cell_of(extents[body, 1], low_y, size, rows) * columns + column
        home[body] = cell
        cell_start[cell] += 1
    total = 0
    for cell in range(columns * rows):
        total += cell_start[cell]
        cell_start[cell] = total
    cell_start[columns * rows] = total
    cell_bodies = np.empty(count, np.int64)
    for body in range(count - 1, -1, -1):
        cell_start[home[body]] -= 1
        cell_bodies[cell_start[home[body]]] = body
    return low_x, low_y, size, columns, rows, cell_start, cell_bodies


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
        count: How many boxes, a multiple of `_LANES`.
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
    boxes, extents = _place_boxes(pose, parts, part_start)
    low_x, low_y, size, columns, rows, cell_start, cell_bodies = _grid_of(extents)
    widest_x = extents[:, 2].max()
    widest_y = extents[:, 3].max()

    # What is near a station: boxes, and wall pieces that are none.
    most = boxes.shape[0] + pieces.shape[0] + _LANES
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
        reach = stations[station, REACH] + _SLACK
        reach_square = reach * reach

        near = 0
        polygon_count = 0
        first_column = cell_of(x - reach - widest_x, low_x, size, columns)
        last_column = cell_of(x + reach + widest_x, low_x, size, columns)
        first_row = cell_of(y - reach - widest_y, low_y, size, rows)
        last_row = cell_of(y + reach + widest_y, low_y, size, rows)
        for row in range(first_row, last_row + 1):
            first = cell_start[row * columns + first_column]
            last = cell_start[row * columns + last_column + 1]
            for at in range(first, last):
                body = cell_bodies[at]
                gap_x = max(abs(extents[body, 0] - x) - extents[body, 2], 0.0)
                gap_y = max(abs(extents[body, 1] - y) - extents[body, 3], 0.0)
                if body != owner and gap_x * gap_x + gap_y * gap_y <= reach_square:
                    for part in range(part_start[body], part_start[body + 1]):
                        for column in range(10):
                            around[column, near] = boxes[part, column]
                        near += 1

        first_column = cell_of(x - reach, frame[ORIGIN_X], frame[CELL], cells[0])
        last_column = cell_of(x + reach, frame[ORIGIN_X], frame[CELL], cells[0])
        first_row = cell_of(y - reach, frame[ORIGIN_Y], frame[CELL], cells[1])
        last_row = cell_of(y + reach, frame[ORIGIN_Y], frame[CELL], cells[1])
        for row in range(first_row, last_row + 1):
            first = cells[2 + row * cells[0] + first_column]
            last = cells[2 + row * cells[0] + last_column + 1]
            for at in range(first, last):
                piece = cells[at]
                if gathered_for[piece] == station:
                    continue
                if gathered_for[piece] < 0:
                    _fill_solid(piece, pieces, links, edges, solids)
                gathered_for[piece] = station
                gap_x = max(abs(solids[piece, CENTRE_X] - x) - solids[piece, EXTENT_X], 0.0)
                gap_y = max(abs(solids[piece, CENTRE_Y] - y) - solids[piece, EXTENT_Y], 0.0)
                if gap_x * gap_x + gap_y * gap_y > reach_square:
                    continue
                if solids[piece, LONG] > 0.0:
                    for column in range(10):
                        around[column, near] = solids[piece, column]
                    near += 1
                else:
                    polygons[polygon_count] = piece
                    polygon_count += 1
        # Fill the last vector with boxes of no height, which nothing sees.
        while near % _LANES != 0:
            for column in range(10):
                around[column, near] = 0.0
            near += 1

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
            limit = min(square, longest * longest) + _SLACK
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
                limit = min(limit, square + _SLACK)

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
