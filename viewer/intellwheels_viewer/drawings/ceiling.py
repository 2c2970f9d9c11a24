"""The ceiling of a building and its lamps, which only a view from inside shows. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from intellwheels_maps.plane_geometry import contains
from intellwheels_schemas.messages import Map
from intellwheels_viewer.drawings import textures
from intellwheels_viewer.drawings.building_colours import BuildingColours
from intellwheels_viewer.drawings.glb import Surface
from intellwheels_viewer.drawings.polygons import Point, bounds
from intellwheels_viewer.drawings.rooms import corners_of, extent, grounds, is_outdoors
from intellwheels_viewer.drawings.solids import Solid, join, sheet

LOWEST: Final = 1.9
"""Walls that are lower than this, in metres, carry no ceiling."""
BELOW: Final = 0.03
"""Metres from the upper edge of the walls down to the ceiling, which hides their caps."""
_PITCH: Final = 2.8
"""Metres between the middles of two lamps at most."""
_LAMP: Final = (1.2, 0.3)
_MOST_LAMPS: Final = 400


def height(floor: Map) -> float | None:
    """Return the height of the ceiling: a little below the top of the highest walls.

    There is none outdoors and where all walls are low: None.
    """
    tall = max((wall.height for wall in floor.wall if wall.bottom <= 0.0), default=0.0)
    return None if is_outdoors(floor) or tall < LOWEST else tall - BELOW


def ceiling(floor: Map, colours: BuildingColours) -> list[Surface]:
    """Return the ceiling, seen from below, and the lamps in it."""
    z = height(floor)
    if z is None:
        return []
    panels = _down(join(sheet(polygon, z) for polygon in [*_rooms(floor), *grounds(floor)]))
    lit = _down(join(sheet(polygon, z - 0.012) for polygon in lamps(floor)))
    uv = panels.vertices[:, :2] * np.float32(1.0 / textures.METRES["panels"])
    return [
        Surface(panels, colours.ceiling, uv=uv, picture=textures.picture("panels")),
        Surface(lit, colours.lamp, glows=True),
    ]


def lamps(floor: Map) -> list[list[Point]]:
    """Return the outlines of the lamps: in each room a grid of them, along its longer side."""
    return [lamp for room in _rooms(floor) for lamp in _lamps(room)][:_MOST_LAMPS]


def _rooms(floor: Map) -> list[list[Point]]:
    x0, x1, y0, y1 = extent(floor)
    return [corners_of(zone) for zone in floor.zone] or [[(x0, y0), (x1, y0), (x1, y1), (x0, y1)]]


def _lamps(room: list[Point]) -> Iterator[list[Point]]:
    x0, x1, y0, y1 = bounds(room)
    columns, rows = (max(1, math.ceil((b - a) / _PITCH - 0.2)) for a, b in ((x0, x1), (y0, y1)))
    long, wide = (each / 2 for each in (_LAMP if x1 - x0 >= y1 - y0 else _LAMP[::-1]))
    for column in range(columns):
        for row in range(rows):
            x, y = x0 + (column + 0.5) * (x1 - x0) / columns, y0 + (row + 0.5) * (y1 - y0) / rows
            lamp = [(x - long, y - wide), (x + long, y - wide), (x + long, y + wide), (x - long, y + wide)]
            if all(contains(room, corner) for corner in lamp):
                yield lamp


def _down(flat: Solid) -> Solid:
    return Solid(flat.vertices, flat.faces[:, ::-1].copy())
