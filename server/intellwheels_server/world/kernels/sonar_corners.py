"""Convex corners of walls: the sharp ones diffract sound, those of a round pillar reflect it as the pillar does.

A sonar hears a corner if no face beside it is nearer: from between the normals of the two faces. The echo of an edge is
compared with that of a cylinder. A ping of 1 / r comes back from a cylinder of radius a as sqrt(a) / (2 r^1.5) and from
an edge as D / (sqrt(2) r^1.5), where r is the distance. So an edge is heard as far as a cylinder of the width
4 D^2. With the coefficient D of a rigid wedge, this is

    w = lambda (sin(pi / n) S / (pi n))^2,  S = 1 / (cos(pi / n) - 1) + 1 / (cos(pi / n) - cos(2 phi / n)),

where lambda is the wavelength, n pi the angle outside the wedge and phi that between a face and the sound. It grows
without bound towards the normals of the faces, where the faces themselves are heard.

A polygon stands for a round thing where its corners bend by no more than `BEND` and stand out by no more than `ROUND`
from an arc that touches both sides. Such a corner is heard as far as the cylinder of this arc.

Source:
    Keller (1962), Geometrical theory of diffraction, Journal of the Optical Society of America 52(2); in the form of
    Kouyoumjian and Pathak (1974), Proceedings of the IEEE 62(11), for a hard wedge and sound that goes back.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    CELL,
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    NORMAL_X,
    NORMAL_Y,
    ORIGIN_X,
    ORIGIN_Y,
    PIECE_BOTTOM,
    PIECE_TOP,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.elementary import PI, atan2, cos, sincos
from intellwheels_server.world.kernels.grid import cell_of
from intellwheels_server.world.kernels.sonar_widths import TOUCH

# Corners of a polygon that stands for a round thing bend by no more than this, rad, and stand out by no more than this
# from the arc, m; chosen. An octagon is round up to a radius of 0.24 m, a polygon of 16 sides up to 1 m.
BEND = 0.7854
ROUND = 0.02

# A corner that bends by less is none, rad.
_FLAT = 1e-6


@njit(cache=True, error_model="numpy")
def edge_width(outside: float, phi: float, wave: float) -> float:
    """Return the width of the cylinder that is heard as far as an edge, m; inf towards the normals of its faces.

    Args:
        outside: The angle outside the wedge, rad, in (pi, 2 pi].
        phi: The angle between a face and the sound, rad, in [pi / 2, outside - pi / 2].
        wave: Wavelength, m.
    """
    n = outside / PI
    s, c = sincos(PI / n)
    between = c - cos(2.0 * phi / n)
    if between <= 1e-12:
        return np.inf
    factor = s * (1.0 / (c - 1.0) + 1.0 / between) / (PI * n)
    return wave * factor * factor


@njit(cache=True, error_model="numpy")
def round_width(bend: float, side: float) -> float:
    """Return the width of the round thing for which a corner stands, m; 0 if it stands for none.

    Args:
        bend: By how much the corner bends, rad, > 0.
        side: The length of the shorter side beside it, m.
    """
    if bend > BEND:
        return 0.0
    s, c = sincos(bend)
    half_tan = s / (1.0 + c)
    if 0.5 * side * half_tan / (1.0 + math.sqrt(1.0 + half_tan * half_tan)) > ROUND:
        return 0.0
    return side / half_tan


@njit(cache=True, error_model="numpy")
def _length(edge: int, first: int, end: int, edges: Floats) -> float:
    """Return the length of an edge of a piece, m."""
    after = edge + 1 if edge + 1 < end else first
    dx, dy = edges[after, EDGE_X] - edges[edge, EDGE_X], edges[after, EDGE_Y] - edges[edge, EDGE_Y]
    return math.sqrt(dx * dx + dy * dy)


@njit(cache=True, error_model="numpy")
def corner_width(
    x: float, y: float, z: float, to_x: float, to_y: float, wave: float, near: Ints, ranks: Ints, near_count: int,
    pieces: Floats, links: Ints, edges: Floats, cells: Ints, frame: Floats,
) -> float:  # fmt: skip
    """Return the width of the cylinder that is heard as far as a corner, m; 0 if it is not heard from there.

    What counts is the angle that all walls at the corner leave free, so it does not matter how they were cut.

    Args:
        x: The corner, m.
        y: The same.
        z: Height, m.
        to_x: Direction to the sonar, or to its image.
        to_y: The same.
        wave: Wavelength, m.
        near: Of the scene, as the next one.
        ranks: Of the scene.
        near_count: Of the scene.
        pieces: Of the walls, as the next four.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
    """
    to_left = to_right = 2.0 * PI  # from the sound to the next face on either side
    left_side = right_side = 0.0
    left_rank = right_rank = -1  # of two faces in one direction, that of the nearer rank counts
    first_column = cell_of(x - TOUCH, frame[ORIGIN_X], frame[CELL], cells[0])
    last_column = cell_of(x + TOUCH, frame[ORIGIN_X], frame[CELL], cells[0])
    for row in range(
        cell_of(y - TOUCH, frame[ORIGIN_Y], frame[CELL], cells[1]),
        cell_of(y + TOUCH, frame[ORIGIN_Y], frame[CELL], cells[1]) + 1,
    ):
        for place in range(cells[2 + row * cells[0] + first_column], cells[2 + row * cells[0] + last_column + 1]):
            piece = cells[place]
            rank = ranks[piece]
            if rank >= near_count or near[rank] != piece:
                continue
            if not pieces[piece, PIECE_BOTTOM] <= z < pieces[piece, PIECE_TOP]:
                continue
            if not pieces[piece, PIECE_X0] - TOUCH <= x <= pieces[piece, PIECE_X1] + TOUCH:
                continue
            if not pieces[piece, PIECE_Y0] - TOUCH <= y <= pieces[piece, PIECE_Y1] + TOUCH:
                continue
            first, end = links[piece, FIRST_EDGE], links[piece, END_EDGE]
            leaving = arriving = -1
            apart = False
            last = end - 1
            beyond = edges[last, NORMAL_X] * (x - edges[last, EDGE_X]) + edges[last, NORMAL_Y] * (
                y - edges[last, EDGE_Y]
            )
            before = abs(beyond) <= TOUCH  # whether the corner is on the edge before
            on_any = -1
            for edge in range(first, end):
                beyond = edges[edge, NORMAL_X] * (x - edges[edge, EDGE_X]) + edges[edge, NORMAL_Y] * (
                    y - edges[edge, EDGE_Y]
                )
                apart |= beyond > TOUCH
                on = abs(beyond) <= TOUCH
                if on:
                    on_any = edge
                    if before:
                        leaving, arriving = edge, edge - 1 if edge > first else last
                before = on
            if apart:
                continue
            if on_any < 0:
                return 0.0  # inside a wall
            if leaving < 0:  # in the middle of an edge
                leaving = arriving = on_any
            ax, ay = -edges[leaving, NORMAL_Y], edges[leaving, NORMAL_X]
            bx, by = edges[arriving, NORMAL_Y], -edges[arriving, NORMAL_X]
            angle = atan2(to_x * ay - to_y * ax, to_x * ax + to_y * ay)
            angle += 2.0 * PI if angle < 0.0 else 0.0
            if angle < to_left or (angle == to_left and rank < left_rank):
                to_left, left_side, left_rank = angle, _length(leaving, first, end, edges), rank
            angle = atan2(bx * to_y - by * to_x, to_x * bx + to_y * by)
            angle += 2.0 * PI if angle < 0.0 else 0.0
            if angle < to_right or (angle == to_right and rank < right_rank):
                to_right, right_side, right_rank = angle, _length(arriving, first, end, edges), rank
    bend = to_left + to_right - PI
    if bend < _FLAT or bend > PI or min(to_left, to_right) < 0.5 * PI - _FLAT:
        return 0.0
    width = edge_width(bend + PI, max(to_right, 0.5 * PI), wave)
    return max(width, round_width(bend, min(left_side, right_side)))
