"""Converts between the frame of a map and the coordinates of its site. Pure.

In metres, both differ by the `Offset` of the map. With EPSG:4326 the site has longitude and latitude in degrees, and a
small map is a plane that touches the ellipsoid at its origin: at latitude f, a degree of longitude is
pi / 180 a cos f / sqrt(1 - e2 sin2 f), and a degree of latitude pi / 180 a (1 - e2) / (1 - e2 sin2 f)^1.5. The error
grows with the square of the distance; 1 km from the origin, at 60 degrees, it is 0.2 m.

Source:
    a and e2 of WGS 84: NIMA TR8350.2, third edition, table 3.1 and 3.3.
"""

from __future__ import annotations

import math
from typing import Final

from intellwheels_maps.crossing import Point
from intellwheels_schemas.messages import Map

DEGREES: Final = "EPSG:4326"
"""The coordinate reference system whose coordinates are longitude and latitude."""

_A: Final = 6_378_137.0
_E2: Final = 6.694_379_990_14e-3


def to_site(document: Map, at: Point) -> Point:
    """Return a point of the map, m, in the coordinates of the site."""
    if document.offset is None:
        return at
    origin = (document.offset.x, document.offset.y)
    scale = degree_lengths(origin[1]) if document.offset.epsg == DEGREES else (1.0, 1.0)
    return origin[0] + at[0] / scale[0], origin[1] + at[1] / scale[1]


def from_site(document: Map, at: Point) -> Point:
    """Return a point in the coordinates of the site in the frame of the map, m."""
    if document.offset is None:
        return at
    origin = (document.offset.x, document.offset.y)
    scale = degree_lengths(origin[1]) if document.offset.epsg == DEGREES else (1.0, 1.0)
    return (at[0] - origin[0]) * scale[0], (at[1] - origin[1]) * scale[1]


def degree_lengths(latitude: float) -> Point:
    """Return the lengths of a degree of longitude and of latitude, m.

    Args:
        latitude: Degrees, in (-90, 90).
    """
    sine = math.sin(math.radians(latitude))
    flat = 1.0 - _E2 * sine * sine
    per_degree = math.pi / 180.0 * _A
    return per_degree * math.cos(math.radians(latitude)) / math.sqrt(flat), per_degree * (1.0 - _E2) / flat**1.5
