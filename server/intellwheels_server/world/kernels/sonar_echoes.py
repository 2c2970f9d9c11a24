"""Measurements of all sonars of all bodies in one tick: the nearest echo that returns, not the nearest thing.

A smooth wall reflects sound like a mirror: a face is heard only while its normal lies within 25 degrees of the axis of
the sensor. Thin posts and bodies are rough, so they are heard from every side. A thing returns no echo if it fills a
smaller angle than a 25 mm post at 2.4 m. A thing behind another one is not heard, even if the echo of the nearer one is
lost. Distances come in steps of 8.65 mm, which sound travels there and back in 50 us.

Two sonars that fire in the same tick and face each other may take the chirp of the other for an echo. The sound travels
one way only, so half the way counts. So only sonars have readings that depend on the sensors of other bodies.

Source:
    The numbers are from MODEL.md. Walls as mirrors, and weak edges: Kuc and Siegel (1987), Physically based
    simulation model for acoustic sensor robot navigation, IEEE Transactions on Pattern Analysis 9(6).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import END_EDGE, FIRST_EDGE, Floats, Ints, Walls
from intellwheels_server.world.kernels.noise import uniform
from intellwheels_server.world.kernels.proximity_wedges import (
    BEAM_FARTHEST,
    BEAM_NEAREST,
    GROUP_BEGIN,
    GROUP_END,
    GROUP_OWNER,
    MOUNT_REACH,
    SAMPLE_WIDTH,
    STATUS_FAULT,
    STATUS_NEAR,
    STATUS_NONE,
    STATUS_OK,
    Beam,
    beam_at,
    mount_pose,
)
from intellwheels_server.world.kernels.sample_schedule import KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.sonar_crosstalk import SONAR_CROSSTALK, SONAR_DROPOUT, Sonars, hear_others
from intellwheels_server.world.kernels.sonar_faces import (
    FACE_COLUMNS,
    faces_of_box,
    faces_of_piece,
    hidden,
    seen_width,
    segment_in_wedge,
)
from intellwheels_server.world.kernels.spatial_query import (
    CENTRE_X,
    CENTRE_Y,
    EXTENT_X,
    EXTENT_Y,
    HIGH,
    LONG,
    LOW,
    SLACK,
    WIDE,
    Found,
    Place,
    gather_bodies,
    gather_walls,
    place_bodies,
    room_for,
)

# Cosine of 25 degrees.
MIRROR_COS = 0.9063077870366499
# Width over distance of a 25 mm post at 2.4 m.
LEAST_WIDTH = 0.025 / 2.4
# A wall piece no wider than this either way is a post, m.
POST = 0.1
# Distance of one step, m.
COMB = 0.00865

# Draw of a sensor and tick.
_DROPOUT_DRAW = 0


@njit(cache=True, error_model="numpy")
def _nearest_echo(
    around: Floats, polygons: Ints, solids: Floats, links: Ints, edges: Floats, found: Found, beam: Beam, faces: Floats
) -> float:
    """Return the distance of the nearest echo, m; 0 inside a thing, inf if no echo returns."""
    x, y, z, direction_x, direction_y, half_cos, half_sin, farthest = beam
    best = farthest * farthest * (1.0 + SLACK)
    answered = False
    for thing in range(found.boxes + found.polygons):
        if thing < found.boxes:
            extent_x, extent_y = around[EXTENT_X, thing], around[EXTENT_Y, thing]
            centre_x, centre_y = around[CENTRE_X, thing], around[CENTRE_Y, thing]
            low, high = around[LOW, thing], around[HIGH, thing]
        else:
            piece = polygons[thing - found.boxes]
            extent_x, extent_y = solids[piece, EXTENT_X], solids[piece, EXTENT_Y]
            centre_x, centre_y = solids[piece, CENTRE_X], solids[piece, CENTRE_Y]
            low, high = solids[piece, LOW], solids[piece, HIGH]
        if not low <= z < high:
            continue
        gap_x = max(abs(centre_x - x) - extent_x, 0.0)
        gap_y = max(abs(centre_y - y) - extent_y, 0.0)
        if gap_x * gap_x + gap_y * gap_y > best:
            continue
        if thing < found.boxes:
            count = faces_of_box(around, thing, x, y, faces)
            post = max(around[LONG, thing], around[WIDE, thing]) <= 0.5 * POST
        else:
            count = faces_of_piece(edges, links[piece, FIRST_EDGE], links[piece, END_EDGE], x, y, faces)
            post = max(extent_x, extent_y) <= 0.5 * POST
        rough = post or thing < found.of_bodies
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
                wide = seen_width(faces, count, to_x, to_y)
            else:
                wide = math.sqrt(square * ((qx - px) * (qx - px) + (qy - py) * (qy - py)))
            if wide * (1.0 + SLACK) < LEAST_WIDTH * square:
                continue
            if not hidden(around, found.boxes, polygons, found.polygons, solids, links, edges, x, y, z, to_x, to_y):
                best = square
                answered = True
        if inside:
            return 0.0
    return math.sqrt(best) if answered else np.inf


@njit(cache=True, error_model="numpy")
def _most_edges(links: Ints) -> int:
    """Return the largest number of edges of a wall piece, at least 4."""
    most = 4
    for piece in range(links.shape[0]):
        most = max(most, links[piece, END_EDGE] - links[piece, FIRST_EDGE])
    return int(most)


@njit(cache=True, error_model="numpy")
def _store(
    tick: int, beams: Floats, errors: Floats, schedule: Ints, due: Ints, slots: Ints, heard: Floats, samples: Floats
) -> None:
    """Store the distances of the sonars that fired, in steps, or the status if there is none."""
    for sensor in due:
        slot, way = slots[sensor], heard[sensor]
        samples[slot + 1] = 0.0
        if errors[sensor, SONAR_DROPOUT] > 0.0 and errors[sensor, SONAR_DROPOUT] > uniform(
            np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1]), tick, _DROPOUT_DRAW
        ):
            samples[slot] = STATUS_FAULT
        elif way > beams[sensor, BEAM_FARTHEST]:
            samples[slot] = STATUS_NONE
        elif way < beams[sensor, BEAM_NEAREST] or way == 0.0:
            samples[slot] = STATUS_NEAR
        else:
            samples[slot] = STATUS_OK
            samples[slot + 1] = COMB * np.floor(way / COMB + 0.5)


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
    mounts: Floats,
    groups: Ints,
    beams: Floats,
    errors: Floats,
    schedule: Ints,
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
        mounts: float64[mounts, 4], as `proximity_wedges.sense_proximity` takes them, as the next two.
        groups: int64[mounts, 4].
        beams: float64[sensors, 9].
        errors: float64[sensors, 2], columns `SONAR_DROPOUT`, `SONAR_CROSSTALK`.
        schedule: int64[sensors, 8].
        samples: float64[...], written: status and distance in metres.
    """
    count = beams.shape[0]
    slots = np.empty(count, np.int64)
    for sensor in range(count):
        slots[sensor] = due_slot(schedule, sensor, tick, SAMPLE_WIDTH)
    due = np.nonzero(slots >= 0)[0]
    if due.shape[0] == 0:
        return
    placed, walls = place_bodies(pose, parts, part_start), Walls(pieces, links, edges, cells, frame)
    nearby = room_for(placed, walls)
    _, boxes, extents, cell_start, cell_bodies, grid = placed
    around, polygons, solids, gathered_for = nearby
    faces = np.empty((_most_edges(links), FACE_COLUMNS))
    heard = np.full(count, np.inf)
    owners = np.empty(count, np.int64)
    poses = np.empty((count, 4))
    prone = False
    for mount in range(groups.shape[0]):
        owner = groups[mount, GROUP_OWNER]
        x, y, c, s = mount_pose(mounts, groups, pose, mount)
        place = Place(x, y, mounts[mount, MOUNT_REACH] + SLACK, owner, mount)
        of_bodies = gather_bodies(place, part_start, boxes, extents, cell_start, cell_bodies, grid, around)
        near, polygon_count = gather_walls(
            place, pieces, links, edges, cells, frame, of_bodies, around, polygons, solids, gathered_for
        )
        found = Found(of_bodies, near, polygon_count)
        for sensor in range(groups[mount, GROUP_BEGIN], groups[mount, GROUP_END]):
            owners[sensor] = owner
            if slots[sensor] < 0:
                continue
            prone |= errors[sensor, SONAR_CROSSTALK] > 0.0
            beam = beam_at(beams, sensor, x, y, c, s)
            poses[sensor, 0], poses[sensor, 1] = beam.x, beam.y
            poses[sensor, 2], poses[sensor, 3] = beam.direction_x, beam.direction_y
            heard[sensor] = _nearest_echo(around, polygons, solids, links, edges, found, beam, faces)
    if prone:
        hear_others(tick, Sonars(beams, errors, schedule, owners, poses, due), placed, walls, heard)
    _store(tick, beams, errors, schedule, due, slots, heard, samples)
