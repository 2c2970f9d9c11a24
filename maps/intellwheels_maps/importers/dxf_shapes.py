"""Flattens the entities of a DXF drawing into lines, blocks expanded, within bounds. Pure."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, Final, NamedTuple

from intellwheels_maps.crossing import Point
from intellwheels_maps.importers.floor_source import FloorSource
from intellwheels_schemas.explain import shown

SAGITTA: Final = 0.005
"""Farthest that a line is from the curve that it stands for, m."""

MAX_SHAPES: Final = 50_000
"""Most entities of a drawing after its blocks are expanded."""

MAX_DEPTH: Final = 16
"""Deepest nesting of blocks."""

_CURVES: Final = {"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "SOLID", "TRACE"}


class Arc(NamedTuple):
    """A part of a circle: its middle and radius in m, and how far it goes round, anticlockwise, in degrees."""

    middle: Point
    radius: float
    sweep: float


class Shape(NamedTuple):
    """A line.

    Attributes:
        points: Its corners, m; of an arc, anticlockwise.
        closed: Whether the last corner is connected to the first.
        width: Its width, m; 0 if it has none.
        arc: The arc that it stands for, or None.
    """

    points: list[Point]
    closed: bool = False
    width: float = 0.0
    arc: Arc | None = None


class ShapeReader:
    """Reads entities.

    Args:
        source: The file, for errors.
        document: The drawing.
        scale: Metres in a unit of the drawing.
    """

    def __init__(self, source: FloorSource, document: Any, scale: float) -> None:
        self._source = source
        self._document = document
        self._scale = scale
        self._left = MAX_SHAPES

    def shapes(self, entity: Any) -> list[Shape]:
        """Return the lines of an entity; none for one that has none, such as a text.

        Raises:
            WireError: The drawing has too many entities, or its blocks contain themselves.
        """
        return self._expanded(entity, ())

    def _expanded(self, entity: Any, inside: tuple[str, ...]) -> list[Shape]:
        where = f"{entity.dxftype()} {entity.dxf.handle or 'of a block'}"
        self._left -= 1
        if self._left < 0:
            text = f"expected at most {MAX_SHAPES:,} entities, blocks expanded, got more"
            raise self._source.error(where, text, "too-many")
        if entity.dxftype() == "INSERT":
            return self._block(entity, inside, where)
        if entity.dxftype() not in _CURVES:
            return []
        try:
            found = self._curve(entity)
        except (ValueError, TypeError, ZeroDivisionError, OverflowError, AttributeError, ArithmeticError):
            return []  # an ellipse without an axis, a spline without points
        for shape in found:
            if not all(math.isfinite(x) and math.isfinite(y) for x, y in shape.points):
                raise self._source.error(where, "expected finite coordinates, got others")
        return [shape for shape in found if shape.points]

    def _block(self, insert: Any, inside: tuple[str, ...], where: str) -> list[Shape]:
        name = str(insert.dxf.name)
        if name in inside:
            raise self._source.error(
                where, f"expected blocks that do not contain themselves, got {shown(name)} in itself"
            )
        if len(inside) >= MAX_DEPTH:
            raise self._source.error(where, f"expected at most {MAX_DEPTH} blocks in one another, got more", "too-many")
        if insert.mcount > self._left:
            text = f"expected at most {MAX_SHAPES:,} entities, blocks expanded, got {insert.mcount:,} copies of a block"
            raise self._source.error(where, text, "too-many")
        if name not in self._document.blocks:
            raise self._source.error(where, f"expected a block of the drawing, got {shown(name)}")
        found = []
        for copy in insert.multi_insert() if insert.mcount > 1 else (insert,):
            for part in copy.virtual_entities():
                found += self._expanded(part, (*inside, name))
        return found

    def _curve(self, entity: Any) -> list[Shape]:
        from ezdxf.path import make_path  # noqa: PLC0415 - of an extra

        kind = entity.dxftype()
        if kind in {"SOLID", "TRACE"}:
            return [Shape([self._point(vertex) for vertex in entity.wcs_vertices()], closed=True)]
        path = make_path(entity)
        points = [self._point(vertex) for vertex in path.flattening(SAGITTA / self._scale, segments=4)]
        if not points:
            return []
        closed = kind == "CIRCLE" or bool(getattr(entity, "is_closed", False) or getattr(entity, "closed", False))
        if len(points) > 2 and math.dist(points[0], points[-1]) < 1e-6:
            points, closed = points[:-1], True
        width = 0.0
        if kind == "LWPOLYLINE":
            width = float(entity.dxf.get("const_width", 0.0) or 0.0) * self._scale
        return [Shape(points, closed, width, None if closed else self._arc(entity, points))]

    def _arc(self, entity: Any, points: list[Point]) -> Arc | None:
        kind = entity.dxftype()
        if kind == "LWPOLYLINE" and len(entity) == 2:
            return self._bulge(entity)
        if kind == "ARC" or (kind == "ELLIPSE" and abs(abs(entity.dxf.ratio) - 1.0) < 0.01):
            middle = self._point(entity.ocs().to_wcs(entity.dxf.center) if kind == "ARC" else entity.dxf.center)
            radius = math.dist(middle, points[0])
            turns = [math.atan2(y - middle[1], x - middle[0]) for x, y in points]
            sweep = math.fsum(math.remainder(b - a, math.tau) for a, b in pairwise(turns))
            if sweep < 0.0:
                points.reverse()
            return Arc(middle, radius, math.degrees(abs(sweep)))
        return None

    def _bulge(self, line: Any) -> Arc | None:
        """Return the arc of a polyline of one piece, or None if it is straight."""
        from ezdxf.math import bulge_to_arc  # noqa: PLC0415 - of an extra

        (x0, y0, bulge), (x1, y1, _) = line.get_points("xyb")
        if bulge == 0.0:
            return None
        middle, start, end, radius = bulge_to_arc((x0, y0), (x1, y1), bulge)
        sweep = math.degrees((end - start) % math.tau)
        return Arc(self._point(line.ocs().to_wcs((*middle, 0.0))), radius * self._scale, sweep)

    def _point(self, vertex: Any) -> Point:
        return float(vertex[0]) * self._scale, float(vertex[1]) * self._scale
