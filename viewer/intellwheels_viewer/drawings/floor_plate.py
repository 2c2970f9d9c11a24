"""The floor: a plate, a grid of one metre, tinted rooms with their names, and marked doorways.

It is redrawn when the map changes. Nodes keep their names, and those that are no longer needed are hidden.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import viser

from intellwheels_maps.check import wall_pieces
from intellwheels_schemas.messages import Doorway, Map, Zone
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.lettering import written
from intellwheels_viewer.drawings.polygons import Point, anticlockwise, area, bounds
from intellwheels_viewer.drawings.solids import Solid, box, join, sheet

MARGIN: Final = 0.5
"""Metres by which the plate is larger than the map on each side."""

_LARGEST: Final = 0.46
_SMALLEST: Final = 0.16


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


def extent(floor: Map) -> tuple[float, float, float, float]:
    """Return the smallest and largest x, then y, of a map; for an empty map, ten metres around the origin."""
    points = [corner for wall in floor.wall for piece in wall_pieces(wall) for corner in piece]
    corners = [shape.corner for shape in floor.obstacle] + [zone.corner for zone in floor.zone]
    points += [(corner.x, corner.y) for each in corners for corner in each]
    if floor.grid is not None:
        points += [(place.x, place.y) for place in floor.grid.position]
    return bounds(points) if points else (-5.0, 5.0, -5.0, 5.0)


def plate(floor: Map) -> Solid:
    """Return the plate under the map, `MARGIN` larger than it, with its upper face at z = 0."""
    x0, x1, y0, y1 = extent(floor)
    return box(x0 - MARGIN, x1 + MARGIN, y0 - MARGIN, y1 + MARGIN, 0.0, 0.12).moved(0.0, 0.0, -0.12)


def grid(floor: Map) -> Solid:
    """Return thin lines at whole metres inside the map, or every five metres on maps of more than 60 m."""
    x0, x1, y0, y1 = extent(floor)
    step = 1 if max(x1 - x0, y1 - y0) <= 60.0 else 5
    half = 0.006 * step
    lines = [
        [(x - half, y0), (x + half, y0), (x + half, y1), (x - half, y1)]
        for x in range(math.ceil(x0 / step) * step, math.floor(x1) + 1, step)
    ]
    lines += [
        [(x0, y - half), (x1, y - half), (x1, y + half), (x0, y + half)]
        for y in range(math.ceil(y0 / step) * step, math.floor(y1) + 1, step)
    ]
    return join(sheet(line, floor_heights.GRID) for line in lines)


def tinted(zones: tuple[Zone, ...]) -> list[Solid]:
    """Return the areas of the zones, a solid for each tint of `palette.ZONES`. Neighbours in the map differ.

    Large zones are lowest, so that a zone inside another one is visible.
    """
    tints: list[list[Solid]] = [[] for _ in palette.ZONES]
    ordered = sorted(range(len(zones)), key=lambda index: -abs(area(_corners(zones[index]))))
    for rank, index in enumerate(ordered):
        lift = floor_heights.ZONE + 0.001 * min(rank / max(1, len(zones)), 1.0)
        tints[index % len(tints)].append(sheet(_corners(zones[index]), lift))
    return [join(each) for each in tints]


def _corners(zone: Zone) -> list[Point]:
    return anticlockwise([(corner.x, corner.y) for corner in zone.corner])


def titles(zones: tuple[Zone, ...]) -> list[Title]:
    """Return the names of all zones large enough for one, centred and as large as the zone allows."""
    made = []
    for zone in zones:
        x0, x1, y0, y1 = bounds(_corners(zone))
        across, along = sorted((x1 - x0, y1 - y0))
        upright = (x1 - x0) < 1.6 and along > 1.5 * across
        room = 0.8 * ((y1 - y0) if upright else (x1 - x0))
        height = min(_LARGEST, 0.16 * along, 0.4 * across)
        if height >= _SMALLEST:
            made.append(Title(zone.title or zone.name, (x0 + x1) / 2, (y0 + y1) / 2, height, upright, room))
    return made


def thresholds(doorways: tuple[Doorway, ...]) -> Solid:
    """Return a strip across each doorway, as wide as the doorway, with arrows in both directions of passage."""
    made = []
    for doorway in doorways:
        half = doorway.width / 2
        strip = [(-0.05, -half), (0.05, -half), (0.05, half), (-0.05, half)]
        sides = [[(s * 0.05, -0.12), (s * 0.17, 0.0), (s * 0.05, 0.12)] for s in (1, -1)]
        flat = join(sheet(polygon, floor_heights.DOORWAY) for polygon in (strip, *sides))
        made.append(flat.turned(math.radians(doorway.heading_deg)).moved(doorway.x, doorway.y))
    return join(made)


class Floor:
    """The floor in a scene."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._titles: list[viser.ImageHandle] = []
        self._meshes: dict[str, viser.MeshHandle] = {}

    def show(self, map: Map) -> None:  # noqa: A002  # the wire calls it so
        """Show another map."""
        self._mesh("/floor/plate", plate(map), palette.FLOOR)
        self._mesh("/floor/grid", grid(map), palette.GRID)
        for index, flat in enumerate(tinted(map.zone)):
            self._mesh(f"/floor/zones/{index}", flat, palette.ZONES[index])
        self._mesh("/floor/doorways", thresholds(map.doorway), palette.DOORWAY)
        self._name_rooms(titles(map.zone))

    def _mesh(self, name: str, shape: Solid, colour: palette.RGB) -> None:
        if not len(shape.faces):
            if name in self._meshes:
                self._meshes[name].visible = False
            return
        self._meshes[name] = self._scene.add_mesh_simple(
            name, shape.vertices, shape.faces, color=colour, cast_shadow=False, receive_shadow=0.2
        )

    def _name_rooms(self, made: list[Title]) -> None:
        for index, title in enumerate(made):
            picture = written(title.text, palette.LETTERS)
            length = title.height * picture.shape[1] / picture.shape[0]
            shrunk = min(1.0, title.room / length)
            # An image faces -z with y down; turned about x by half a turn it lies face up.
            half = math.pi / 4 if title.upright else 0.0
            handle = self._scene.add_image(
                f"/floor/names/{index}",
                picture,
                length * shrunk,
                title.height * shrunk,
                format="png",
                cast_shadow=False,
                receive_shadow=False,
                wxyz=np.array([0.0, math.cos(half), math.sin(half), 0.0]),
                position=(title.x, title.y, floor_heights.LETTERS),
            )
            self._titles[index : index + 1] = [handle]
        for handle in self._titles[len(made) :]:
            handle.visible = False
