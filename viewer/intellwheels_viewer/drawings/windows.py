"""Windows in the outer walls of a building, drawn on their faces. Pure.

A map has no windows, and nothing can pass a wall, so they are pictures of windows: a pane and a frame 2 cm thick.
They are where a room is on one side of a wall and nothing on the other.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from intellwheels_maps.check import wall_pieces
from intellwheels_maps.plane_geometry import contains
from intellwheels_schemas.messages import Map
from intellwheels_viewer.drawings.building_colours import BuildingColours, dimmed
from intellwheels_viewer.drawings.furniture import Painted
from intellwheels_viewer.drawings.polygons import Point, anticlockwise
from intellwheels_viewer.drawings.rooms import Rooms, is_outdoors, rooms_of
from intellwheels_viewer.drawings.solids import Solid, box, join

Rows = npt.NDArray[np.float64]

SILL: Final = 0.85
HEAD: Final = 2.05
"""Heights of the lower and the upper edge, in metres."""
WIDTH: Final = 1.4
_PITCH: Final = 2.9
"""Metres between two windows of one wall, from middle to middle."""
_PROUD: Final = 0.02
_BAR: Final = 0.06
_MOST: Final = 1600
"""Maps with more corners of walls than this have no windows: looking for them takes too long."""


Place: TypeAlias = tuple[float, float, float, float]
"""The middle of a window on the inner face of its wall, the heading into the room, and the wall's thickness."""


def windows(found: Iterable[Place], height: float | None, colours: BuildingColours) -> Painted:
    """Return windows by colour.

    Args:
        found: Where they are, see `places`.
        height: Where walls are cut, in metres; None for full height. In a cut wall a window is seen as a light strip.
        colours: Of the building.
    """
    frames: list[Solid] = []
    panes: list[Solid] = []
    for x, y, heading, thick in found:
        top = HEAD if height is None else min(HEAD, height + 0.002)
        for side in (0.0, thick):
            face = _PROUD if side == 0.0 else -_PROUD
            for near, far, inset in ((0.0, face, 0.0), (face, 1.15 * face, _BAR)):
                front, back = -side + near, -side + far
                low, high = sorted((front, back))
                upper = top - (inset if height is None else 0.0)
                (panes if inset else frames).extend(_halves(low, high, inset, upper, heading, x, y))
        if height is not None:
            strip = box(-thick + 0.01, -0.01, -WIDTH / 2, WIDTH / 2, top - 0.01, top + 0.002)
            panes.append(strip.turned(heading).moved(x, y))
    made_up = {dimmed(colours.wall, 0.8): join(frames), colours.glass: join(panes)}
    return {rgb: thing for rgb, thing in made_up.items() if len(thing.faces)}


def _halves(low: float, high: float, inset: float, top: float, heading: float, x: float, y: float) -> list[Solid]:
    """Return a frame as one board, or, inset, its two panes with a bar between."""
    spans = (
        [(-WIDTH / 2, WIDTH / 2)] if not inset else [(-WIDTH / 2 + inset, -inset / 2), (inset / 2, WIDTH / 2 - inset)]
    )
    return [box(low, high, y0, y1, SILL + inset, top).turned(heading).moved(x, y) for y0, y1 in spans]


def beside(found: Iterable[Place], gone: Rows) -> list[Place]:
    """Return the windows in walls that stand.

    Args:
        found: Where windows are.
        gone: Parts of walls that are cut away, shape (n, 4 or more): ends x, y, x, y in metres.
    """
    a, along = gone[:, :2], gone[:, 2:4] - gone[:, :2]
    length = np.maximum(np.einsum("ij,ij->i", along, along), 1e-12)
    kept = []
    for place in found:
        away = np.array(place[:2]) - a
        share = np.clip(np.einsum("ij,ij->i", away, along) / length, 0.0, 1.0)
        far = np.linalg.norm(away - share[:, None] * along, axis=1)
        if not (far < WIDTH / 2).any():
            kept.append(place)
    return kept


def places(floor: Map) -> Iterator[Place]:
    """Yield the places of all windows of a map."""
    pieces = [anticlockwise(piece) for wall in floor.wall if wall.height >= HEAD for piece in wall_pieces(wall)]
    if is_outdoors(floor) or not floor.zone or sum(len(piece) for piece in pieces) > _MOST:
        return
    rooms = rooms_of(floor)
    tall = [[(c.x, c.y) for c in thing.corner] for thing in floor.obstacle if thing.top > SILL]
    for piece in pieces:
        for (ax, ay), (bx, by) in zip(piece, [*piece[1:], piece[0]], strict=True):
            length = math.hypot(bx - ax, by - ay)
            count = int(length / _PITCH)
            for index in range(count):
                share = (index + 0.5) / count
                at = (ax + share * (bx - ax), ay + share * (by - ay))
                heading = math.atan2(ax - bx, by - ay)
                thick = _thickness(piece, at, heading)
                if thick is not None and _is_free(at, heading, thick, rooms, pieces, tall):
                    yield at[0], at[1], heading, thick


def _thickness(piece: Sequence[Point], at: Point, heading: float) -> float | None:
    """Return how far a wall reaches behind a point of its face, in metres; None if half a metre or more."""
    dx, dy = math.cos(heading), math.sin(heading)
    steps = (step / 100 for step in range(2, 50, 2))
    return next((s for s in steps if not contains(piece, (at[0] - s * dx, at[1] - s * dy))), None)


def _is_free(
    at: Point, heading: float, thick: float, rooms: Rooms, pieces: Sequence[list[Point]], tall: Sequence[list[Point]]
) -> bool:
    """Return whether one room is before all of a window, and neither a room nor a wall behind it."""
    dx, dy = math.cos(heading), math.sin(heading)
    before = [
        (at[0] + 0.25 * dx - across * dy, at[1] + 0.25 * dy + across * dx)
        for across in (-WIDTH / 2 - 0.2, 0.0, WIDTH / 2 + 0.2)
    ]
    found = [rooms.at(*point) for point in before]
    if found[0] is None or any(zone is not found[0] for zone in found):
        return False
    if any(contains(thing, point) for thing in tall for point in before):
        return False
    behind = [(at[0] - far * dx, at[1] - far * dy) for far in (thick + 0.1, thick + 0.6)]
    return not any(rooms.at(*point) or any(contains(piece, point) for piece in pieces) for point in behind)
