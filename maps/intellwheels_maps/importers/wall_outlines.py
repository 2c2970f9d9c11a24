"""Turns areas with holes into outlines without holes, as walls of a map are. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from intellwheels_maps.crossing import Point


def outlines(area: Any) -> Iterator[list[Point]]:
    """Yield the outlines of pieces without holes that together are an area.

    An area with holes is cut through the middle of its holes, along y. Equal areas give equal pieces.

    Args:
        area: Any geometry of shapely. Points and lines in it have no area and are dropped.
    """
    import shapely  # noqa: PLC0415 - of an extra

    waiting = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon"]
    while waiting:
        polygon = waiting.pop()
        if polygon.is_empty:
            continue
        if not polygon.interiors:
            yield [(float(x), float(y)) for x, y in polygon.exterior.coords[:-1]]
            continue
        middles = sorted((hole.bounds[0] + hole.bounds[2]) / 2 for hole in polygon.interiors)
        cut = middles[len(middles) // 2]
        west, south, east, north = polygon.bounds
        for side in ((west - 1, south - 1, cut, north + 1), (cut, south - 1, east + 1, north + 1)):
            parts = shapely.get_parts(shapely.intersection(polygon, shapely.box(*side)))
            waiting += [part for part in parts if part.geom_type == "Polygon"]
