"""The floor: rooms of their materials with their names, doorways, streets, shade at the walls, and the ground outside.

It is redrawn when the map changes. Nodes keep their names, and those that are no longer needed are hidden.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import viser

from intellwheels_maps.check import wall_pieces
from intellwheels_schemas.messages import Map, Zone
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import floor_heights, street, textures
from intellwheels_viewer.drawings.building_colours import BuildingColours, Material, colours_of
from intellwheels_viewer.drawings.glb import Surface, glb, painted
from intellwheels_viewer.drawings.lettering import atlas
from intellwheels_viewer.drawings.polygons import anticlockwise, area, bounds
from intellwheels_viewer.drawings.rooms import corners_of, extent, grounds, is_outdoors, material_of, passage
from intellwheels_viewer.drawings.solids import Solid, box, join, sheet, solid

MARGIN: Final = 0.5
"""Metres by which the plate is larger than the map on each side."""
BELOW: Final = 0.01
"""Metres by which the ground outside is lower than the floor."""

_LARGEST: Final = 0.46
_SMALLEST: Final = 0.16
_SHADE: Final = 0.45
"""Width of the shade at the foot of a wall, in metres."""
_SHADE_OF_THINGS: Final = 0.22


@dataclass(frozen=True)
class Title:
    """A name on the floor.

    Attributes:
        text: The name.
        x, y: Its centre, in metres.
        height: Height of the line, in metres.
        upright: Whether it runs along y, because the room is long and narrow in that direction.
        room: Maximum length, in metres.
    """

    text: str
    x: float
    y: float
    height: float
    upright: bool
    room: float


def plate(floor: Map) -> Solid:
    """Return the ground under the map, `MARGIN` larger than it, with its upper face a little below the floor."""
    x0, x1, y0, y1 = extent(floor)
    return box(x0 - MARGIN, x1 + MARGIN, y0 - MARGIN, y1 + MARGIN, 0.0, 0.12).moved(0.0, 0.0, -0.12 - BELOW)


def titles(zones: tuple[Zone, ...]) -> list[Title]:
    """Return the names of all zones large enough for one, centred and as large as the zone allows."""
    made = []
    for zone in zones:
        x0, x1, y0, y1 = bounds(corners_of(zone))
        across, along = sorted((x1 - x0, y1 - y0))
        upright = (x1 - x0) < 1.6 and along > 1.5 * across
        room = 0.8 * ((y1 - y0) if upright else (x1 - x0))
        height = min(_LARGEST, 0.16 * along, 0.4 * across)
        if height >= _SMALLEST:
            made.append(Title(zone.title or zone.name, (x0 + x1) / 2, (y0 + y1) / 2, height, upright, room))
    return made


def materials(floor: Map) -> dict[Material, Solid]:
    """Return the floor by material.

    Large zones are lowest, so that a zone inside another one is visible; what no zone covers is lowest of all.
    """
    base: Material = "paving" if is_outdoors(floor) else "tiles"
    made: dict[Material, list[Solid]] = {base: [sheet(polygon, floor_heights.FLOOR) for polygon in grounds(floor)]}
    ordered = sorted(floor.zone, key=lambda zone: -abs(area(corners_of(zone))))
    for rank, zone in enumerate(ordered):
        lift = floor_heights.ZONE + 0.001 * rank / max(1, len(ordered))
        made.setdefault(material_of(zone), []).append(sheet(corners_of(zone), lift))
    return {material: join(sheets) for material, sheets in made.items()}


def surfaces(floor: Map, colours: BuildingColours) -> list[Surface]:
    """Return the floor as a surface for each material, its picture in metres from the origin of the map."""
    return [
        Surface(
            flat,
            colours.floors[material],
            uv=flat.vertices[:, :2] * np.float32(1.0 / textures.METRES[material]),
            picture=textures.picture(material),
        )
        for material, flat in materials(floor).items()
    ]


def thresholds(floor: Map) -> Solid:
    """Return a strip across each doorway, as wide as the doorway and as deep as the walls beside it."""
    return join(sheet(passage(floor, doorway), floor_heights.DOORWAY) for doorway in floor.doorway)


def shade(floor: Map, opacity: int) -> Surface:
    """Return the shade on the floor at the feet of walls and obstacles, which fades away from them.

    Args:
        floor: The map.
        opacity: At the wall, in [0, 255].
    """
    rings = [(piece, _SHADE) for wall in floor.wall if wall.bottom <= 0.0 for piece in wall_pieces(wall)]
    things = [thing for thing in floor.obstacle if thing.bottom < 0.1 and "leg" not in thing.name.lower()]
    rings += [([(corner.x, corner.y) for corner in thing.corner], _SHADE_OF_THINGS) for thing in things]
    corners: list[tuple[float, float, float]] = []
    for ring, wide in rings:
        points = anticlockwise(ring)
        for (ax, ay), (bx, by) in zip(points, [*points[1:], points[0]], strict=True):
            length = math.hypot(bx - ax, by - ay)
            if length > 0.15:
                nx, ny = (by - ay) / length * wide, (ax - bx) / length * wide
                flat = ((ax, ay), (ax + nx, ay + ny), (bx + nx, by + ny), (bx, by))
                corners += [(x, y, floor_heights.SHADE) for x, y in flat]
    first = np.arange(0, len(corners), 4)
    faces = np.concatenate([np.column_stack([first, first + k, first + k + 1]) for k in (1, 2)])
    dark = np.zeros((len(corners), 4), np.uint8)
    dark[0::4, 3] = dark[3::4, 3] = opacity
    return Surface(solid(corners, faces), colours=dark, blend=True)


def names(made: Sequence[Title], rgb: palette.RGB) -> Surface:
    """Return the names of rooms, flat on the floor."""
    if not made:
        return Surface(Solid())
    picture, lines = atlas(tuple(title.text for title in made), rgb)
    corners, uv = [], []
    for title, line in zip(made, lines, strict=True):
        length = title.height * line.aspect
        shrunk = min(1.0, title.room / length)
        along, up = ((0.0, 1.0), (-1.0, 0.0)) if title.upright else ((1.0, 0.0), (0.0, 1.0))
        for right, above in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            a, b = right * shrunk * length / 2, above * shrunk * title.height / 2
            at = (title.x + a * along[0] + b * up[0], title.y + a * along[1] + b * up[1], floor_heights.LETTERS)
            corners.append(at)
            uv.append((line.right if right > 0 else 0.0, line.top if above > 0 else line.bottom))
    first = np.arange(0, len(corners), 4)
    faces = np.concatenate([np.column_stack([first, first + k, first + k + 1]) for k in (1, 2)])
    return Surface(solid(corners, faces), uv=np.array(uv, np.float32), picture=picture, blend=True)


class Floor:
    """The floor in a scene.

    Args:
        scene: The shared scene, or that of one browser.
        dark: Whether it has the colours of the dark theme; it may change before `show`.
    """

    def __init__(self, scene: viser.SceneApi, *, dark: bool = False) -> None:
        self._scene = scene
        self.dark = dark
        self._nodes: dict[str, viser.MeshHandle | viser.GlbHandle] = {}

    def show(self, map: Map) -> None:  # noqa: A002  # the wire calls it so
        """Show another map."""
        colours = colours_of(dark=self.dark)
        under = plate(map)
        self._nodes["/floor/plate"] = self._scene.add_mesh_simple(
            "/floor/plate", under.vertices, under.faces, color=colours.outside, cast_shadow=False, receive_shadow=0.2
        )
        self._show("/floor/rooms", surfaces(map, colours), receive_shadow=0.2)
        marks = {colours.frame: thresholds(map), colours.kerb: street.kerbs(map), colours.road_line: street.lines(map)}
        self._show("/floor/marks", [painted(marks)])
        self._show("/floor/shade", [shade(map, colours.shade)])
        self._show("/floor/names", [names(titles(map.zone), colours.letters)])

    def _show(self, name: str, made: Sequence[Surface], receive_shadow: float = 0.0) -> None:
        if any(len(surface.solid.faces) for surface in made):
            self._nodes[name] = self._scene.add_glb(
                name, glb(made), cast_shadow=False, receive_shadow=receive_shadow or False
            )
        elif name in self._nodes:
            self._nodes[name].visible = False
