"""The walls and obstacles of a map, extruded. Walls have dark caps, so that they stand out when seen from above.

A wall has a skirting board, a dado and a rail, as colours: nothing that could be driven against is added. It is
darker at the floor and under the ceiling. By default walls are cut at half height to show what is behind them. A
browser that shows full walls draws them under the same names in its own scene.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

import msgspec
import numpy as np
import viser

from intellwheels_maps.check import wall_pieces
from intellwheels_schemas.messages import Map
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.building_colours import BuildingColours, colours_of, dimmed
from intellwheels_viewer.drawings.cut_away import cut_away, pieces_of
from intellwheels_viewer.drawings.door_frames import fittings
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from intellwheels_viewer.drawings.furniture import Painted, furniture, merged
from intellwheels_viewer.drawings.glb import Surface, glb, painted
from intellwheels_viewer.drawings.polygons import Point, anticlockwise
from intellwheels_viewer.drawings.rooms import DETAILED, is_outdoors
from intellwheels_viewer.drawings.signs import signs
from intellwheels_viewer.drawings.solids import Solid, join, prism, solid
from intellwheels_viewer.drawings.windows import Place, beside, places, windows

_CAP: Final = 0.025
TALLER: Final = 0.25
"""Metres by which a cut obstacle is taller than cut walls."""
SKIRTING: Final = 0.09
DADO: Final = (0.90, 0.95)
"""Heights of the skirting board, and of the lower and upper edge of the rail, in metres."""
_EVERY: Final = 0.5
"""Distance between sample points on walls, in metres; a bed uses them to find the nearest wall."""

_Band = tuple[float, float, palette.RGB, palette.RGB]
"""Two heights, and the colour at each."""


def extruded(floor: Map, height: float | None) -> tuple[Solid, Solid]:
    """Return the sides and the caps of all walls.

    Args:
        floor: The map. A line with a thickness becomes a rectangle for each of its segments.
        height: Where walls are cut, in metres; None for full height. Walls that begin above are not drawn.
    """
    sides, caps = [], []
    for piece, bottom, top in _standing(floor, height):
        cap = min(_CAP, (top - bottom) / 2)
        sides.append(prism(piece, bottom, top - cap))
        caps.append(prism(piece, top - cap, top))
    return join(sides), join(caps)


def shaded(floor: Map, height: float | None, colours: BuildingColours) -> Surface:
    """Return all walls as one surface; the arguments are those of `extruded`."""
    plain = is_outdoors(floor) or sum(len(wall.corner) for wall in floor.wall) > DETAILED
    corners: list[tuple[float, float, float]] = []
    tints: list[palette.RGB] = []
    caps, lids = [], []
    for piece, bottom, top in _standing(floor, height):
        cap = min(_CAP, (top - bottom) / 2)
        caps.append(prism(piece, top - cap, top))
        if bottom > 0.0:
            lids.append(prism(piece, bottom, bottom + 0.01))
        ring = anticlockwise(piece)
        for z0, z1, low, high in bands(bottom, top - cap, colours, plain=plain):
            for (ax, ay), (bx, by) in zip(ring, [*ring[1:], ring[0]], strict=True):
                corners += [(ax, ay, z0), (bx, by, z0), (bx, by, z1), (ax, ay, z1)]
                tints += [low, low, high, high]
    first = np.arange(0, len(corners), 4)
    faces = np.concatenate([np.column_stack([first, first + k, first + k + 1]) for k in (1, 2)])
    ends = painted({colours.cap: join(caps), colours.wall: join(lids)})
    assert ends.colours is not None  # noqa: S101  # painted
    sides = solid(corners, faces)
    return Surface(sides + ends.solid, colours=np.concatenate([np.array(tints, np.uint8).reshape(-1, 3), ends.colours]))


def bands(bottom: float, top: float, colours: BuildingColours, *, plain: bool) -> list[_Band]:
    """Return the strips of a wall's side from bottom to top, with the colours at the edges of each.

    The shade at the floor and under the ceiling is baked in. A plain wall, as outdoors and on huge maps, is masonry.
    """
    if plain:
        return [(bottom, top, dimmed(colours.masonry, 0.78), colours.masonry)]
    dado, wall = colours.dado, colours.wall
    whole: list[_Band] = [
        (0.0, SKIRTING, dimmed(colours.skirting, 0.8), colours.skirting),
        (SKIRTING, 0.45, dimmed(dado, 0.82), dado),
        (0.45, DADO[0], dado, dado),
        (DADO[0], DADO[1], colours.rail, colours.rail),
        (DADO[1], 2.0, wall, wall),
        (2.0, max(top, 2.1), wall, dimmed(wall, 0.86)),
    ]
    if bottom > 0.0:
        return [(bottom, top, wall, dimmed(wall, 0.9))]
    kept = [(z0, min(z1, top), low, high) for z0, z1, low, high in whole if z0 < top]
    return [(z0, z1, low, high) for z0, z1, low, high in kept if z1 > z0]


def _standing(floor: Map, height: float | None) -> Iterator[tuple[list[Point], float, float]]:
    """Yield the polygons of the walls with their lower and upper edges, those of the cut ones at the cut."""
    for wall in floor.wall:
        top = wall.height if height is None else min(wall.height, height)
        if wall.bottom < top:
            yield from ((piece, wall.bottom, top) for piece in wall_pieces(wall))


def obstacles(floor: Map, height: float | None) -> Painted:
    """Return all obstacles by colour. Tall ones are cut slightly higher than walls, so that they can be told apart."""
    walls = list(_wall_points(floor))
    made: dict[palette.RGB, list[Solid]] = {}
    for obstacle in floor.obstacle:
        top = obstacle.top if height is None else min(obstacle.top, height + TALLER)
        if obstacle.bottom >= top:
            continue
        for colour, thing in furniture(msgspec.structs.replace(obstacle, top=top), walls).items():
            made.setdefault(colour, []).append(thing)
    return {colour: join(solids) for colour, solids in sorted(made.items())}


def _wall_points(floor: Map) -> Iterator[Point]:
    for wall in floor.wall:
        for piece in wall_pieces(wall):
            for (ax, ay), (bx, by) in zip(piece, [*piece[1:], piece[0]], strict=True):
                steps = max(1, math.ceil(math.hypot(bx - ax, by - ay) / _EVERY))
                yield from ((ax + (bx - ax) * k / steps, ay + (by - ay) * k / steps) for k in range(steps))


class Walls:
    """Walls with their doors' frames, windows and signs, and obstacles, in a scene.

    Args:
        scene: The shared scene, or that of one browser.
        dark: Whether they have the colours of the dark theme; it may change before `show`.
    """

    def __init__(self, scene: viser.SceneApi, *, dark: bool = False) -> None:
        self._scene = scene
        self.dark = dark
        self._nodes: dict[str, viser.GlbHandle] = {}
        self._shown: tuple[Map, float | None, bool] | None = None
        self._windows: list[Place] = []
        self._glazed: list[Place] = []

    def show(
        self,
        map: Map,  # noqa: A002  # the wire calls it so
        height: float | None = HALF_HEIGHT,
        parts: frozenset[int] = frozenset(),
    ) -> None:
        """Show another map, or cut other parts of its walls away.

        Args:
            map: The map.
            height: Where its walls are cut, in metres; None for full height.
            parts: Parts of walls that are cut away, see `cut_away`.
        """
        colours, before, wanted = colours_of(dark=self.dark), self._shown, (map, height, self.dark)
        is_other = before is None or before[0] is not map or before[1:] != wanted[1:]
        self._shown = wanted
        self._show("/walls/sides", [shaded(cut_away(map, parts), height, colours)], shadows=False)
        if before is None or before[0] is not map:
            self._windows = list(places(map))
        glazed = beside(self._windows, pieces_of(map)[sorted(parts)]) if parts else self._windows
        if is_other or glazed != self._glazed:
            self._glazed = glazed
            self._show("/walls/windows", [painted(windows(glazed, height, colours))], shadows=False)
        if not is_other:
            return
        self._show("/walls/frames", [painted(fittings(map, height, colours))], shadows=False)
        self._show("/walls/signs", signs(map, colours) if height is None else (), shadows=False)
        share = colours.furniture
        things = [({dimmed(rgb, share): thing}) for rgb, thing in obstacles(map, height).items()]
        self._show("/obstacles", [painted(merged(*things))], shadows=True)

    def _show(self, name: str, made: Sequence[Surface], *, shadows: bool) -> None:
        if any(len(surface.solid.faces) for surface in made):
            self._nodes[name] = self._scene.add_glb(name, glb(made), cast_shadow=shadows, receive_shadow=False)
        elif name in self._nodes:
            self._nodes[name].visible = False
