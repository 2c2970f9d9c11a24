"""Measurements of all sonars of all bodies in one tick: the nearest echo that returns, not the nearest thing.

A smooth wall reflects sound like a mirror: it is heard where the beam meets it at right angles. A wall that is not
heard there can still send the sound on, to something from which it returns by a longer way: see `sonar_bounces`. Posts
and bodies are rough, so they are heard from every side. A thing that is too thin to be heard at its distance hides
nothing. Other things hide what is behind them, even if their own echo is lost.

Sonars may take the pings of others for their own echoes: see `sonar_crosstalk`. So only sonars have readings that
depend on the sensors of other bodies.

Source:
    Walls as mirrors: Kuc and Siegel (1987), Physically based simulation model for acoustic sensor robot navigation,
    IEEE Transactions on Pattern Analysis 9(6). The figures of a ping: `sonar_beam`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    END_EDGE,
    FIRST_EDGE,
    PIECE_BOTTOM,
    PIECE_TOP,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    Floats,
    Ints,
    Walls,
)
from intellwheels_server.world.kernels.noise import uniform
from intellwheels_server.world.kernels.proximity_wedges import (
    BEAM_FARTHEST,
    BEAM_NEAREST,
    BEAM_X,
    BEAM_Y,
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
from intellwheels_server.world.kernels.sonar_beam import CROSSTALK, DROPOUT, DROPOUT_DRAW, STEP, THIN, jitter, wall_beam
from intellwheels_server.world.kernels.sonar_bounces import nearest_bounce
from intellwheels_server.world.kernels.sonar_crosstalk import Sonars, hear_others
from intellwheels_server.world.kernels.sonar_faces import (
    SIDE_COLUMNS,
    is_inside,
    segment_in_wedge,
    sides_of_box,
    sides_of_piece,
)
from intellwheels_server.world.kernels.sonar_scene import (
    FACE_HIGH,
    FACE_LENGTH,
    FACE_LOW,
    FACE_NX,
    FACE_NY,
    FACE_X,
    FACE_Y,
    Counts,
    Scene,
    blocked,
    gather_scene,
    scene_room,
)
from intellwheels_server.world.kernels.spatial_query import (
    CENTRE_X,
    CENTRE_Y,
    EXTENT_X,
    EXTENT_Y,
    HIGH,
    LOW,
    SLACK,
    Place,
    place_bodies,
)


@njit(cache=True, error_model="numpy", inline="always")
def _is_in_wall(
    beam: Beam, scene: Scene, counts: Counts, pieces: Floats, links: Ints, edges: Floats, sides: Floats
) -> bool:
    """Return whether a sonar is inside a wall."""
    x, y, z = beam.x, beam.y, beam.z
    for at in range(counts.near):
        piece = scene.near[at]
        if (
            pieces[piece, PIECE_BOTTOM] <= z < pieces[piece, PIECE_TOP]
            and pieces[piece, PIECE_X0] <= x <= pieces[piece, PIECE_X1]
            and pieces[piece, PIECE_Y0] <= y <= pieces[piece, PIECE_Y1]
            and is_inside(sides, sides_of_piece(piece, links, edges, x, y, sides))
        ):
            return True
    return False


@njit(cache=True, error_model="numpy", inline="always")
def _nearest_wall(
    beam: Beam, wall_cos: float, thin: float, best: float, scene: Scene, counts: Counts, pieces: Floats, links: Ints,
    edges: Floats,
) -> float:  # fmt: skip
    """Return the distance of the nearest face that the ping meets at right angles, m, at most `best`."""
    x, y, z, direction_x, direction_y, _, _, _ = beam
    boxes, owners, near, _, faces, _ = scene
    for face in range(counts.front):
        nx, ny = faces[face, FACE_NX], faces[face, FACE_NY]
        if -(nx * direction_x + ny * direction_y) < wall_cos:
            continue
        px, py = faces[face, FACE_X] - x, faces[face, FACE_Y] - y
        height = nx * px + ny * py
        if not 0.0 < -height < best or not faces[face, FACE_LOW] <= z < faces[face, FACE_HIGH]:
            continue
        along = ny * px - nx * py
        if not -SLACK <= along <= faces[face, FACE_LENGTH] + SLACK:
            continue
        if faces[face, FACE_LENGTH] < thin * height * height * -height:
            continue
        if not blocked(
            x, y, z, height * nx, height * ny, 0.0, thin, -1, boxes, owners, counts.boxes, near, counts.near, pieces,
            links, edges,
        ):  # fmt: skip
            best = -height
    return best


@njit(cache=True, error_model="numpy", inline="always")
def _nearest_rough(
    beam: Beam, thin: float, best: float, scene: Scene, counts: Counts, pieces: Floats, links: Ints, edges: Floats,
    sides: Floats,
) -> float:  # fmt: skip
    """Return the distance of the nearest body or post in the cone, m, at most `best`; 0 inside one."""
    x, y, z, direction_x, direction_y, half_cos, half_sin, _ = beam
    boxes, owners, near, posts, _, _ = scene
    for thing in range(counts.boxes + counts.posts):
        if thing < counts.boxes:
            if not boxes[thing, LOW] <= z < boxes[thing, HIGH]:
                continue
            gap_x = max(abs(boxes[thing, CENTRE_X] - x) - boxes[thing, EXTENT_X], 0.0)
            gap_y = max(abs(boxes[thing, CENTRE_Y] - y) - boxes[thing, EXTENT_Y], 0.0)
            if gap_x * gap_x + gap_y * gap_y > best * best:
                continue
            count = sides_of_box(boxes, thing, x, y, sides)
        else:
            piece = posts[thing - counts.boxes]
            if not pieces[piece, PIECE_BOTTOM] <= z < pieces[piece, PIECE_TOP]:
                continue
            count = sides_of_piece(piece, links, edges, x, y, sides)
        if is_inside(sides, count):
            return 0.0
        closest, to_x, to_y = np.inf, 0.0, 0.0
        for side in range(count):
            if not sides[side, 4] * sides[side, 0] + sides[side, 5] * sides[side, 1] < 0.0:
                continue  # seen from behind
            found, found_x, found_y = segment_in_wedge(
                sides[side, 0], sides[side, 1], sides[side, 2], sides[side, 3], direction_x, direction_y, half_cos,
                half_sin,
            )  # fmt: skip
            if found < closest:
                closest, to_x, to_y = found, found_x, found_y
        if not closest < best * best:
            continue
        distance = math.sqrt(closest)
        low, high = np.inf, -np.inf
        for side in range(count):
            aside = (to_x * sides[side, 1] - to_y * sides[side, 0]) / distance
            low, high = min(low, aside), max(high, aside)
        if (high - low) < thin * distance * closest:
            continue
        if not blocked(
            x, y, z, to_x, to_y, 0.0, thin, -1, boxes, owners, counts.boxes, near, counts.near, pieces, links, edges
        ):
            best = distance
    return best


@njit(cache=True, error_model="numpy")
def _most_edges(links: Ints) -> int:
    """Return the largest number of edges of a wall piece, at least 4."""
    most = 4
    for piece in range(links.shape[0]):
        most = max(most, links[piece, END_EDGE] - links[piece, FIRST_EDGE])
    return int(most)


@njit(cache=True, error_model="numpy")
def _store(
    tick: int, beams: Floats, figures: Floats, schedule: Ints, slots: Ints, heard: Floats, samples: Floats
) -> None:
    """Store the distances of the sonars that pinged, with their jitter, or the status if there is none."""
    for sonar in range(slots.shape[0]):
        slot, way = slots[sonar], heard[sonar]
        if slot < 0:
            continue
        nearest, farthest = beams[sonar, BEAM_NEAREST], beams[sonar, BEAM_FARTHEST]
        samples[slot + 1] = 0.0
        if figures[sonar, DROPOUT] > 0.0 and figures[sonar, DROPOUT] > uniform(
            np.uint64(schedule[sonar, KEY0]), np.uint64(schedule[sonar, KEY1]), tick, DROPOUT_DRAW
        ):
            samples[slot] = STATUS_FAULT
        elif way > farthest:
            samples[slot] = STATUS_NONE
        elif way < nearest or way == 0.0:
            samples[slot] = STATUS_NEAR
        else:
            samples[slot] = STATUS_OK
            samples[slot + 1] = min(max(way + jitter(figures, schedule, sonar, tick), nearest), farthest)


@njit(cache=True, error_model="numpy")
def sense_sonars(
    tick: int,
    period: float,
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
    figures: Floats,
    schedule: Ints,
    samples: Floats,
) -> None:
    """Store the samples that all sonars take at a tick.

    Args:
        tick: The tick.
        period: Simulated time of a tick, s.
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
        beams: float64[sonars, 9].
        figures: float64[sonars, 8], columns of `sonar_beam`.
        schedule: int64[sonars, 8].
        samples: float64[...], written: status and distance in metres.
    """
    count = beams.shape[0]
    slots = np.empty(count, np.int64)
    any_due = prone = False
    for sonar in range(count):
        slots[sonar] = due_slot(schedule, sonar, tick, SAMPLE_WIDTH)
        if slots[sonar] >= 0:
            any_due = True
            prone |= figures[sonar, CROSSTALK] > 0.0
    if not any_due:
        return
    placed, walls = place_bodies(pose, parts, part_start), Walls(pieces, links, edges, cells, frame)
    scene = scene_room(placed, walls)
    sides = np.empty((_most_edges(links), SIDE_COLUMNS))
    close = np.empty(2 * edges.shape[0], np.int64)
    heard = np.full(count, np.inf)
    owners = np.empty(count, np.int64)
    poses = np.empty((count, 4))
    for mount in range(groups.shape[0]):
        x, y, c, s = mount_pose(mounts, groups, pose, mount)
        for sonar in range(groups[mount, GROUP_BEGIN], groups[mount, GROUP_END]):
            beam = beam_at(beams, sonar, x, y, c, s)
            owners[sonar] = groups[mount, GROUP_OWNER]
            poses[sonar, 0], poses[sonar, 1] = beam.x, beam.y
            poses[sonar, 2], poses[sonar, 3] = beam.direction_x, beam.direction_y
    # For finding the sonars near one of them.
    order = np.argsort(poses[:, 0], kind="mergesort") if prone else np.empty(0, np.int64)
    sonars = Sonars(beams, figures, schedule, owners, poses, order, poses[order, 0])
    for mount in range(groups.shape[0]):
        begin, end = groups[mount, GROUP_BEGIN], groups[mount, GROUP_END]
        any_due, spread = False, 0.0
        for sonar in range(begin, end):
            any_due |= slots[sonar] >= 0
            spread = max(spread, abs(beams[sonar, BEAM_X]) + abs(beams[sonar, BEAM_Y]))
        if not any_due:
            continue
        x, y, c, s = mount_pose(mounts, groups, pose, mount)
        place = Place(x, y, mounts[mount, MOUNT_REACH] + SLACK, groups[mount, GROUP_OWNER], mount)
        counts = gather_scene(place, spread, placed, walls, scene)
        for sonar in range(begin, end):
            if slots[sonar] < 0:
                continue
            beam = beam_at(beams, sonar, x, y, c, s)
            thin = figures[sonar, THIN]
            if _is_in_wall(beam, scene, counts, pieces, links, edges, sides):
                heard[sonar] = 0.0
                continue
            wall_cos, wall_sin = wall_beam(figures, schedule, sonar, tick)
            # Slightly more than the range, so that a thing at the range itself is heard.
            best = beam.farthest * (1.0 + SLACK)
            limit = best
            best = _nearest_wall(beam, wall_cos, thin, best, scene, counts, pieces, links, edges)
            best = _nearest_rough(beam, thin, best, scene, counts, pieces, links, edges, sides)
            if best > 0.0:
                best = nearest_bounce(
                    beam, wall_cos, wall_sin, thin, figures[sonar, STEP], best, scene, counts, pieces, links, edges,
                    sides, close,
                )  # fmt: skip
            if best < limit:
                heard[sonar] = best
            if best > 0.0 and figures[sonar, CROSSTALK] > 0.0:
                heard[sonar] = hear_others(
                    tick, period, sonar, heard[sonar], sonars, scene, counts, pieces, links, edges
                )
    _store(tick, beams, figures, schedule, slots, heard, samples)
