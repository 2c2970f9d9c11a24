"""What every sonar of every body hears in one tick: the nearest echo that comes back, not the nearest thing.

A smooth wall throws sound away like a mirror: a face of it is heard only while its normal lies within 25 degrees of the
sensor's axis. Thin posts and bodies are rough and answer from wherever they are seen, but no echo returns from
what is thinner than a 25 mm post is at 2.4 m, by the angle it fills. What stands behind something is not heard, lost or
not. Distances come in steps of 8.65 mm, the way of sound there and back in 50 us.

A sonar that fires in the same tick as another it looks at, and that looks back, may take the other's chirp for an
echo: sound that came one way counts as half the way. So this sensor's answers, and no other's, depend on who else is
there.

Source:
    The figures are SIMULATION.md's; that walls are mirrors and edges weak is Kuc and Siegel (1987), Physically based
    simulation model for acoustic sensor robot navigation, IEEE Transactions on Pattern Analysis 9(6).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    HEADING,
    NORMAL_X,
    NORMAL_Y,
    Floats,
    Ints,
    X,
    Y,
)
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.noise import uniform
from intellwheels_server.world.kernels.sensing import (
    BEGIN,
    END,
    EYE_COS,
    EYE_SIN,
    EYE_X,
    EYE_Y,
    EYE_Z,
    FARTHEST,
    FAULT,
    FIXED,
    HALF_COS,
    HALF_SIN,
    NEAR,
    NEAREST,
    NONE,
    OK,
    OWNER,
    REACH,
    SAMPLE_WIDTH,
    STATION_HEADING,
    STATION_X,
    STATION_Y,
)  # fmt: skip
from intellwheels_server.world.kernels.sight import in_sight, ray_to_polygon
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
from intellwheels_server.world.kernels.timetable import KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.wedge import ray_to_box

# Cosine of 25 degrees.
MIRROR_COS = 0.9063077870366499
# Width over distance of a 25 mm post at 2.4 m.
LEAST_WIDTH = 0.025 / 2.4
# A wall piece no wider than this either way is a post, m.
POST = 0.1
# Distance of one step, m.
COMB = 0.00865

# Columns of an ear block, float64[sensors, 2]: share of samples that fail, share of chirps that are taken for an echo.
DROPOUT, CROSSTALK = 0, 1

# Draws of a sensor and tick.
_DROPOUT_DRAW, _CROSSTALK_DRAW = 0, 1
# What begins within this of a point of an echo does not hide it, m.
_SKIN = 1e-6


@njit(cache=True, error_model="numpy")
def segment_in_wedge(
    px: float,
    py: float,
    qx: float,
    qy: float,
    direction_x: float,
    direction_y: float,
    half_cos: float,
    half_sin: float,
) -> tuple[float, float, float]:
    """Return the nearest point of a segment inside a wedge at the origin: square of its distance, x, y; inf for none.

    Args:
        px: One end, from the apex, m.
        py: The same.
        qx: The other end.
        qy: The same.
        direction_x: Direction of the wedge, a unit vector.
        direction_y: The same.
        half_cos: Cosine of half the cone.
        half_sin: Sine of half the cone, >= 0; 0 sees all around.
    """
    ex, ey = qx - px, qy - py
    along = min(max(-(px * ex + py * ey) / (ex * ex + ey * ey), 0.0), 1.0)
    x, y = px + along * ex, py + along * ey
    if half_sin * (direction_x * x + direction_y * y) >= half_cos * abs(direction_x * y - direction_y * x):
        return x * x + y * y, x, y
    best, best_x, best_y = np.inf, 0.0, 0.0
    for side in (-half_sin, half_sin):
        ux, uy = direction_x * half_cos - direction_y * side, direction_y * half_cos + direction_x * side
        across = ux * ey - uy * ex
        if across == 0.0:
            continue
        way = (px * ey - py * ex) / across
        share = (px * uy - py * ux) / across
        if way >= 0.0 and 0.0 <= share <= 1.0 and way * way < best:
            best, best_x, best_y = way * way, way * ux, way * uy
    return best, best_x, best_y


@njit(cache=True, error_model="numpy")
def _hidden(
    around: Floats,
    near: int,
    polygons: Ints,
    polygon_count: int,
    solids: Floats,
    links: Ints,
    edges: Floats,
    x: float,
    y: float,
    z: float,
    to_x: float,
    to_y: float,
) -> bool:
    """Return whether something gathered begins before a point, (to_x, to_y) from the ear."""
    length = math.sqrt(to_x * to_x + to_y * to_y)
    if length <= _SKIN:
        return False
    dx, dy = to_x / length, to_y / length
    far = length - _SKIN
    for at in range(near):
        if not around[LOW, at] <= z < around[HIGH, at]:
            continue
        c, s = around[COS, at], around[SIN, at]
        from_x, from_y = x - around[CENTRE_X, at], y - around[CENTRE_Y, at]
        way = ray_to_box(
            c * from_x + s * from_y,
            c * from_y - s * from_x,
            c * dx + s * dy,
            c * dy - s * dx,
            around[LONG, at],
            around[WIDE, at],
        )
        if way < far:
            return True
    for at in range(polygon_count):
        piece = polygons[at]
        if solids[piece, LOW] <= z < solids[piece, HIGH]:
            way, _ = ray_to_polygon(edges, links[piece, FIRST_EDGE], links[piece, END_EDGE], x, y, dx, dy)
            if way < far:
                return True
    return False


@njit(cache=True, error_model="numpy")
def _faces_of_box(around: Floats, at: int, x: float, y: float, faces: Floats) -> int:
    """Store a box's four faces, from the ear, as rows: corner, next corner (anticlockwise), unit normal outwards."""
    c, s = around[COS, at], around[SIN, at]
    centre_x, centre_y = around[CENTRE_X, at] - x, around[CENTRE_Y, at] - y
    lx, ly = c * around[LONG, at], s * around[LONG, at]
    wx, wy = -s * around[WIDE, at], c * around[WIDE, at]
    for face in range(4):  # front right, front left, rear left, rear right
        along = 1.0 if face < 2 else -1.0
        across = 1.0 if face in (1, 2) else -1.0
        faces[face, 0] = centre_x + along * lx + across * wx
        faces[face, 1] = centre_y + along * ly + across * wy
    for face in range(4):
        faces[face, 2] = faces[(face + 1) % 4, 0]
        faces[face, 3] = faces[(face + 1) % 4, 1]
    faces[0, 4], faces[0, 5] = c, s
    faces[1, 4], faces[1, 5] = -s, c
    faces[2, 4], faces[2, 5] = -c, -s
    faces[3, 4], faces[3, 5] = s, -c
    return 4


@njit(cache=True, error_model="numpy")
def _faces_of_piece(edges: Floats, first: int, end: int, x: float, y: float, faces: Floats) -> int:
    """Store a wall piece's faces likewise, at most as many as there is room for."""
    count = min(end - first, faces.shape[0])
    for face in range(count):
        after = first + (face + 1) % (end - first)
        faces[face, 0] = edges[first + face, EDGE_X] - x
        faces[face, 1] = edges[first + face, EDGE_Y] - y
        faces[face, 2] = edges[after, EDGE_X] - x
        faces[face, 3] = edges[after, EDGE_Y] - y
        faces[face, 4] = edges[first + face, NORMAL_X]
        faces[face, 5] = edges[first + face, NORMAL_Y]
    return int(count)


@njit(cache=True, error_model="numpy")
def _seen_width(faces: Floats, count: int, to_x: float, to_y: float) -> float:
    """Return how wide a thing is across the way to a point of it, times the distance of that point."""
    least, most = np.inf, -np.inf
    for face in range(count):
        aside = to_x * faces[face, 1] - to_y * faces[face, 0]
        least, most = min(least, aside), max(most, aside)
    return most - least


@njit(cache=True, error_model="numpy")
def _nearest_echo(
    around: Floats,
    people: int,
    near: int,
    polygons: Ints,
    polygon_count: int,
    solids: Floats,
    links: Ints,
    edges: Floats,
    x: float,
    y: float,
    z: float,
    direction_x: float,
    direction_y: float,
    half_cos: float,
    half_sin: float,
    farthest: float,
    faces: Floats,
) -> float:
    """Return the distance of the nearest echo, m, 0 from inside a thing, inf where none comes back."""
    best = farthest * farthest * (1.0 + SLACK)
    found = False
    for thing in range(near + polygon_count):
        if thing < near:
            extent_x, extent_y = around[EXTENT_X, thing], around[EXTENT_Y, thing]
            centre_x, centre_y = around[CENTRE_X, thing], around[CENTRE_Y, thing]
            low, high = around[LOW, thing], around[HIGH, thing]
        else:
            piece = polygons[thing - near]
            extent_x, extent_y = solids[piece, EXTENT_X], solids[piece, EXTENT_Y]
            centre_x, centre_y = solids[piece, CENTRE_X], solids[piece, CENTRE_Y]
            low, high = solids[piece, LOW], solids[piece, HIGH]
        if not low <= z < high:
            continue
        gap_x = max(abs(centre_x - x) - extent_x, 0.0)
        gap_y = max(abs(centre_y - y) - extent_y, 0.0)
        if gap_x * gap_x + gap_y * gap_y > best:
            continue
        if thing < near:
            count = _faces_of_box(around, thing, x, y, faces)
            post = max(around[LONG, thing], around[WIDE, thing]) <= 0.5 * POST
        else:
            count = _faces_of_piece(edges, links[piece, FIRST_EDGE], links[piece, END_EDGE], x, y, faces)
            post = max(extent_x, extent_y) <= 0.5 * POST
        rough = post or thing < people
        inside = True
        for face in range(count):
            px, py, qx, qy = faces[face, 0], faces[face, 1], faces[face, 2], faces[face, 3]
            nx, ny = faces[face, 4], faces[face, 5]
            if not nx * px + ny * py < 0.0:  # seen from behind
                continue
            inside = False
            if not rough and -(nx * direction_x + ny * direction_y) < MIRROR_COS:
                continue
            square, to_x, to_y = segment_in_wedge(px, py, qx, qy, direction_x, direction_y, half_cos, half_sin)
            if not square < best:
                continue
            if rough:
                wide = _seen_width(faces, count, to_x, to_y)
            else:
                wide = math.sqrt(square * ((qx - px) * (qx - px) + (qy - py) * (qy - py)))
            if wide * (1.0 + SLACK) < LEAST_WIDTH * square:
                continue
            if not _hidden(around, near, polygons, polygon_count, solids, links, edges, x, y, z, to_x, to_y):
                best = square
                found = True
        if inside:
            return 0.0
    return math.sqrt(best) if found else np.inf


@njit(cache=True, error_model="numpy")
def _hear_others(
    tick: int,
    ears: Floats,
    eyes: Floats,
    owners: Ints,
    poses: Floats,
    due: Ints,
    boxes: Floats,
    part_start: Ints,
    opaque: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    timetable: Ints,
    heard: Floats,
) -> None:
    """Shorten what sonars that are prone to it heard to half the way to the nearest that chirps at them."""
    order = due[np.argsort(poses[due, 0])]
    ordered_x = poses[order, 0]
    for sensor in due:
        share = ears[sensor, CROSSTALK]
        if share <= 0.0:
            continue
        key0, key1 = np.uint64(timetable[sensor, KEY0]), np.uint64(timetable[sensor, KEY1])
        if uniform(key0, key1, tick, _CROSSTALK_DRAW) >= share:
            continue
        x, y, z = poses[sensor, 0], poses[sensor, 1], eyes[sensor, EYE_Z]
        farthest = eyes[sensor, FARTHEST]
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
            if not eyes[sensor, HALF_SIN] * ahead >= eyes[sensor, HALF_COS] * abs(aside):
                continue
            ahead = -(poses[other, 2] * dx + poses[other, 3] * dy)
            aside = poses[other, 2] * dy - poses[other, 3] * dx
            if not eyes[other, HALF_SIN] * ahead >= eyes[other, HALF_COS] * abs(aside):
                continue
            opaque[owners[sensor]] = opaque[owners[other]] = 0
            seen = in_sight(
                x, y, z, poses[other, 0], poses[other, 1], boxes, part_start, opaque, pieces, links, edges, cells,
                frame,
            )  # fmt: skip
            opaque[owners[sensor]] = opaque[owners[other]] = 1
            if seen:
                heard[sensor] = 0.5 * math.sqrt(square)


@njit(cache=True, error_model="numpy")
def sense_sonars(
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
    ears: Floats,
    timetable: Ints,
    samples: Floats,
) -> None:
    """Store the samples that all sonars take at a tick.

    Args:
        tick: The tick.
        pose: Pose block of the bodies, float64[>= 3, n].
        parts: Part block of the bodies.
        part_start: int64[n + 1], the first part of each body and the end.
        pieces: Of the walls.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
        stations: float64[stations, 4], as `sense_proximity` takes them.
        crews: int64[stations, 4], likewise.
        eyes: float64[sensors, 9], likewise.
        ears: float64[sensors, 2].
        timetable: int64[sensors, 8].
        samples: float64[...], written: status and distance in metres.
    """
    count = eyes.shape[0]
    slots = np.empty(count, np.int64)
    for sensor in range(count):
        slots[sensor] = due_slot(timetable, sensor, tick, SAMPLE_WIDTH)
    due = np.nonzero(slots >= 0)[0]
    if due.shape[0] == 0:
        return
    boxes, extents = place_boxes(pose, parts, part_start)
    low_x, low_y, size, columns, rows, cell_start, cell_bodies = grid_of(extents)
    widest_x = extents[:, 2].max()
    widest_y = extents[:, 3].max()
    solids = np.empty((pieces.shape[0], 10))
    around = np.empty((10, boxes.shape[0] + pieces.shape[0] + LANES))
    polygons = np.empty(pieces.shape[0], np.int64)
    gathered_for = np.full(pieces.shape[0], -1, np.int64)
    most_edges = 4
    for piece in range(pieces.shape[0]):
        most_edges = max(most_edges, links[piece, END_EDGE] - links[piece, FIRST_EDGE])
    faces = np.empty((most_edges, 6))
    heard = np.full(count, np.inf)
    owners = np.empty(count, np.int64)
    poses = np.empty((count, 4))
    prone = False

    for station in range(crews.shape[0]):
        owner = crews[station, OWNER]
        x, y, heading = pose[X, owner], pose[Y, owner], pose[HEADING, owner]
        if crews[station, FIXED] != 0:
            x, y, heading = (
                stations[station, STATION_X],
                stations[station, STATION_Y],
                stations[station, STATION_HEADING],
            )
        s, c = sincos(heading)
        reach = stations[station, REACH] + SLACK
        people, near, polygon_count = gather(
            x, y, reach, owner, station, part_start, boxes, extents, low_x, low_y, size, columns, rows, cell_start,
            cell_bodies, widest_x, widest_y, pieces, links, edges, cells, frame, solids, gathered_for, around, polygons,
        )  # fmt: skip
        for sensor in range(crews[station, BEGIN], crews[station, END]):
            owners[sensor] = owner
            if slots[sensor] < 0:
                continue
            prone |= ears[sensor, CROSSTALK] > 0.0
            poses[sensor, 0] = x + (c * eyes[sensor, EYE_X] - s * eyes[sensor, EYE_Y])
            poses[sensor, 1] = y + (s * eyes[sensor, EYE_X] + c * eyes[sensor, EYE_Y])
            poses[sensor, 2] = c * eyes[sensor, EYE_COS] - s * eyes[sensor, EYE_SIN]
            poses[sensor, 3] = s * eyes[sensor, EYE_COS] + c * eyes[sensor, EYE_SIN]
            heard[sensor] = _nearest_echo(
                around, people, near, polygons, polygon_count, solids, links, edges, poses[sensor, 0],
                poses[sensor, 1], eyes[sensor, EYE_Z], poses[sensor, 2], poses[sensor, 3], eyes[sensor, HALF_COS],
                eyes[sensor, HALF_SIN], eyes[sensor, FARTHEST], faces,
            )  # fmt: skip
    if prone:
        opaque = np.ones(pose.shape[1], np.int64)
        _hear_others(
            tick, ears, eyes, owners, poses, due, boxes, part_start, opaque, pieces, links, edges, cells, frame,
            timetable, heard,
        )  # fmt: skip

    for ear in due:
        slot = slots[ear]
        way = heard[ear]
        samples[slot + 1] = 0.0
        if ears[ear, DROPOUT] > 0.0 and ears[ear, DROPOUT] > uniform(
            np.uint64(timetable[ear, KEY0]), np.uint64(timetable[ear, KEY1]), tick, _DROPOUT_DRAW
        ):
            samples[slot] = FAULT
        elif way > eyes[ear, FARTHEST]:
            samples[slot] = NONE
        elif way < eyes[ear, NEAREST] or way == 0.0:
            samples[slot] = NEAR
        else:
            samples[slot] = OK
            samples[slot + 1] = COMB * np.floor(way / COMB + 0.5)
