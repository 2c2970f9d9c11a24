"""Echoes that reach a sonar by way of a wall that sends its sound elsewhere: the longer ways of a double bounce.

A wall is a mirror, so what is seen in it is seen from the image of the sonar behind it. There are two kinds of ways.
The sound meets a second face at right angles, or something rough, and comes back as it went: the distance is that from
the image. Or it goes round by two faces, as in a corner of a room: half of the way counts.

The sound must leave and arrive within the beam of the ping, and nothing that can be heard may stand on its way.

Source:
    Wilkes, Dudek, Jenkin and Milios (1990), A ray-following model of sonar range sensing, Proc. SPIE 1388. Their rays
    are sampled; images give the same ways exactly.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import PIECE_BOTTOM, PIECE_TOP, Floats, Ints
from intellwheels_server.world.kernels.proximity_wedges import Beam
from intellwheels_server.world.kernels.sonar_faces import segment_between, sides_of_box, sides_of_piece
from intellwheels_server.world.kernels.sonar_scene import (
    FACE_HIGH,
    FACE_LENGTH,
    FACE_LOW,
    FACE_NX,
    FACE_NY,
    FACE_X,
    FACE_Y,
    SKIN,
    Counts,
    Scene,
    blocked,
)
from intellwheels_server.world.kernels.spatial_query import CENTRE_X, CENTRE_Y, EXTENT_X, EXTENT_Y, HIGH, LOW


@njit(cache=True, error_model="numpy", inline="always")
def _clipped(first: float, last: float, value: float, rate: float) -> tuple[float, float]:
    """Return the part of a range of t in which value + rate t >= 0; an empty one ends before it begins."""
    if rate > 0.0:
        first = max(first, -value / rate)
    elif rate < 0.0:
        last = min(last, -value / rate)
    elif value < 0.0:
        last = first - 1.0
    return first, last


@njit(cache=True, error_model="numpy", inline="always")
def _in_beam(
    px: float, py: float, nx: float, ny: float, length: float, right_x: float, right_y: float, left_x: float,
    left_y: float,
) -> tuple[float, float]:  # fmt: skip
    """Return the part of a face between two rays from the origin, along (-ny, nx) from its corner; it may be empty."""
    first, last = _clipped(0.0, length, right_x * py - right_y * px, right_x * nx + right_y * ny)
    return _clipped(first, last, px * left_y - py * left_x, -(ny * left_y + nx * left_x))


@njit(cache=True, error_model="numpy", inline="always")
def nearest_bounce(
    beam: Beam,
    wall_cos: float,
    wall_sin: float,
    thin: float,
    wave: float,
    best: float,
    scene: Scene,
    counts: Counts,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    sides: Floats,
    close: Ints,
) -> float:
    """Return the shortest distance of a double bounce, m, at most `best`.

    Args:
        beam: The sonar in the world.
        wall_cos: Cosine of the angle up to which the ping hears walls; beyond a right angle it counts as one.
        wall_sin: Sine of it.
        thin: What is narrower than this times the cube of its distance is not heard, 1/m2.
        wave: Wavelength, m; a corner is one of a right angle if that moves its echo by no more.
        best: The distance of the nearest echo so far, m.
        scene: What is around the sonar.
        counts: How much of it there is.
        pieces: Of the walls, as the next two.
        links: Of the walls.
        edges: Of the walls.
        sides: Scratch.
        close: int64[>= 2 faces], scratch.
    """
    x, y, z, direction_x, direction_y, _, _, _ = beam
    boxes, owners, near, posts, faces, _ = scene
    box_count, near_count, post_count, front_count, face_count = counts
    if wall_cos < 0.0:
        wall_cos, wall_sin = 0.0, 1.0
    right_x, right_y = direction_x * wall_cos + direction_y * wall_sin, direction_y * wall_cos - direction_x * wall_sin
    left_x, left_y = direction_x * wall_cos - direction_y * wall_sin, direction_y * wall_cos + direction_x * wall_sin
    # First the mirrors: faces of which a part in the beam is nearer than the echo so far.
    mirrors = others = 0
    for face in range(front_count):
        px, py = faces[face, FACE_X] - x, faces[face, FACE_Y] - y
        nx, ny = faces[face, FACE_NX], faces[face, FACE_NY]
        height = nx * px + ny * py
        if height > -SKIN or -height >= best or not faces[face, FACE_LOW] <= z < faces[face, FACE_HIGH]:
            continue
        first, last = _in_beam(px, py, nx, ny, faces[face, FACE_LENGTH], right_x, right_y, left_x, left_y)
        aside = min(max(ny * px - nx * py, first), last) - (ny * px - nx * py)
        if last - first > SKIN and height * height + aside * aside < best * best:
            close[mirrors] = face
            mirrors += 1
    if mirrors == 0:
        return best
    # Then the faces that a way can reach: no point of a way is farther than the way is long.
    for face in range(face_count):
        px, py = faces[face, FACE_X] - x, faces[face, FACE_Y] - y
        nx, ny = faces[face, FACE_NX], faces[face, FACE_NY]
        height, along = nx * px + ny * py, ny * px - nx * py
        aside = max(-along, along - faces[face, FACE_LENGTH], 0.0)
        if height * height + aside * aside < best * best and faces[face, FACE_LOW] <= z < faces[face, FACE_HIGH]:
            close[mirrors + others] = face
            others += 1
    for at_mirror in range(mirrors):
        mirror = close[at_mirror]
        px, py = faces[mirror, FACE_X] - x, faces[mirror, FACE_Y] - y
        nx, ny = faces[mirror, FACE_NX], faces[mirror, FACE_NY]
        height = nx * px + ny * py
        first, last = _in_beam(px, py, nx, ny, faces[mirror, FACE_LENGTH], right_x, right_y, left_x, left_y)
        image_x, image_y = 2.0 * height * nx, 2.0 * height * ny
        for at_other in range(mirrors, mirrors + others):
            other = close[at_other]
            if other == mirror:
                continue
            qx, qy = faces[other, FACE_X] - x, faces[other, FACE_Y] - y
            mx, my = faces[other, FACE_NX], faces[other, FACE_NY]
            depth = mx * (qx - image_x) + my * (qy - image_y)  # below 0 in front of the other face
            if depth > -SKIN:
                continue
            if -depth < best:  # there and back, at right angles to the other face
                along = mx * (image_y - qy) - my * (image_x - qx)
                rise = depth * (nx * mx + ny * my)
                if 0.0 <= along <= faces[other, FACE_LENGTH] and rise > 0.0:
                    share = -height / rise
                    ax, ay = image_x + share * depth * mx, image_y + share * depth * my
                    at = nx * (ay - py) - ny * (ax - px)
                    wide = thin * depth * depth * -depth
                    if (
                        share < 1.0
                        and first <= at <= last
                        and min(faces[other, FACE_LENGTH], faces[mirror, FACE_LENGTH]) >= wide
                    ):
                        gone = math.sqrt(ax * ax + ay * ay)
                        if not blocked(
                            x, y, z, ax, ay, 0.0, thin, -1, boxes, owners, box_count, near, near_count, pieces, links,
                            edges,
                        ) and not blocked(
                            x + ax, y + ay, z, image_x + depth * mx - ax, image_y + depth * my - ay, gone, thin, -1,
                            boxes, owners, box_count, near, near_count, pieces, links, edges,
                        ):  # fmt: skip
                            best = -depth
            if other < mirror:
                continue  # the same round the other way
            # Round by both faces, from the image of the image. Each must have an end in front of the other: from the
            # outer side of a corner there is no such way.
            lean = nx * my - ny * mx  # of either face along the other's normal, for each metre
            ahead = mx * (px - qx) + my * (py - qy)
            behind = nx * (qx - px) + ny * (qy - py)
            if (
                max(ahead, ahead + faces[mirror, FACE_LENGTH] * lean) < SKIN
                or max(behind, behind - faces[other, FACE_LENGTH] * lean) < SKIN
            ):
                continue
            level = mx * qx + my * qy
            if level > -SKIN:
                continue
            # A corner of nearly a right angle sends all sound back from its vertex, where the faces meet.
            if abs(lean) > 0.5:
                vertex_x, vertex_y = (height * my - level * ny) / lean, (level * nx - height * mx) / lean
                square = vertex_x * vertex_x + vertex_y * vertex_y
                if abs(nx * mx + ny * my) * math.sqrt(square) <= wave:
                    at, along = nx * (vertex_y - py) - ny * (vertex_x - px), mx * (vertex_y - qy) - my * (vertex_x - qx)
                    if (
                        square < best * best
                        and -wave <= at <= faces[mirror, FACE_LENGTH] + wave
                        and -wave <= along <= faces[other, FACE_LENGTH] + wave
                        and right_x * vertex_y - right_y * vertex_x >= 0.0
                        and vertex_x * left_y - vertex_y * left_x >= 0.0
                        and min(faces[other, FACE_LENGTH], faces[mirror, FACE_LENGTH])
                        >= thin * square * math.sqrt(square)
                        and not blocked(
                            x, y, z, vertex_x, vertex_y, 0.0, thin, -1, boxes, owners, box_count, near, near_count,
                            pieces, links, edges,
                        )
                    ):  # fmt: skip
                        best = math.sqrt(square)
                    continue
            twice_x, twice_y = image_x + 2.0 * depth * mx, image_y + 2.0 * depth * my
            square = twice_x * twice_x + twice_y * twice_y
            rise = mx * twice_x + my * twice_y
            if not 0.25 * square < best * best or rise >= level:
                continue
            share = level / rise
            bx, by = share * twice_x, share * twice_y
            along = mx * (by - qy) - my * (bx - qx)
            if not 0.0 <= along <= faces[other, FACE_LENGTH]:
                continue
            if right_x * by - right_y * bx < 0.0 or bx * left_y - by * left_x < 0.0:
                continue
            rise = nx * (bx - image_x) + ny * (by - image_y)
            if rise <= -height - SKIN:
                continue
            share = min(-height / rise, 1.0)
            ax, ay = image_x + share * (bx - image_x), image_y + share * (by - image_y)
            at = nx * (ay - py) - ny * (ax - px)
            half = 0.5 * math.sqrt(square)
            wide = thin * half * half * half
            if not first <= at <= last or min(faces[other, FACE_LENGTH], faces[mirror, FACE_LENGTH]) < wide:
                continue
            gone = math.sqrt(ax * ax + ay * ay)
            if (
                blocked(
                    x, y, z, ax, ay, 0.0, thin, -1, boxes, owners, box_count, near, near_count, pieces, links, edges
                )
                or blocked(
                    x + ax, y + ay, z, bx - ax, by - ay, gone, thin, -1, boxes, owners, box_count, near, near_count,
                    pieces, links, edges,
                )
                or blocked(
                    x, y, z, bx, by, 0.0, thin, -1, boxes, owners, box_count, near, near_count, pieces, links, edges
                )
            ):  # fmt: skip
                continue
            best = half
        # Rough things in the mirror, between the rays through the ends of its part in the beam.
        right_end_x, right_end_y = px - first * ny - image_x, py + first * nx - image_y
        left_end_x, left_end_y = px - last * ny - image_x, py + last * nx - image_y
        for thing in range(box_count + post_count):
            if thing < box_count:
                if not boxes[thing, LOW] <= z < boxes[thing, HIGH]:
                    continue
                gap_x = max(abs(boxes[thing, CENTRE_X] - x - image_x) - boxes[thing, EXTENT_X], 0.0)
                gap_y = max(abs(boxes[thing, CENTRE_Y] - y - image_y) - boxes[thing, EXTENT_Y], 0.0)
                if gap_x * gap_x + gap_y * gap_y >= best * best:
                    continue
                count = sides_of_box(boxes, thing, x + image_x, y + image_y, sides)
            else:
                piece = posts[thing - box_count]
                if not pieces[piece, PIECE_BOTTOM] <= z < pieces[piece, PIECE_TOP]:
                    continue
                count = sides_of_piece(piece, links, edges, x + image_x, y + image_y, sides)
            closest, to_x, to_y = np.inf, 0.0, 0.0
            low, high = np.inf, -np.inf
            for side in range(count):
                if not sides[side, 4] * sides[side, 0] + sides[side, 5] * sides[side, 1] < 0.0:
                    continue
                found, found_x, found_y = segment_between(
                    sides[side, 0], sides[side, 1], sides[side, 2], sides[side, 3],
                    right_end_x, right_end_y, left_end_x, left_end_y,
                )  # fmt: skip
                if found < closest:
                    closest, to_x, to_y = found, found_x, found_y
            rise = nx * to_x + ny * to_y
            if not closest < best * best or rise <= -height:
                continue
            distance = math.sqrt(closest)
            for side in range(count):
                aside = (to_x * sides[side, 1] - to_y * sides[side, 0]) / distance
                low, high = min(low, aside), max(high, aside)
            if high - low < thin * distance * closest:
                continue
            share = -height / rise
            ax, ay = image_x + share * to_x, image_y + share * to_y
            gone = math.sqrt(ax * ax + ay * ay)
            if blocked(
                x, y, z, ax, ay, 0.0, thin, -1, boxes, owners, box_count, near, near_count, pieces, links, edges
            ) or blocked(
                x + ax, y + ay, z, image_x + to_x - ax, image_y + to_y - ay, gone, thin, -1, boxes, owners, box_count,
                near, near_count, pieces, links, edges,
            ):  # fmt: skip
                continue
            best = distance
    return best
