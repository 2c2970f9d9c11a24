"""What a map says about its rooms: the material of each floor, and where the building ends. Pure.

A map names its zones and says no more, so the material follows from the words of the name and of the title.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from intellwheels_maps.check import wall_pieces
from intellwheels_maps.plane_geometry import contains, is_within
from intellwheels_schemas.messages import Doorway, Map, Zone
from intellwheels_viewer.drawings.building_colours import Material
from intellwheels_viewer.drawings.polygons import Point, anticlockwise, area, bounds

_WORDS: Final[tuple[tuple[str, Material], ...]] = (
    (r"crossing|zebra|street|road|carriageway|lane", "asphalt"),
    (r"pavement|sidewalk|footpath|yard|garden|terrace|court", "paving"),
    (r"bath|toilet|wc\b|shower|wash|kitchen|laundry|sluice", "small-tiles"),
    (r"corridor|hall|lobby|anteroom|entrance|lift|store|stair", "tiles"),
    (r"day|lounge|living|office|nurse|staff|waiting|meeting|reception", "carpet"),
    (r"room|bed|bay|ward", "wood"),
)
_STREET: Final = re.compile(r"street|road|carriageway|lane")
_CROSSING: Final = re.compile(r"crossing|zebra")
_COVERED: Final = 0.5
"""The share of a map that its zones cover at least if the building is where they are."""


def corners_of(zone: Zone) -> list[Point]:
    """Return the corners of a zone, anticlockwise, in metres."""
    return anticlockwise([(corner.x, corner.y) for corner in zone.corner])


def _name(zone: Zone) -> str:
    return f"{zone.name} {zone.title or ''}".lower()


def material_of(zone: Zone) -> Material:
    """Return the material of a zone's floor; tiles if its name says nothing."""
    return next((material for words, material in _WORDS if re.search(words, _name(zone))), "tiles")


def is_crossing(zone: Zone) -> bool:
    """Return whether a zone is where people cross a street."""
    return _CROSSING.search(_name(zone)) is not None


def is_street(zone: Zone) -> bool:
    """Return whether a zone is a carriageway."""
    return not is_crossing(zone) and _STREET.search(_name(zone)) is not None


def is_outdoors(floor: Map) -> bool:
    """Return whether a map is a street rather than a building."""
    return any(is_street(zone) for zone in floor.zone)


def extent(floor: Map) -> tuple[float, float, float, float]:
    """Return the smallest and largest x, then y, of a map; for an empty map, ten metres around the origin."""
    points = [corner for wall in floor.wall for piece in wall_pieces(wall) for corner in piece]
    corners = [shape.corner for shape in floor.obstacle] + [zone.corner for zone in floor.zone]
    points += [(corner.x, corner.y) for each in corners for corner in each]
    if floor.grid is not None:
        points += [(place.x, place.y) for place in floor.grid.position]
    return bounds(points) if points else (-5.0, 5.0, -5.0, 5.0)


def grounds(floor: Map) -> list[list[Point]]:
    """Return the polygons of the floor that no zone needs to cover: what is between zones, or all of the map.

    They are the whole rectangle of the map, unless its zones cover most of it. Then the building is where the zones
    are, and only its doorways are added.
    """
    x0, x1, y0, y1 = extent(floor)
    covered = sum(area(corners_of(zone)) for zone in floor.zone)
    if is_outdoors(floor) or covered < _COVERED * (x1 - x0) * (y1 - y0):
        return [[(x0, y0), (x1, y0), (x1, y1), (x0, y1)]]
    return [passage(floor, doorway) for doorway in floor.doorway]


def passage(floor: Map, doorway: Doorway) -> list[Point]:
    """Return the rectangle of a doorway, as deep as the walls beside it."""
    back, front = depth_of(floor, doorway)
    half, heading = doorway.width / 2, math.radians(doorway.heading_deg)
    ahead, left = (math.cos(heading), math.sin(heading)), (-math.sin(heading), math.cos(heading))
    return [
        (doorway.x + along * ahead[0] + across * left[0], doorway.y + along * ahead[1] + across * left[1])
        for along, across in ((back, -half), (front, -half), (front, half), (back, half))
    ]


_FAR: Final = 60
"""Centimetres up to which a wall beside a doorway is looked for along its heading."""
DETAILED: Final = 4000
"""Corners of walls up to which a map is drawn in detail: more would take seconds, and megabytes of a page."""
_USUAL: Final = 0.05
"""Half the thickness of a wall, in metres, where the map has none beside a doorway."""


def depth_of(floor: Map, doorway: Doorway) -> tuple[float, float]:
    """Return where the walls beside a doorway begin and end along its heading, in metres from its centre."""
    heading = math.radians(doorway.heading_deg)
    ahead, left = (math.cos(heading), math.sin(heading)), (-math.sin(heading), math.cos(heading))
    pieces = pieces_near(floor, (doorway.x, doorway.y), doorway.width)
    if sum(len(piece) for piece in pieces) > DETAILED:
        return -_USUAL, _USUAL
    for side in (1, -1):
        across = side * (doorway.width / 2 + 0.04)
        x, y = doorway.x + across * left[0], doorway.y + across * left[1]
        inside = [
            step / 100
            for step in range(-_FAR, _FAR + 1)
            if any(contains(piece, (x + step / 100 * ahead[0], y + step / 100 * ahead[1])) for piece in pieces)
        ]
        # A wall that goes on along the heading says nothing about the thickness here.
        if inside and inside[-1] - inside[0] < 2 * _FAR / 100 - 0.02:
            return inside[0] - 0.005, inside[-1] + 0.005
    return -_USUAL, _USUAL


def pieces_near(floor: Map, at: Point, reach: float) -> list[list[Point]]:
    """Return the polygons of the walls whose boxes come as near to a point, in metres."""
    pieces = (piece for wall in floor.wall if wall.bottom <= 0.0 for piece in wall_pieces(wall))
    return [piece for piece in pieces if is_within(bounds(piece), at, reach)]


@dataclass(frozen=True)
class Rooms:
    """The zones of a map, to look a point up."""

    zones: Sequence[Zone]
    rings: Sequence[list[Point]]

    def at(self, x: float, y: float) -> Zone | None:
        """Return the zone at a point, the first one where two overlap."""
        return next((z for z, ring in zip(self.zones, self.rings, strict=True) if contains(ring, (x, y))), None)


def rooms_of(floor: Map) -> Rooms:
    """Return the zones of a map."""
    return Rooms(floor.zone, [corners_of(zone) for zone in floor.zone])
