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

from numba import njit

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.proximity_wedges import Beam
from intellwheels_server.world.kernels.sonar_corners import corner_width
from intellwheels_server.world.kernels.sonar_face_grid import MANY_PAIRS, face_grid, faces_by_mirror
from intellwheels_server.world.kernels.sonar_rough import add_view, nearest_in_sight
from intellwheels_server.world.kernels.sonar_scene import SKIN, Counts, Scene
from intellwheels_server.world.kernels.sonar_sight import blocked
from intellwheels_server.world.kernels.sonar_surfaces import is_long_in_scene, length_in_scene


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


@njit(cache=True, error_model="numpy")
def _corner_in_wall(
    face: int, x: float, y: float, z: float, nx: float, ny: float, height: float, right_x: float, right_y: float,
    left_x: float, left_y: float, size: float, thin: float, wave: float, best: float, scene: Scene, counts: Counts,
) -> float:  # fmt: skip
    """Return the distance of the convex corner at which a face begins, as it is seen in a wall, m, at most `best`.

    Args:
        face: The face.
        x: The sonar, m.
        y: The same.
        z: Height, m.
        nx: Normal of the wall.
        ny: The same.
        height: The wall along this normal, from the sonar, m, below 0.
        right_x: Direction of the right end of the part of the wall in the beam, from the image.
        right_y: The same.
        left_x: Direction of the left end.
        left_y: The same.
        size: The length of the wall, m.
        thin: What is narrower than this times the cube of its distance is not heard, 1/m2.
        wave: Wavelength, m.
        best: The distance of the nearest echo so far, m.
        scene: What is around the sonar.
        counts: How much of it there is.
    """
    image_x, image_y = 2.0 * height * nx, 2.0 * height * ny
    to_x = scene.faces[face, face_columns.X] - x - image_x
    to_y = scene.faces[face, face_columns.Y] - y - image_y
    square = to_x * to_x + to_y * to_y
    rise = nx * to_x + ny * to_y
    if square >= best * best or rise <= -height + SKIN:
        return best
    if right_x * to_y - right_y * to_x < 0.0 or to_x * left_y - to_y * left_x < 0.0:
        return best
    distance = math.sqrt(square)
    # The corner is heard from behind the beginning of its face only.
    behind = scene.faces[face, face_columns.NX] * to_y - scene.faces[face, face_columns.NY] * to_x
    if size < thin * distance * square or behind < -SKIN:
        return best
    width = corner_width(
        scene.faces[face, face_columns.X], scene.faces[face, face_columns.Y], z, -to_x, -to_y, wave, scene.near,
        scene.ranks, counts.near, scene.pieces, scene.links, scene.edges, scene.cells, scene.frame,
    )  # fmt: skip
    if width <= 0.0 or width < thin * distance * square:
        return best
    share = -height / rise
    ax, ay = image_x + share * to_x, image_y + share * to_y
    if blocked(x, y, z, ax, ay, 0.0, thin, -1, scene, counts) or blocked(
        x + ax, y + ay, z, image_x + to_x - ax, image_y + to_y - ay, math.sqrt(ax * ax + ay * ay), thin, -1, scene,
        counts,
    ):  # fmt: skip
        return best
    return distance


@njit(cache=True, error_model="numpy")
def nearest_bounce(
    beam: Beam,
    wall_cos: float,
    wall_sin: float,
    thin: float,
    wave: float,
    best: float,
    scene: Scene,
    counts: Counts,
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
    """
    x, y, z, direction_x, direction_y, _, _, _ = beam
    faces, close = scene.faces, scene.close
    if wall_cos < 0.0:
        wall_cos, wall_sin = 0.0, 1.0
    right_x, right_y = direction_x * wall_cos + direction_y * wall_sin, direction_y * wall_cos - direction_x * wall_sin
    left_x, left_y = direction_x * wall_cos - direction_y * wall_sin, direction_y * wall_cos + direction_x * wall_sin
    # First the mirrors: faces of which a part in the beam is nearer than the echo so far.
    mirrors = others = 0
    for face in range(counts.front):
        px, py = faces[face, face_columns.X] - x, faces[face, face_columns.Y] - y
        nx, ny = faces[face, face_columns.NX], faces[face, face_columns.NY]
        height = nx * px + ny * py
        if height > -SKIN or -height >= best or not faces[face, face_columns.LOW] <= z < faces[face, face_columns.HIGH]:
            continue
        first, last = _in_beam(px, py, nx, ny, faces[face, face_columns.LENGTH], right_x, right_y, left_x, left_y)
        aside = min(max(ny * px - nx * py, first), last) - (ny * px - nx * py)
        if last - first > SKIN and height * height + aside * aside < best * best:
            close[mirrors] = face
            mirrors += 1
    if mirrors == 0:
        return best
    # Then the faces that a way can reach: no point of a way is farther than the way is long.
    for face in range(counts.faces):
        px, py = faces[face, face_columns.X] - x, faces[face, face_columns.Y] - y
        nx, ny = faces[face, face_columns.NX], faces[face, face_columns.NY]
        height, along = nx * px + ny * py, ny * px - nx * py
        aside = max(-along, along - faces[face, face_columns.LENGTH], 0.0)
        if (
            height * height + aside * aside < best * best
            and faces[face, face_columns.LOW] <= z < faces[face, face_columns.HIGH]
        ):
            close[mirrors + others] = face
            others += 1
    reached = close[mirrors : mirrors + others]
    is_many = mirrors * others >= MANY_PAIRS
    grid = face_grid(x, y, best, wave, faces, reached, scene.face_marks, scene.corners, scene.met, is_many)
    for at_mirror in range(mirrors):
        mirror = close[at_mirror]
        px, py = faces[mirror, face_columns.X] - x, faces[mirror, face_columns.Y] - y
        nx, ny = faces[mirror, face_columns.NX], faces[mirror, face_columns.NY]
        height = nx * px + ny * py
        first, last = _in_beam(px, py, nx, ny, faces[mirror, face_columns.LENGTH], right_x, right_y, left_x, left_y)
        image_x, image_y = 2.0 * height * nx, 2.0 * height * ny
        # A way is longer than that to the mirror: most small faces of a round wall are too thin for any.
        size = length_in_scene(mirror, thin * best * best * best, z, scene, counts)
        if size < thin * height * height * -height:
            continue
        met = -1
        if is_many:
            met = faces_by_mirror(
                px, py, nx, ny, faces[mirror, face_columns.LENGTH], height, first, last, 2.0 * best, at_mirror + 1, grid
            )
        for at_other in range(met if met >= 0 else others):
            other = reached[grid.found[at_other]] if met >= 0 else reached[at_other]
            if other == mirror:
                continue
            qx, qy = faces[other, face_columns.X] - x, faces[other, face_columns.Y] - y
            mx, my = faces[other, face_columns.NX], faces[other, face_columns.NY]
            depth = mx * (qx - image_x) + my * (qy - image_y)  # below 0 in front of the other face
            if depth > -SKIN:
                continue
            if -depth < best:  # there and back, at right angles to the other face
                along = mx * (image_y - qy) - my * (image_x - qx)
                rise = depth * (nx * mx + ny * my)
                if 0.0 <= along <= faces[other, face_columns.LENGTH] and rise > 0.0:
                    share = -height / rise
                    ax, ay = image_x + share * depth * mx, image_y + share * depth * my
                    at = nx * (ay - py) - ny * (ax - px)
                    wide = thin * depth * depth * -depth
                    if (
                        share < 1.0
                        and first <= at <= last
                        and size >= wide
                        and is_long_in_scene(other, wide, z, scene, counts)
                    ):
                        gone = math.sqrt(ax * ax + ay * ay)
                        if not blocked(x, y, z, ax, ay, 0.0, thin, -1, scene, counts) and not blocked(
                            x + ax, y + ay, z, image_x + depth * mx - ax, image_y + depth * my - ay, gone, thin, -1,
                            scene, counts,
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
                max(ahead, ahead + faces[mirror, face_columns.LENGTH] * lean) < SKIN
                or max(behind, behind - faces[other, face_columns.LENGTH] * lean) < SKIN
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
                        and -wave <= at <= faces[mirror, face_columns.LENGTH] + wave
                        and -wave <= along <= faces[other, face_columns.LENGTH] + wave
                        and right_x * vertex_y - right_y * vertex_x >= 0.0
                        and vertex_x * left_y - vertex_y * left_x >= 0.0
                        and size >= thin * square * math.sqrt(square)
                        and is_long_in_scene(other, thin * square * math.sqrt(square), z, scene, counts)
                        and not blocked(x, y, z, vertex_x, vertex_y, 0.0, thin, -1, scene, counts)
                    ):
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
            if not 0.0 <= along <= faces[other, face_columns.LENGTH]:
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
            if not first <= at <= last:
                continue
            if size < wide or not is_long_in_scene(other, wide, z, scene, counts):
                continue
            gone = math.sqrt(ax * ax + ay * ay)
            if (
                blocked(x, y, z, ax, ay, 0.0, thin, -1, scene, counts)
                or blocked(x + ax, y + ay, z, bx - ax, by - ay, gone, thin, -1, scene, counts)
                or blocked(x, y, z, bx, by, 0.0, thin, -1, scene, counts)
            ):
                continue
            best = half
        # Rough things in the mirror, between the rays through the ends of its part in the beam.
        right_end_x, right_end_y = px - first * ny - image_x, py + first * nx - image_y
        left_end_x, left_end_y = px - last * ny - image_x, py + last * nx - image_y
        for at_thing in range(counts.boxes + counts.posts):
            thing = at_thing if at_thing < counts.boxes else counts.boxes + scene.posts[at_thing - counts.boxes]
            views = add_view(scene.views, 0, right_end_x, right_end_y, left_end_x, left_end_y)
            told = nearest_in_sight(thing, x, y, z, nx, ny, height, views, thin, best, scene, counts)
            if told < best and size >= thin * told * told * told:
                best = told
        for at_other in range(met if met >= 0 else others):
            other = reached[grid.found[at_other]] if met >= 0 else reached[at_other]
            best = _corner_in_wall(
                other, x, y, z, nx, ny, height, right_end_x, right_end_y, left_end_x, left_end_y, size, thin,
                wave, best, scene, counts,
            )  # fmt: skip
    return best
