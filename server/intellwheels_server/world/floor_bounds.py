"""Tells whether a position is outside a map with outer walls, where a body would drive in a void. Pure."""

from __future__ import annotations

from typing import Final

import numpy as np

from intellwheels_schemas.messages import Map
from intellwheels_server.world.kernels.arrays import (
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    Floats,
    Ints,
    Walls,
)

LINES: Final = 64
"""Lines along each axis on which outer walls are looked for."""
SHARE: Final = 0.5
"""Least share of the lines that must meet walls on both sides of free space. Others may run through doorways."""


def outside(walls: Walls, floor: Map, x: float, y: float) -> str | None:
    """Return what is wrong with a position outside a map with outer walls, or None.

    A position is outside if it is beyond the box of all walls, obstacles and places. A map without outer walls, such as
    a plane with a few obstacles, has no boundary.

    Args:
        walls: The walls of the map.
        floor: The map.
        x: Position, m.
        y: Position, m.
    """
    if not len(walls.pieces):
        return None
    west, south, east, north = (
        walls.pieces[:, PIECE_X0].min(),
        walls.pieces[:, PIECE_Y0].min(),
        walls.pieces[:, PIECE_X1].max(),
        walls.pieces[:, PIECE_Y1].max(),
    )
    if west <= x <= east and south <= y <= north:  # most are, and a map may have ten thousand places
        return None
    spots = [(spot.x, spot.y) for spot in floor.grid.position] if floor.grid is not None else []
    low = np.min([*spots, (west, south)], axis=0)
    high = np.max([*spots, (east, north)], axis=0)
    if low[0] <= x <= high[0] and low[1] <= y <= high[1]:
        return None
    if not (_encloses(walls, EDGE_X, EDGE_Y) and _encloses(walls, EDGE_Y, EDGE_X)):
        return None
    expected = f"x in [{low[0]:.6g}, {high[0]:.6g}] and y in [{low[1]:.6g}, {high[1]:.6g}]"
    return f"map '{floor.name}' has outer walls: expected {expected}, got ({x:.6g}, {y:.6g})"


def _encloses(walls: Walls, across: int, along: int) -> bool:
    """Return whether most lines at a fixed coordinate `across` meet walls, then free space, then walls."""
    starts, ends = walls.links[:, FIRST_EDGE], walls.links[:, END_EDGE]
    # From each corner to the next of its piece.
    following = np.arange(1, len(walls.edges) + 1)
    following[ends - 1] = starts
    here, there = walls.edges, walls.edges[following]
    low, high = walls.edges[:, across].min(), walls.edges[:, across].max()
    lines = low + (high - low) * (np.arange(LINES) + 0.5) / LINES
    return sum(_has_gap(here, there, starts, across, along, line) for line in lines) >= SHARE * LINES


def _has_gap(here: Floats, there: Floats, starts: Ints, across: int, along: int, line: float) -> bool:
    """Return whether free space lies between the pieces that a line meets."""
    a, b = here[:, across], there[:, across]
    crossed = (np.minimum(a, b) <= line) & (line < np.maximum(a, b))
    share = (line - a) / np.where(crossed, b - a, 1.0)
    at = here[:, along] + share * (there[:, along] - here[:, along])
    low = np.minimum.reduceat(np.where(crossed, at, np.inf), starts)
    high = np.maximum.reduceat(np.where(crossed, at, -np.inf), starts)
    order = np.argsort(low)
    order = order[np.isfinite(low[order])]
    return bool(np.any(low[order][1:] > np.maximum.accumulate(high[order])[:-1] + 1e-6))
