"""Posts and bodies: rough things, which a sonar hears at the nearest point that it sees, directly or in a wall.

A thing is looked for in all directions of the beam first. If something hides its nearest point, what hides it hides a
whole sector of directions. Both sides of this sector are then looked at by themselves, and so on.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import PIECE_BOTTOM, PIECE_TOP, Floats
from intellwheels_server.world.kernels.sonar_faces import is_inside, segment_between, sides_of_box, sides_of_piece
from intellwheels_server.world.kernels.sonar_scene import VIEWS, Counts, Scene
from intellwheels_server.world.kernels.sonar_sight import hiding_thing, outline
from intellwheels_server.world.kernels.sonar_widths import body_span, gather_solid
from intellwheels_server.world.kernels.spatial_query import (
    CENTRE_X,
    CENTRE_Y,
    EXTENT_X,
    EXTENT_Y,
    HIGH,
    LOW,
)

# Columns of a view, float64[VIEWS, 6]: directions of its right and its left side, from the sonar or its image; 1 for a
# side at which something hides the rest.
RIGHT_X, RIGHT_Y, LEFT_X, LEFT_Y, RIGHT_HIDES, LEFT_HIDES = 0, 1, 2, 3, 4, 5

# Sectors begin so far beside what hides them, rad.
_BESIDE = 1e-9

# Views that are looked at for one thing, at most: far more than things stand before another.
_MOST_LOOKS = 256


@njit(cache=True, error_model="numpy")
def add_view(views: Floats, at: int, right_x: float, right_y: float, left_x: float, left_y: float) -> int:
    """Store a view of less than half a turn, or of exactly half a turn, with open sides; return the next row."""
    views[at, RIGHT_X], views[at, RIGHT_Y] = right_x, right_y
    views[at, LEFT_X], views[at, LEFT_Y] = left_x, left_y
    views[at, RIGHT_HIDES] = views[at, LEFT_HIDES] = 0.0
    return at + 1


@njit(cache=True, error_model="numpy")
def _fill_sides(thing: int, x: float, y: float, sides: Floats, scene: Scene, counts: Counts) -> int:
    """Store the sides of a part, or of a wall piece behind the parts, as seen from a place; return how many."""
    if thing < counts.boxes:
        return int(sides_of_box(scene.boxes, thing, x, y, sides))
    return int(sides_of_piece(thing - counts.boxes, scene.links, scene.edges, x, y, sides))


@njit(cache=True, error_model="numpy")
def _seen_width(
    thing: int, x: float, y: float, z: float, to_x: float, to_y: float, views: Floats, view: int, scene: Scene,
    counts: Counts,
) -> float:  # fmt: skip
    """Return the width of a thing across the way to its nearest point, as far as nothing hides it in a view, m."""
    distance = math.sqrt(to_x * to_x + to_y * to_y)
    dx, dy = to_x / distance, to_y / distance
    if thing < counts.boxes:
        low, high = body_span(thing, z, dx, dy, scene.boxes, scene.owners, counts.boxes, scene.members)
    else:
        _, low, high = gather_solid(
            thing - counts.boxes, dx, dy, np.inf, scene.pieces, scene.links, scene.edges, scene.cells, scene.frame,
            scene.members, scene.marks,
        )  # fmt: skip
    middle = dx * y - dy * x
    low, high = low - middle, high - middle
    if views[view, RIGHT_HIDES] > 0.0:
        ahead = dx * views[view, RIGHT_X] + dy * views[view, RIGHT_Y]
        if ahead > 0.0:
            low = max(low, distance * (dx * views[view, RIGHT_Y] - dy * views[view, RIGHT_X]) / ahead)
    if views[view, LEFT_HIDES] > 0.0:
        ahead = dx * views[view, LEFT_X] + dy * views[view, LEFT_Y]
        if ahead > 0.0:
            high = min(high, distance * (dx * views[view, LEFT_Y] - dy * views[view, LEFT_X]) / ahead)
    return high - low


@njit(cache=True, error_model="numpy")
def nearest_in_sight(
    thing: int, x: float, y: float, z: float, nx: float, ny: float, height: float, view_count: int, thin: float,
    best: float, scene: Scene, counts: Counts,
) -> float:  # fmt: skip
    """Return the distance of the nearest point of a rough thing that a sonar sees, m, at most `best`.

    Args:
        thing: The row of a part, or the number of parts and the index of a wall piece.
        x: The sonar, m.
        y: The same.
        z: Height, m.
        nx: Normal of the wall in which it sees the thing.
        ny: The same.
        height: The wall along this normal, from the sonar, m, below 0; 0 if it sees the thing directly.
        view_count: The views of the scene that hold the directions to look in, from the sonar or from its image.
        thin: What is narrower than this times the cube of its distance is not heard, 1/m2.
        best: The distance of the nearest echo so far, m.
        scene: What is around the sonar.
        counts: How much of it there is.

    Returns:
        0 from inside the thing.
    """
    views, sides, hiding_sides = scene.views, scene.sides[0], scene.sides[1]
    image_x, image_y = 2.0 * height * nx, 2.0 * height * ny
    if thing < counts.boxes:
        boxes = scene.boxes
        if not boxes[thing, LOW] <= z < boxes[thing, HIGH]:
            return best
        gap_x = max(abs(boxes[thing, CENTRE_X] - x - image_x) - boxes[thing, EXTENT_X], 0.0)
        gap_y = max(abs(boxes[thing, CENTRE_Y] - y - image_y) - boxes[thing, EXTENT_Y], 0.0)
        if gap_x * gap_x + gap_y * gap_y > best * best:
            return best
    elif not scene.pieces[thing - counts.boxes, PIECE_BOTTOM] <= z < scene.pieces[thing - counts.boxes, PIECE_TOP]:
        return best
    count = _fill_sides(thing, x + image_x, y + image_y, sides, scene, counts)
    if is_inside(sides, count):
        return 0.0 if height == 0.0 else best
    looks = 0
    while view_count > 0 and looks < _MOST_LOOKS:
        looks += 1
        view_count -= 1
        right_x, right_y = views[view_count, RIGHT_X], views[view_count, RIGHT_Y]
        left_x, left_y = views[view_count, LEFT_X], views[view_count, LEFT_Y]
        closest, to_x, to_y = np.inf, 0.0, 0.0
        for side in range(count):
            if not sides[side, 4] * sides[side, 0] + sides[side, 5] * sides[side, 1] < 0.0:
                continue  # seen from behind
            found, found_x, found_y = segment_between(
                sides[side, 0], sides[side, 1], sides[side, 2], sides[side, 3], right_x, right_y, left_x, left_y
            )
            if found < closest:
                closest, to_x, to_y = found, found_x, found_y
        if not closest < best * best:
            continue
        if height < 0.0 and nx * to_x + ny * to_y <= -height:
            continue  # behind the wall
        distance = math.sqrt(closest)
        width = _seen_width(thing, x + image_x, y + image_y, z, to_x, to_y, views, view_count, scene, counts)
        if width < thin * distance * closest:
            continue
        hiding, hidden_before = -1, height < 0.0
        if height < 0.0:
            share = -height / (nx * to_x + ny * to_y)
            ax, ay = image_x + share * to_x, image_y + share * to_y
            hiding = hiding_thing(x, y, z, ax, ay, 0.0, thin, -1, scene, counts)
            if hiding < 0:
                hidden_before = False
                hiding = hiding_thing(
                    x + ax, y + ay, z, image_x + to_x - ax, image_y + to_y - ay, math.sqrt(ax * ax + ay * ay), thin, -1,
                    scene, counts,
                )  # fmt: skip
        else:
            hiding = hiding_thing(x, y, z, to_x, to_y, 0.0, thin, -1, scene, counts)
        if hiding < 0:
            best = distance
            continue
        # What hides it, as it is seen from the sonar, or from its image.
        if hidden_before:
            other = _fill_sides(hiding, x, y, hiding_sides, scene, counts)
        else:
            other = _fill_sides(hiding, x + image_x, y + image_y, hiding_sides, scene, counts)
        if is_inside(hiding_sides, other):
            continue
        first_x, first_y, last_x, last_y = outline(hiding_sides, other)
        if hidden_before:  # on the way to the wall; in the wall right and left are exchanged
            across_first, across_last = 2.0 * (nx * first_x + ny * first_y), 2.0 * (nx * last_x + ny * last_y)
            first_x, first_y, last_x, last_y = (
                last_x - across_last * nx, last_y - across_last * ny, first_x - across_first * nx,
                first_y - across_first * ny,
            )  # fmt: skip
        first_x, first_y = first_x + _BESIDE * first_y, first_y - _BESIDE * first_x
        last_x, last_y = last_x - _BESIDE * last_y, last_y + _BESIDE * last_x
        right_hides, left_hides = views[view_count, RIGHT_HIDES], views[view_count, LEFT_HIDES]
        if view_count + 2 > VIEWS:
            continue
        if last_x * left_y - last_y * left_x > 0.0:
            view_count = add_view(views, view_count, last_x, last_y, left_x, left_y)
            views[view_count - 1, RIGHT_HIDES], views[view_count - 1, LEFT_HIDES] = 1.0, left_hides
        if right_x * first_y - right_y * first_x > 0.0:
            view_count = add_view(views, view_count, right_x, right_y, first_x, first_y)
            views[view_count - 1, RIGHT_HIDES], views[view_count - 1, LEFT_HIDES] = right_hides, 1.0
    return best


@njit(cache=True, error_model="numpy")
def is_in_wall(x: float, y: float, z: float, scene: Scene, counts: Counts) -> bool:
    """Return whether a place is inside a wall."""
    sides = scene.sides[0]
    for at in range(counts.near):
        piece = scene.near[at]
        if scene.pieces[piece, PIECE_BOTTOM] <= z < scene.pieces[piece, PIECE_TOP] and is_inside(
            sides, sides_of_piece(piece, scene.links, scene.edges, x, y, sides)
        ):
            return True
    return False
