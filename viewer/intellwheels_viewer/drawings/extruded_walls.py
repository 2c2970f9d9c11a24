"""The walls and obstacles of a map, extruded. Walls have dark caps, so that they stand out when seen from above.

By default walls are cut at half height to show what is behind them. A browser that shows full walls draws them under
the same names in its own scene.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import msgspec
import viser

from intellwheels_maps.check import wall_pieces
from intellwheels_schemas.agent_colours import css
from intellwheels_schemas.messages import Map
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from intellwheels_viewer.drawings.furniture import Painted, furniture
from intellwheels_viewer.drawings.polygons import Point
from intellwheels_viewer.drawings.solids import Solid, join, prism

_CAP: Final = 0.025
TALLER: Final = 0.25
"""Metres by which a cut obstacle is taller than cut walls."""
_EVERY: Final = 0.5
"""Distance between sample points on walls, in metres; a bed uses them to find the nearest wall."""


def extruded(floor: Map, height: float | None) -> tuple[Solid, Solid]:
    """Return the sides and the caps of all walls.

    Args:
        floor: The map. A line with a thickness becomes a rectangle for each of its segments.
        height: Where walls are cut, in metres; None for full height. Walls that begin above are not drawn.
    """
    sides, caps = [], []
    for wall in floor.wall:
        top = wall.height if height is None else min(wall.height, height)
        if wall.bottom >= top:
            continue
        cap = min(_CAP, (top - wall.bottom) / 2)
        for piece in wall_pieces(wall):
            sides.append(prism(piece, wall.bottom, top - cap))
            caps.append(prism(piece, top - cap, top))
    return join(sides), join(caps)


def obstacles(floor: Map, height: float | None) -> Painted:
    """Return all obstacles by colour. Tall ones are cut slightly higher than walls, so that they can be told apart."""
    walls = list(_wall_points(floor))
    made: dict[palette.RGB, list[Solid]] = {}
    for obstacle in floor.obstacle:
        top = obstacle.top if height is None else min(obstacle.top, height + TALLER)
        if obstacle.bottom >= top:
            continue
        for colour, solid in furniture(msgspec.structs.replace(obstacle, top=top), walls).items():
            made.setdefault(colour, []).append(solid)
    return {colour: join(solids) for colour, solids in sorted(made.items())}


def _wall_points(floor: Map) -> Iterator[Point]:
    for wall in floor.wall:
        for piece in wall_pieces(wall):
            for (ax, ay), (bx, by) in zip(piece, [*piece[1:], piece[0]], strict=True):
                steps = max(1, math.ceil(math.hypot(bx - ax, by - ay) / _EVERY))
                yield from ((ax + (bx - ax) * k / steps, ay + (by - ay) * k / steps) for k in range(steps))


class Walls:
    """Walls and obstacles in a scene."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._nodes: dict[str, viser.MeshHandle] = {}

    def show(self, map: Map, height: float | None = HALF_HEIGHT) -> None:  # noqa: A002  # the wire calls it so
        """Show another map, its walls cut at a height in metres; None for full height."""
        sides, caps = extruded(map, height)
        made = {"/walls/sides": (sides, palette.WALL), "/walls/caps": (caps, palette.CAP)}
        for colour, solid in obstacles(map, height).items():
            made["/obstacles/" + css(colour)[1:]] = (solid, colour)
        for name, node in self._nodes.items():
            if name not in made:
                node.visible = False
        for name, (solid, colour) in made.items():
            if len(solid.faces):
                self._nodes[name] = self._scene.add_mesh_simple(
                    name,
                    solid.vertices,
                    solid.faces,
                    color=colour,
                    cast_shadow=name.startswith("/obstacles"),
                    receive_shadow=False,
                )
            elif name in self._nodes:
                self._nodes[name].visible = False
