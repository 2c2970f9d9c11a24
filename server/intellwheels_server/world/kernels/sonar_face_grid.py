"""Which faces a way by a mirror can meet: a grid over the faces around a sonar, made where there are many.

All coordinates start from the sonar. A search finds at least what it must, in the order of the faces: a loop over what
it found has the result of a loop over all faces, to the bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.grid import cell_of, fill_cells

# Pairs of a mirror and a face from which on a grid costs less than a look at all of them.
MANY_PAIRS = 2048

# Faces count as larger than they are by this, so that rounding hides none, m.
_PAD = 1e-5

# Most cells along a side of the grid.
_MOST_CELLS = 64


class FaceGrid(NamedTuple):
    """A grid over faces.

    Attributes:
        cells: int64, as `grid.fill_cells` makes it; empty if there is no grid.
        low: Left and lower edge, m.
        size: Edge of a cell, m.
        margin: Faces count as larger by this, m.
        marks: int64[>= faces], the last search that found each face.
        corners: float64[2, 3], scratch: x and y of the corners of what is searched.
        found: int64[>= faces], out of a search.
    """

    cells: Ints
    low: float
    size: float
    margin: float
    marks: Ints
    corners: Floats
    found: Ints


@njit(cache=True, error_model="numpy")
def face_grid(
    x: float, y: float, reach: float, wave: float, faces: Floats, chosen: Ints, marks: Ints, corners: Floats,
    found: Ints, wanted: bool,
) -> FaceGrid:  # fmt: skip
    """Return a grid over some faces.

    Args:
        x: The sonar, m.
        y: The same.
        reach: Half the edge of the grid, m. What is outside counts to its outermost cells.
        wave: Wavelength, m: a vertex may lie so far beside the faces that meet in it.
        faces: Of the scene.
        chosen: The rows of the faces, ascending.
        marks: Scratch of the scene, as the next two.
        corners: Scratch.
        found: Scratch.
        wanted: Whether to make one; otherwise the grid is empty.
    """
    count, margin = chosen.shape[0], wave + _PAD
    if not wanted:
        return FaceGrid(found[:0], -reach, 2.0 * reach, margin, marks, corners, found)
    marks[:count] = 0
    side = min(int(math.sqrt(count)) + 1, _MOST_CELLS)
    size = 2.0 * reach / side
    boxes = np.empty((count, 4))
    for at in range(count):
        face = chosen[at]
        px, py = faces[face, face_columns.X] - x, faces[face, face_columns.Y] - y
        length = faces[face, face_columns.LENGTH]
        qx, qy = px - length * faces[face, face_columns.NY], py + length * faces[face, face_columns.NX]
        boxes[at, 0], boxes[at, 1] = min(px, qx) - margin, min(py, qy) - margin
        boxes[at, 2], boxes[at, 3] = max(px, qx) + margin, max(py, qy) + margin
    cells = fill_cells(boxes, -reach, -reach, size, side, side)
    return FaceGrid(cells, -reach, size, margin, marks, corners, found)


@njit(cache=True, error_model="numpy")
def _search(sides: int, number: int, count: int, grid: FaceGrid) -> int:
    """Add the faces that may meet a convex polygon to those found; return how many there are now.

    Args:
        sides: How many of the corners count: 2 for a line.
        number: Of this search, above 0.
        count: How many faces it has found already.
        grid: The grid; faces are found as their places in it.
    """
    cells, low, size, _, marks, corners, found = grid
    xs, ys = corners[0], corners[1]
    columns, rows = cells[0], cells[1]
    bottom = top = ys[0]
    for at in range(1, sides):
        bottom, top = min(bottom, ys[at]), max(top, ys[at])
    first_row, last_row = cell_of(bottom, low, size, rows), cell_of(top, low, size, rows)
    for row in range(first_row, last_row + 1):
        row_bottom = low + row * size if row > 0 else -np.inf
        row_top = low + (row + 1) * size if row + 1 < rows else np.inf
        left, right = np.inf, -np.inf
        for at in range(sides):
            after = at + 1 if at + 1 < sides else 0
            if ys[at] < ys[after]:
                x0, y0, x1, y1 = xs[at], ys[at], xs[after], ys[after]
            else:
                x0, y0, x1, y1 = xs[after], ys[after], xs[at], ys[at]
            if y0 > row_top or y1 < row_bottom:
                continue
            slope = (x1 - x0) / (y1 - y0) if y1 > y0 else 0.0
            if y0 < row_bottom:
                x0 += slope * (row_bottom - y0)
            if y1 > row_top:
                x1 -= slope * (y1 - row_top)
            left, right = min(left, x0, x1), max(right, x0, x1)
        if left > right:
            continue
        begin = 2 + row * columns + cell_of(left, low, size, columns)
        end = 2 + row * columns + cell_of(right, low, size, columns) + 1
        for place in range(cells[begin], cells[end]):
            face = cells[place]
            if marks[face] != number:
                marks[face] = number
                found[count] = face
                count += 1
    return count


@njit(cache=True, error_model="numpy")
def faces_by_mirror(
    px: float, py: float, nx: float, ny: float, length: float, height: float, first: float, last: float, reach: float,
    number: int, grid: FaceGrid,
) -> int:  # fmt: skip
    """Find the faces that a way by a mirror can meet; return how many, or -1 for all.

    A way meets them in the sector of the part of the mirror in the beam, as its image sees it, or at a vertex beside
    the mirror.

    Args:
        px: The corner of the mirror, m.
        py: The same.
        nx: Its normal.
        ny: The same.
        length: Its length, m.
        height: The mirror along its normal, from the sonar, m, below 0.
        first: Where its part in the beam begins, from its corner, m.
        last: Where it ends, m.
        reach: The longest way from the image to a face, m.
        number: Of the mirror, above 0 and different for each of a grid.
        grid: The grid. The places of the faces among those of the grid are in `found`, ascending.
    """
    image_x, image_y = 2.0 * height * nx, 2.0 * height * ny
    right_x, right_y = px - first * ny - image_x, py + first * nx - image_y
    left_x, left_y = px - last * ny - image_x, py + last * nx - image_y
    right, left = math.sqrt(right_x * right_x + right_y * right_y), math.sqrt(left_x * left_x + left_y * left_y)
    if right_x * left_x + right_y * left_y < 0.5 * right * left:  # a sector of more than 60 degrees
        return -1
    # A triangle that contains the sector: its side lies beyond the arc, as 1.2 cos(30 degrees) > 1.
    right, left = 1.2 * reach / right, 1.2 * reach / left
    xs, ys = grid.corners[0], grid.corners[1]
    xs[0], ys[0] = image_x, image_y
    xs[1], ys[1] = image_x + right * right_x, image_y + right * right_y
    xs[2], ys[2] = image_x + left * left_x, image_y + left * left_y
    count = _search(3, number, 0, grid)
    margin = grid.margin
    xs[0], ys[0] = px + margin * ny, py - margin * nx
    xs[1], ys[1] = px - (length + margin) * ny, py + (length + margin) * nx
    count = _search(2, number, count, grid)
    grid.found[:count].sort()
    return count
