"""The arrays that kernels work on: what each row and column of a block means.

Numbers of one type are packed into one block, since calling a compiled function from Python costs a tenth of a
microsecond for each array. Blocks of bodies have a row for each quantity and a column for each body. Blocks of parts,
wall pieces and edges have a row for each thing. A pose block, float64[3, n], has the rows `X`, `Y` and `HEADING` of
`rows`, which come first in the state. Lengths are metres, angles radians, in the world's frame unless said otherwise.

A name of a row or a column stands for one index in all of `kernels`. The rows of the state are written with their
module, `rows.SPEED`.
"""

import hashlib
import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int64]

# Rows of a twist block, float64[2, n]: travel along the arc, forward, and turn, anticlockwise, of one tick.
TRAVEL, TURN = 0, 1

# Rows of an outcome block, float64[6, n]: the pose after the tick, forward travel and turn achieved, and
# the allowed penetration after it.
END_X, END_Y, END_HEADING, FORWARD, TURNED, END_ALLOWED = 0, 1, 2, 3, 4, 5

# Rows of an outcome's flags, int64[4, n]: was not granted all that it proposed; wheels stop; collided (its own motion
# led into something); touched something or was touched.
BLOCKED, STALLED, COLLIDED, TOUCHED = 0, 1, 2, 3

# Columns of a hit block, int64[hits, 6]: body; other body, or -2 for a wall; index of the wall, or -1; part of the
# body; part of the other, or wall piece; who collided (1 the body, 2 the other, 3 both).
HIT_BODY, HIT_OTHER, HIT_WALL, HIT_PART, HIT_OTHER_PART, HIT_WHO = 0, 1, 2, 3, 4, 5

# Columns of a hit's numbers, float64[hits, 6]: point, unit normal along which the body leaves the other, depth that was
# proposed, m, and by how much they approached along the normal in the tick as wanted, m.
HIT_X, HIT_Y, HIT_NORMAL_X, HIT_NORMAL_Y, HIT_DEPTH, HIT_CLOSING = 0, 1, 2, 3, 4, 5

# Columns of a part block, float64[parts, 6]: centre in the body frame, half length (along the heading), half width,
# z range.
PART_X, PART_Y, HALF_LENGTH, HALF_WIDTH, BOTTOM, TOP = 0, 1, 2, 3, 4, 5

# Rows of a shape block, float64[4, n]: farthest corner from the centre of movement, z range, least thickness of a part.
RADIUS, LOWEST, HIGHEST, THICKNESS = 0, 1, 2, 3

# Rows of a marks block, int64[3, n]: 53-bit key of the name; 1 for an externally posed body (a real
# chair), which the simulator never moves; 1 for a body on a hinge.
KEY, EXTERNALLY_POSED, ANCHORED = 0, 1, 2

# Columns of a piece block, float64[pieces, 7]: bounding box, z range, distance through the piece.
PIECE_X0, PIECE_Y0, PIECE_X1, PIECE_Y1, PIECE_BOTTOM, PIECE_TOP, PIECE_THICKNESS = 0, 1, 2, 3, 4, 5, 6

# Columns of a links block, int64[pieces, 3]: first edge, one past the last edge, index of the wall.
FIRST_EDGE, END_EDGE, WALL = 0, 1, 2

# Columns of an edge block, float64[edges, 6]: corner where it starts (anticlockwise), unit normal outwards,
# normal . corner, 1 for an edge of the wall or 0 for one along which the wall was cut into pieces.
EDGE_X, EDGE_Y, NORMAL_X, NORMAL_Y, OFFSET, OUTER = 0, 1, 2, 3, 4, 5

# Places of a frame, float64[3]: lower left corner of the grid, edge of a cell.
ORIGIN_X, ORIGIN_Y, CELL = 0, 1, 2


class Walls(NamedTuple):
    """All walls and obstacles, as convex pieces in a grid.

    Attributes:
        pieces: float64[pieces, 7], columns `PIECE_X0` to `PIECE_THICKNESS`.
        links: int64[pieces, 3], columns `FIRST_EDGE`, `END_EDGE`, `WALL`.
        edges: float64[edges, 6], columns `EDGE_X` to `OUTER`; those of a piece follow one another anticlockwise.
        cells: int64, as `grid.fill_cells` makes it.
        frame: float64[3], places `ORIGIN_X`, `ORIGIN_Y`, `CELL`.
    """

    pieces: Floats
    links: Ints
    edges: Floats
    cells: Ints
    frame: Floats


class Bodies(NamedTuple):
    """The shapes of all bodies, in the order of the state's arrays.

    Attributes:
        parts: float64[parts, 6], columns `PART_X` to `TOP`; those of a body follow one another.
        part_start: int64[n + 1], the first part of each body and the end.
        shape: float64[4, n], rows `RADIUS` to `THICKNESS`.
        marks: int64[3, n], rows `KEY`, `EXTERNALLY_POSED`, `ANCHORED`.
    """

    parts: Floats
    part_start: Ints
    shape: Floats
    marks: Ints


class Box(NamedTuple):
    """One upright box of a body.

    Attributes:
        x: Its centre in the body frame, forward of the centre of movement, m.
        y: Its centre in the body frame, to the left, m.
        length: Along the heading, m, > 0.
        width: Across, m, > 0.
        bottom: Lower end of the half-open z interval, m.
        top: Upper end, m.
    """

    x: float
    y: float
    length: float
    width: float
    bottom: float
    top: float


class Shape(NamedTuple):
    """A body, as the kernels need it.

    Attributes:
        name: Its name, from which its key is made.
        boxes: At least one.
        externally_posed: True for a real chair, which the simulator never moves.
        anchored: True for a body on a hinge.
    """

    name: str
    boxes: Sequence[Box]
    externally_posed: bool = False
    anchored: bool = False


def key_of(name: str) -> int:
    """Return the key of a name, 53 bits of its BLAKE2b digest."""
    return int.from_bytes(hashlib.blake2b(name.encode(), digest_size=8).digest(), "big") >> 11


def part_rows(boxes: Sequence[Box]) -> Floats:
    """Return the boxes as a part block."""
    return np.array([[b.x, b.y, b.length / 2.0, b.width / 2.0, b.bottom, b.top] for b in boxes], np.float64).reshape(
        -1, 6
    )


def radius_of(boxes: Sequence[Box]) -> float:
    """Return the distance of the farthest corner from the centre of movement, m: the turning radius."""
    return max(
        math.sqrt(dx * dx + dy * dy)
        for dx, dy in ((abs(box.x) + box.length / 2.0, abs(box.y) + box.width / 2.0) for box in boxes)
    )


def bodies_from(shapes: Sequence[Shape]) -> Bodies:
    """Return the bodies as arrays, in the order given: that of the state's arrays, sorted by name.

    Raises:
        ValueError: A body has no box, or a box without extent.
    """
    for shape in shapes:
        if not shape.boxes:
            raise ValueError(f"body {shape.name!r}: expected at least 1 part, got 0")
        for box in shape.boxes:
            if not (box.length > 0.0 and box.width > 0.0 and box.top > box.bottom):
                raise ValueError(f"body {shape.name!r}: expected parts with length, width and height, got {box}")
    boxes = [box for shape in shapes for box in shape.boxes]
    counts = [len(shape.boxes) for shape in shapes]
    return Bodies(
        parts=part_rows(boxes),
        part_start=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        shape=np.array(
            [
                [radius_of(shape.boxes) for shape in shapes],
                [min(box.bottom for box in shape.boxes) for shape in shapes],
                [max(box.top for box in shape.boxes) for shape in shapes],
                [min(min(box.length, box.width) for box in shape.boxes) for shape in shapes],
            ],
            np.float64,
        ).reshape(4, len(shapes)),
        marks=np.array(
            [
                [key_of(shape.name) for shape in shapes],
                [int(shape.externally_posed) for shape in shapes],
                [int(shape.anchored) for shape in shapes],
            ],
            np.int64,
        ).reshape(3, len(shapes)),
    )


def reordered(first: Bodies, second: Bodies, columns: Ints) -> Bodies:
    """Return bodies of two blocks in another order.

    Args:
        first: Some bodies.
        second: Others.
        columns: int64[n], which body comes where: its column in `first`, or that in `second` behind those of `first`.
    """
    counts = np.concatenate([np.diff(first.part_start), np.diff(second.part_start)])
    starts = np.concatenate([first.part_start[:-1], second.part_start[:-1] + len(first.parts)])[columns]
    counts = counts[columns]
    part_start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    places = np.arange(part_start[-1]) + np.repeat(starts - part_start[:-1], counts)
    return Bodies(
        parts=np.concatenate([first.parts, second.parts]).take(places, axis=0),
        part_start=part_start,
        shape=np.concatenate([first.shape, second.shape], axis=1).take(columns, axis=1),
        marks=np.concatenate([first.marks, second.marks], axis=1).take(columns, axis=1),
    )
