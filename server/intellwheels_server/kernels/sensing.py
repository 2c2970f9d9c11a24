"""What every proximity sensor of every body sees in one tick: the nearest distance in its wedge.

One call does all of them. Sensors that look from the same frame make a station; what lies
within a station's reach is gathered once, by uniform grids over bodies and walls, and each of its sensors then tests
the gathered boxes and wall pieces whose z range holds its height. A sensor never sees its own body.

This file also holds the timetable that every kind of sensor keeps: when it samples and where a
sample is stored, so that rate and latency need no state but the stored samples.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from intellwheels_server.kernels.elementary import sincos
from intellwheels_server.kernels.wedge import box_in_wedge, polygon_in_wedge

if TYPE_CHECKING:
    from intellwheels_server.walls import Walls

# Columns of a timetable, int64[M, TIMETABLE_COLUMNS], one row a sensor.
BODY = 0
"""Index of the body it belongs to."""
EVERY = 1
"""Ticks from one sample to the next, >= 1."""
LATENCY = 2
"""Ticks from a sample to its reading, >= 0."""
JOINED = 3
"""Tick of its first sample."""
OFFSET = 4
"""Where its samples begin."""
DEPTH = 5
"""How many samples are kept: enough for the latency."""
KEY0 = 6
"""First half of its noise key, the bits of an unsigned number."""
KEY1 = 7
"""Second half."""
TIMETABLE_COLUMNS = 8

# Rows of what sensors may know of the bodies, float64[BODY_ROWS, N], one column a body.
X = 0
"""Centre of movement, m."""
Y = 1
"""Centre of movement, m."""
HEADING = 2
"""Heading, rad."""
SPEED = 3
"""Speed along the heading, m/s."""
TURN_RATE = 4
"""Turn rate, anticlockwise, rad/s."""
LEFT_TRAVEL = 5
"""Way the left wheel has rolled since joining, signed, m."""
RIGHT_TRAVEL = 6
"""Way the right wheel has rolled since joining, signed, m."""
TOUCHING = 7
"""1 where the body touches something, else 0."""
BODY_ROWS = 8

# Rows of parts, float64[6, P], in the body's frame.
PART_X, PART_Y, PART_LENGTH, PART_WIDTH, PART_BOTTOM, PART_TOP = range(6)

# Columns of stations, float64[S, 4]: where a station is, when fixed in the world, and how far from it its sensors see.
STATION_X, STATION_Y, STATION_HEADING, STATION_REACH = range(4)
# Columns of station rows, int64[S, 4].
STATION_BODY, STATION_FIXED, STATION_BEGIN, STATION_END = range(4)

# Columns of proximity sensors, float64[M, 9], in the station's frame.
EYE_X, EYE_Y, EYE_Z, EYE_COS, EYE_SIN, EYE_HALF_COS, EYE_HALF_SIN, EYE_MIN, EYE_MAX = range(9)
EYE_COLUMNS = 9

# What a proximity sample says, in the order of the wire's Status.
OK, NONE, NEAR, FAULT = 0.0, 1.0, 2.0, 3.0
PROXIMITY_WIDTH = 2
"""Numbers in a proximity sample: status, distance."""

# Slack of the culling tests, far above rounding and far below anything built, m.
_SLACK = 1e-9


@njit(cache=True, error_model="numpy")
def due_slot(timetable: np.ndarray, sensor: int, tick: int, width: int) -> int:
    """Return where in the samples the sensor's sample of this tick begins, or -1 when none is due.

    Args:
        timetable: int64[M, TIMETABLE_COLUMNS].
        sensor: Row of the timetable.
        tick: This tick.
        width: Numbers in a sample.
    """
    age = tick - timetable[sensor, JOINED]
    if age < 0:
        return -1
    every = timetable[sensor, EVERY]
    if every != 1:
        if age % every != 0:
            return -1
        age //= every
    depth = timetable[sensor, DEPTH]
    if depth == 1:
        return timetable[sensor, OFFSET]
    return timetable[sensor, OFFSET] + age % depth * width


@njit(cache=True, error_model="numpy")
def _place_boxes(bodies: np.ndarray, parts: np.ndarray, part_start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return all parts in the world and the extent of each body.

    Returns:
        float64[P, 10]: centre x, y, cos and sin of the heading, half length, half width, half
        extent in x and y, bottom, top; float64[N, 4]: centre x, y and half extent in x and y.
    """
    count = bodies.shape[1]
    boxes = np.empty((parts.shape[1], 10))
    extents = np.empty((count, 4))
    for body in range(count):
        x = bodies[X, body]
        y = bodies[Y, body]
        s, c = sincos(bodies[HEADING, body])
        low_x = low_y = np.inf
        high_x = high_y = -np.inf
        for part in range(part_start[body], part_start[body + 1]):
            half_length = 0.5 * parts[PART_LENGTH, part]
            half_width = 0.5 * parts[PART_WIDTH, part]
            centre_x = x + (c * parts[PART_X, part] - s * parts[PART_Y, part])
            centre_y = y + (s * parts[PART_X, part] + c * parts[PART_Y, part])
            extent_x = abs(c) * half_length + abs(s) * half_width
            extent_y = abs(s) * half_length + abs(c) * half_width
            boxes[part, 0] = centre_x
            boxes[part, 1] = centre_y
            boxes[part, 2] = c
            boxes[part, 3] = s
            boxes[part, 4] = half_length
            boxes[part, 5] = half_width
            boxes[part, 6] = extent_x
            boxes[part, 7] = extent_y
            boxes[part, 8] = parts[PART_BOTTOM, part]
            boxes[part, 9] = parts[PART_TOP, part]
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
def _cell(offset: float, size: float, count: int) -> int:
    """Return the cell that holds a coordinate, the first or last one for what is outside."""
    return int(min(max(offset / size, 0.0), count - 1.0))


@njit(cache=True, error_model="numpy")
def sense_proximity(
    tick: int,
    bodies: np.ndarray,
    parts: np.ndarray,
    part_start: np.ndarray,
    walls: Walls,
    stations: np.ndarray,
    station_rows: np.ndarray,
    eyes: np.ndarray,
    timetable: np.ndarray,
    samples: np.ndarray,
) -> None:
    """Store the samples of this tick of all proximity sensors.

    Args:
        tick: This tick.
        bodies: float64[BODY_ROWS, N].
        parts: float64[6, P], parts of all bodies in their body's frame.
        part_start: int64[N + 1], where each body's parts begin.
        walls: The floor's wall pieces.
        stations: float64[S, 4].
        station_rows: int64[S, 4]; a station's sensors are rows BEGIN to END of the next two.
        eyes: float64[M, EYE_COLUMNS].
        timetable: int64[M, TIMETABLE_COLUMNS].
        samples: float64[...], written: a sensor's status and distance in metres (0 without OK).
    """
    if station_rows.shape[0] == 0:
        return
    boxes, extents = _place_boxes(bodies, parts, part_start)
    count = bodies.shape[1]

    # A grid over the bodies' centres, about two bodies a cell: cell size c solves (w/c + 1)(h/c + 1) = cells + 1.
    low_x = low_y = np.inf
    high_x = high_y = -np.inf
    widest_x = widest_y = 0.0
    for body in range(count):
        low_x = min(low_x, extents[body, 0])
        high_x = max(high_x, extents[body, 0])
        low_y = min(low_y, extents[body, 1])
        high_y = max(high_y, extents[body, 1])
        widest_x = max(widest_x, extents[body, 2])
        widest_y = max(widest_y, extents[body, 3])
    cells = max(1.0, 0.5 * count)
    span = (high_x - low_x) + (high_y - low_y)
    size = (span + math.sqrt(span * span + 4.0 * cells * (high_x - low_x) * (high_y - low_y))) / (2.0 * cells)
    if not size > 0.0:
        size = 1.0
    columns = int((high_x - low_x) / size) + 1
    rows = int((high_y - low_y) / size) + 1
    cell_start = np.zeros(columns * rows + 1, np.int64)
    cell_of = np.empty(count, np.int64)
    for body in range(count):
        column = _cell(extents[body, 0] - low_x, size, columns)
        cell = _cell(extents[body, 1] - low_y, size, rows) * columns + column
        cell_of[body] = cell
        cell_start[cell] += 1
    total = 0
    for cell in range(columns * rows):
        total += cell_start[cell]
        cell_start[cell] = total
    cell_start[columns * rows] = total
    cell_bodies = np.empty(count, np.int64)
    for body in range(count - 1, -1, -1):
        cell_start[cell_of[body]] -= 1
        cell_bodies[cell_start[cell_of[body]]] = body

    near_parts = np.empty(boxes.shape[0], np.int64)
    piece_count = walls.bounds.shape[0]
    near_pieces = np.empty(piece_count, np.int64)
    gathered_for = np.full(piece_count, -1, np.int64)

    for station in range(station_rows.shape[0]):
        begin = station_rows[station, STATION_BEGIN]
        end = station_rows[station, STATION_END]
        owner = station_rows[station, STATION_BODY]
        any_due = False
        for sensor in range(begin, end):
            if due_slot(timetable, sensor, tick, PROXIMITY_WIDTH) >= 0:
                any_due = True
                break
        if not any_due:
            continue
        if station_rows[station, STATION_FIXED] != 0:
            x = stations[station, STATION_X]
            y = stations[station, STATION_Y]
            s, c = sincos(stations[station, STATION_HEADING])
        else:
            x = bodies[X, owner]
            y = bodies[Y, owner]
            s, c = sincos(bodies[HEADING, owner])
        reach = stations[station, STATION_REACH] + _SLACK
        reach_square = reach * reach

        part_count = 0
        first_column = _cell(x - reach - widest_x - low_x, size, columns)
        last_column = _cell(x + reach + widest_x - low_x, size, columns)
        first_row = _cell(y - reach - widest_y - low_y, size, rows)
        last_row = _cell(y + reach + widest_y - low_y, size, rows)
        for row in range(first_row, last_row + 1):
            # The cells of a row follow one another, and so do their bodies.
            first = cell_start[row * columns + first_column]
            last = cell_start[row * columns + last_column + 1]
            for at in range(first, last):
                body = cell_bodies[at]
                gap_x = max(abs(extents[body, 0] - x) - extents[body, 2], 0.0)
                gap_y = max(abs(extents[body, 1] - y) - extents[body, 3], 0.0)
                if body != owner and gap_x * gap_x + gap_y * gap_y <= reach_square:
                    for part in range(part_start[body], part_start[body + 1]):
                        near_parts[part_count] = part
                        part_count += 1

        near_piece_count = 0
        first_column = _cell(x - reach - walls.origin_x, walls.cell, walls.columns)
        last_column = _cell(x + reach - walls.origin_x, walls.cell, walls.columns)
        first_row = _cell(y - reach - walls.origin_y, walls.cell, walls.rows)
        last_row = _cell(y + reach - walls.origin_y, walls.cell, walls.rows)
        for row in range(first_row, last_row + 1):
            first = walls.cell_start[row * walls.columns + first_column]
            last = walls.cell_start[row * walls.columns + last_column + 1]
            for at in range(first, last):
                piece = walls.cell_items[at]
                if gathered_for[piece] == station:
                    continue
                gathered_for[piece] = station
                gap_x = max(max(walls.bounds[piece, 0] - x, x - walls.bounds[piece, 2]), 0.0)
                gap_y = max(max(walls.bounds[piece, 1] - y, y - walls.bounds[piece, 3]), 0.0)
                if gap_x * gap_x + gap_y * gap_y <= reach_square:
                    near_pieces[near_piece_count] = piece
                    near_piece_count += 1

        for sensor in range(begin, end):
            slot = due_slot(timetable, sensor, tick, PROXIMITY_WIDTH)
            if slot < 0:
                continue
            eye_x = x + (c * eyes[sensor, EYE_X] - s * eyes[sensor, EYE_Y])
            eye_y = y + (s * eyes[sensor, EYE_X] + c * eyes[sensor, EYE_Y])
            eye_z = eyes[sensor, EYE_Z]
            direction_x = c * eyes[sensor, EYE_COS] - s * eyes[sensor, EYE_SIN]
            direction_y = s * eyes[sensor, EYE_COS] + c * eyes[sensor, EYE_SIN]
            half_cos = eyes[sensor, EYE_HALF_COS]
            half_sin = eyes[sensor, EYE_HALF_SIN]
            # Inward normals of the wedge's left and right side. What lies wholly beyond one of them is
            # not seen, if the wedge is convex.
            left_x = half_sin * direction_x + half_cos * direction_y
            left_y = half_sin * direction_y - half_cos * direction_x
            right_x = half_sin * direction_x - half_cos * direction_y
            right_y = half_sin * direction_y + half_cos * direction_x
            convex = half_cos >= 0.0
            longest = eyes[sensor, EYE_MAX]
            nearest = np.inf
            limit = longest
            limit_square = limit * limit

            for at in range(part_count):
                part = near_parts[at]
                dx = boxes[part, 0] - eye_x
                dy = boxes[part, 1] - eye_y
                extent_x = boxes[part, 6]
                extent_y = boxes[part, 7]
                gap_x = max(abs(dx) - extent_x, 0.0)
                gap_y = max(abs(dy) - extent_y, 0.0)
                if gap_x * gap_x + gap_y * gap_y > limit_square + _SLACK:
                    continue
                if convex and (
                    left_x * dx + left_y * dy + (abs(left_x) * extent_x + abs(left_y) * extent_y) < -_SLACK
                    or right_x * dx + right_y * dy + (abs(right_x) * extent_x + abs(right_y) * extent_y) < -_SLACK
                ):
                    continue
                if not boxes[part, 8] <= eye_z < boxes[part, 9]:
                    continue
                box_cos = boxes[part, 2]
                box_sin = boxes[part, 3]
                distance = box_in_wedge(
                    -(box_cos * dx + box_sin * dy),
                    box_sin * dx - box_cos * dy,
                    box_cos * direction_x + box_sin * direction_y,
                    box_cos * direction_y - box_sin * direction_x,
                    half_cos,
                    half_sin,
                    boxes[part, 4],
                    boxes[part, 5],
                    limit,
                )
                if distance < nearest:
                    nearest = distance
                    if distance < limit:
                        limit = distance
                        limit_square = limit * limit

            for at in range(near_piece_count):
                piece = near_pieces[at]
                extent_x = 0.5 * (walls.bounds[piece, 2] - walls.bounds[piece, 0])
                extent_y = 0.5 * (walls.bounds[piece, 3] - walls.bounds[piece, 1])
                dx = 0.5 * (walls.bounds[piece, 2] + walls.bounds[piece, 0]) - eye_x
                dy = 0.5 * (walls.bounds[piece, 3] + walls.bounds[piece, 1]) - eye_y
                gap_x = max(abs(dx) - extent_x, 0.0)
                gap_y = max(abs(dy) - extent_y, 0.0)
                if gap_x * gap_x + gap_y * gap_y > limit_square + _SLACK:
                    continue
                if convex and (
                    left_x * dx + left_y * dy + (abs(left_x) * extent_x + abs(left_y) * extent_y) < -_SLACK
                    or right_x * dx + right_y * dy + (abs(right_x) * extent_x + abs(right_y) * extent_y) < -_SLACK
                ):
                    continue
                if not walls.bottom[piece] <= eye_z < walls.top[piece]:
                    continue
                distance = polygon_in_wedge(
                    walls.corners,
                    walls.start[piece],
                    walls.start[piece + 1],
                    eye_x,
                    eye_y,
                    direction_x,
                    direction_y,
                    half_cos,
                    half_sin,
                    limit,
                )
                if distance < nearest:
                    nearest = distance
                    if distance < limit:
                        limit = distance
                        limit_square = limit * limit

            if nearest > longest:
                samples[slot] = NONE
                samples[slot + 1] = 0.0
            elif nearest < eyes[sensor, EYE_MIN] or nearest == 0.0:
                samples[slot] = NEAR
                samples[slot + 1] = 0.0
            else:
                samples[slot] = OK
                samples[slot + 1] = nearest
