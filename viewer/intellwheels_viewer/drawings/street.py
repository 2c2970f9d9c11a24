"""What is painted on a street: kerbs, the line in the middle, and the bars of a crossing. Pure.

All is flat, because a map has no kerb that a wheel could climb.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from intellwheels_schemas.messages import Map, Zone
from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.furniture import rectangle
from intellwheels_viewer.drawings.polygons import Point
from intellwheels_viewer.drawings.rooms import corners_of, is_crossing, is_street
from intellwheels_viewer.drawings.solids import Solid, join, sheet

BAR: Final = 0.5
"""Width of a bar of a crossing and of the gap beside it, in metres."""
_KERB: Final = 0.16
_LINE: Final = 0.12
_DASH: Final = 2.0


def kerbs(floor: Map) -> Solid:
    """Return a strip along both long edges of each street, interrupted at crossings."""
    made = []
    for zone, (x, y, length, width, heading) in _streets(floor):
        for start, end in _clear(floor, zone, heading, (x, y), length):
            for side in (1, -1):
                edge = side * (width / 2 - _KERB / 2)
                made.append(_strip(start, end, edge, _KERB).turned(heading).moved(x, y))
    return join(made)


def lines(floor: Map) -> Solid:
    """Return the dashes in the middle of each street, and the bars of each crossing along the street under it."""
    made = []
    for zone, (x, y, length, _, heading) in _streets(floor):
        for start, end in _clear(floor, zone, heading, (x, y), length):
            count = max(1, round((end - start) / (2 * _DASH)))
            pitch = (end - start) / count
            for index in range(count):
                middle = start + (index + 0.5) * pitch
                made.append(_strip(middle - pitch / 4, middle + pitch / 4, 0.0, _LINE).turned(heading).moved(x, y))
    made += [bars(zone, _heading_at(floor, zone)) for zone in floor.zone if is_crossing(zone)]
    return join(made)


def bars(zone: Zone, heading: float) -> Solid:
    """Return the bars of a crossing, parallel to the traffic.

    Args:
        zone: The crossing.
        heading: Of the traffic, in radians.
    """
    (start, end), (right, left) = _span(corners_of(zone), heading)
    count = max(1, math.floor((left - right) / BAR + 1e-6) // 2)
    first = (left + right) / 2 - (count - 1) * BAR
    return join(_strip(start + 0.1, end - 0.1, first + 2 * BAR * index, BAR) for index in range(count)).turned(heading)


def _streets(floor: Map) -> list[tuple[Zone, tuple[float, float, float, float, float]]]:
    """Return the rectangular streets with their centre, length, width and heading."""
    frames = [(zone, rectangle(corners_of(zone))) for zone in floor.zone if is_street(zone)]
    return [(zone, frame) for zone, frame in frames if frame is not None]


def _heading_at(floor: Map, crossing: Zone) -> float:
    """Return the heading of the street that a crossing lies on; along x if there is none."""
    xs, ys = zip(*corners_of(crossing), strict=True)
    x, y = sum(xs) / len(xs), sum(ys) / len(ys)
    for _, (sx, sy, length, width, heading) in _streets(floor):
        along = (x - sx) * math.cos(heading) + (y - sy) * math.sin(heading)
        across = (y - sy) * math.cos(heading) - (x - sx) * math.sin(heading)
        if abs(along) <= length / 2 and abs(across) <= width / 2:
            return heading
    return 0.0


def _clear(floor: Map, street: Zone, heading: float, middle: Point, length: float) -> list[tuple[float, float]]:
    """Return the parts of a street that no crossing covers, along it from its middle, in metres."""
    offset = middle[0] * math.cos(heading) + middle[1] * math.sin(heading)
    holes = sorted(_span(corners_of(zone), heading)[0] for zone in floor.zone if is_crossing(zone))
    parts, at = [], -length / 2
    for start, end in holes:
        if start - offset > at:
            parts.append((at, min(start - offset, length / 2)))
        at = max(at, end - offset)
    if at < length / 2:
        parts.append((at, length / 2))
    return [(start, end) for start, end in parts if end - start > 1e-6 and street.corner]


def _span(corners: Sequence[Point], heading: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the range of corners along a heading and to its left."""
    along = [x * math.cos(heading) + y * math.sin(heading) for x, y in corners]
    across = [y * math.cos(heading) - x * math.sin(heading) for x, y in corners]
    return (min(along), max(along)), (min(across), max(across))


def _strip(start: float, end: float, y: float, width: float) -> Solid:
    half = width / 2
    return sheet([(start, y - half), (end, y - half), (end, y + half), (start, y + half)], floor_heights.PAINT)
