"""Imports floors in GeoJSON. Pure.

A property tells what a feature is: `type`, `indoor`, `feature_type`, `category` or `class`, in this order. Walls and
windows are walls. Doors are doorways: a polygon lies in its opening, and a line goes from jamb to jamb. Rooms, stairs
and lifts are zones. Furniture with a `height` in metres is an obstacle. A point with a name is a place.

Coordinates are longitude and latitude, as RFC 7946 wants them, unless `crs` names a projected system, which is then
taken to be in metres. A map keeps its origin as `Offset`; `site_frame` has the formulas.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from itertools import pairwise
from typing import Any, Final

from intellwheels_maps.crossing import Point
from intellwheels_maps.importers.floor_draft import FloorDraft, Leaf
from intellwheels_maps.importers.floor_source import FloorSource, Imported, check_no_level
from intellwheels_maps.importers.plan_layers import part_of
from intellwheels_maps.importers.wall_outlines import outlines
from intellwheels_maps.site_frame import DEGREES, degree_lengths
from intellwheels_schemas.explain import shown

KEYS: Final = ("type", "indoor", "feature_type", "category", "class")
"""Properties that tell what a feature is."""

LINE: Final = 0.02
"""Thickness of a wall that is a line without `thickness` or `width`, m."""

MAX_POINTS: Final = 200_000
"""Most points of a file."""

MAX_BYTES: Final = 16 << 20
"""Longest file, 16 MiB."""

_ZONES: Final = re.compile(r"room|corridor|area|stair|elevator|lift|unit|zone|level|outline|floor|ramp", re.IGNORECASE)
_SOLIDS: Final = re.compile(r"furniture|obstacle|fixture|kiosk|table|desk", re.IGNORECASE)
_CRS: Final = re.compile(r"EPSG:(?:[\d.]*:)?(\d{3,6})\Z", re.IGNORECASE)


def import_geojson(source: FloorSource) -> Imported:
    """Return the map of a collection of features.

    Raises:
        WireError: The file is no such collection, or its coordinates are none of its system.
    """
    check_no_level(source)
    return _Collection(source).imported()


class _Collection:
    """The features of a file while they are read."""

    def __init__(self, source: FloorSource) -> None:
        self._source = source
        document = self._document()
        self._features: list[Any] = document.get("features") or []
        if document.get("type") != "FeatureCollection" or not isinstance(self._features, list):
            text = f"expected a FeatureCollection with features, got {shown(document.get('type'))}"
            raise source.error("", text, "malformed")
        self._epsg = self._system(document)
        self._left = MAX_POINTS
        self._origin: Point = (0.0, 0.0)
        self._scale: Point = (1.0, 1.0)
        self._draft = FloorDraft(source)

    def imported(self) -> Imported:
        """Return the map."""
        shapes = [self._geometry(feature, f"features[{index}]") for index, feature in enumerate(self._features)]
        if self._epsg == DEGREES:
            points = [point for _, parts in shapes for part in parts for ring in part for point in ring]
            if not points:
                raise self._source.error("features", "expected coordinates, got none")
            self._origin = min(x for x, _ in points), min(y for _, y in points)
            self._scale = degree_lengths(self._origin[1])
        for index, (feature, (kind, parts)) in enumerate(zip(self._features, shapes, strict=True)):
            properties = feature.get("properties")
            self._add(
                kind,
                [[[self._metres(point) for point in ring] for ring in part] for part in parts],
                properties if isinstance(properties, dict) else {},
                f"features[{index}]",
            )
        return self._draft.finish(epsg=self._epsg, offset=self._origin if self._epsg == DEGREES else None)

    def _add(self, kind: str, parts: list[list[list[Point]]], properties: dict[str, Any], where: str) -> None:
        word = next((str(properties[key]) for key in KEYS if isinstance(properties.get(key), str)), "")
        what = part_of(word)
        name = next((str(properties[key]) for key in ("name", "ref", "id") if properties.get(key) is not None), word)
        if kind == "Point" and isinstance(properties.get("name"), str):
            heading = self._number(properties, "heading", 0.0, where, -360.0, 360.0)
            for part in parts:
                self._draft.place(name, part[0][0], where, heading_deg=heading)
        elif what in {"wall", "window"} and kind != "Point":
            self._wall(kind, parts, properties, where)
        elif what == "door" and kind != "Point":
            for part in parts:
                self._draft.door(name or "door", where, Leaf(*self._across(kind, part[0]), None))
        elif kind == "Polygon" and _SOLIDS.search(word) and properties.get("height") is not None:
            top = self._number(properties, "height", 1.0, where, 0.01, 1000.0)
            for ring in self._rings(parts, where):
                self._draft.obstacle(name, ring, top, where)
        elif kind == "Polygon" and _ZONES.search(word):
            for part in parts:
                self._draft.zone(f"{word}-{name}" if name != word else word, part[0], where, title=name)
        else:
            self._draft.leave_out(where, f"{kind} {shown(word)}, not known as a part of a floor")

    def _wall(self, kind: str, parts: list[list[list[Point]]], properties: dict[str, Any], where: str) -> None:
        height = self._number(properties, "height", 2.5, where, 0.01, 1000.0)
        if kind == "Polygon":
            for ring in self._rings(parts, where):
                self._draft.wall(ring, where, height=height)
            return
        width = self._number(properties, "width", LINE, where, 0.001, 100.0)
        width = self._number(properties, "thickness", width, where, 0.001, 100.0)
        for part in parts:
            self._draft.wall(part[0], where, thickness=width, height=height)

    def _rings(self, parts: list[list[list[Point]]], where: str) -> Iterable[list[Point]]:
        """Yield the outlines of polygons, which may have holes."""
        import shapely  # noqa: PLC0415 - of an extra

        for part in parts:
            if any(len(ring) < 4 for ring in part):
                self._draft.leave_out(where, "ring of fewer than 4 points")
                continue
            polygon = shapely.Polygon(part[0], part[1:])
            if polygon.is_valid:
                yield from outlines(polygon)
            elif len(part) == 1:
                yield part[0]  # the draft says what is wrong with it
            else:
                self._draft.leave_out(where, "polygon whose rings cross or touch")

    @staticmethod
    def _across(kind: str, ring: list[Point]) -> tuple[Point, Point]:
        """Return the jambs of a door: the ends of a line, or those of the middle of the smallest box around a ring."""
        if kind != "Polygon":
            return ring[0], ring[-1]
        import shapely  # noqa: PLC0415 - of an extra

        box = shapely.oriented_envelope(shapely.MultiPoint(ring))
        corners = [(float(x), float(y)) for x, y in shapely.get_coordinates(box)]
        if len(corners) < 5:
            return corners[0], corners[-1]
        middles = [((ax + bx) / 2, (ay + by) / 2) for (ax, ay), (bx, by) in pairwise(corners)]
        one, other = (middles[0], middles[2]), (middles[1], middles[3])
        lengths = [shapely.LineString(ends).length for ends in (one, other)]
        return one if lengths[0] >= lengths[1] else other

    # ------------------------------------------------------------ values

    def _document(self) -> dict[str, Any]:
        if len(self._source.data) > MAX_BYTES:
            raise self._source.error("", f"expected at most {MAX_BYTES:,} bytes, got more", "too-long")
        try:
            document = json.loads(self._source.data)
        except json.JSONDecodeError as error:
            raise self._source.error(f"line {error.lineno}", f"expected JSON, got {error.msg}", "malformed") from None
        except (ValueError, RecursionError) as error:
            got = "too deep a nesting" if isinstance(error, RecursionError) else shown(str(error))
            raise self._source.error("", f"expected JSON, got {got}", "malformed") from None
        if not isinstance(document, dict):
            raise self._source.error("", f"expected a FeatureCollection, got {shown(document)}", "malformed")
        return document

    def _system(self, document: dict[str, Any]) -> str:
        crs = document.get("crs")
        if crs is None:
            return DEGREES
        properties = crs.get("properties") if isinstance(crs, dict) else None
        name = properties.get("name") if isinstance(properties, dict) else None
        if isinstance(name, str) and name.upper().endswith("CRS84"):
            return DEGREES
        found = _CRS.search(name) if isinstance(name, str) else None
        if found is None:
            raise self._source.error("crs", f"expected CRS84 or an EPSG code, got {shown(name)}")
        return f"EPSG:{found[1]}"

    def _geometry(self, feature: object, where: str) -> tuple[str, list[list[list[Point]]]]:
        """Return the kind of a geometry without `Multi`, and its parts: each a list of lists of points."""
        geometry = feature.get("geometry") if isinstance(feature, dict) else None
        if not isinstance(feature, dict) or (geometry is not None and not isinstance(geometry, dict)):
            raise self._source.error(where, f"expected a feature with a geometry, got {shown(feature)}", "malformed")
        if geometry is None:
            return "nothing", []
        kind, coordinates = geometry.get("type"), geometry.get("coordinates")
        where = f"{where}.geometry"
        if kind not in {"Point", "LineString", "Polygon", "MultiPoint", "MultiLineString", "MultiPolygon"}:
            return str(shown(kind)), []
        parts = self._list(coordinates, where) if kind.startswith("Multi") else [coordinates]
        kind = kind.removeprefix("Multi")
        if kind == "Point":
            return kind, [[[self._point(part, where)]] for part in parts]
        if kind == "LineString":
            return kind, [[self._points(part, where)] for part in parts]
        return kind, [[self._points(ring, where) for ring in self._list(part, where)] for part in parts]

    def _points(self, value: object, where: str) -> list[Point]:
        return [self._point(one, where) for one in self._list(value, where)]

    def _list(self, value: object, where: str) -> list[Any]:
        if not isinstance(value, list) or not value:
            raise self._source.error(where, f"expected a list of coordinates, got {shown(value)}", "malformed")
        return value

    def _point(self, value: object, where: str) -> Point:
        self._left -= 1
        if self._left < 0:
            raise self._source.error(where, f"expected at most {MAX_POINTS:,} points, got more", "too-many")
        numbers = value[:2] if isinstance(value, list) else []
        if len(numbers) != 2 or any(isinstance(one, bool) or not isinstance(one, (int, float)) for one in numbers):
            raise self._source.error(where, f"expected two numbers, got {shown(value)}", "malformed")
        x, y = numbers
        if self._epsg == DEGREES and not (abs(x) <= 180.0 and abs(y) < 90.0):
            got = f"{x:g} {y:g}" if abs(x) < 1e300 and abs(y) < 1e300 else "very large numbers"
            raise self._source.error(where, f"expected longitude and latitude in degrees, got {got}; name the crs")
        if not (abs(x) < 1e8 and abs(y) < 1e8):
            raise self._source.error(where, "expected coordinates within 100,000 km, got others")
        return float(x), float(y)

    def _metres(self, point: Point) -> Point:
        return (point[0] - self._origin[0]) * self._scale[0], (point[1] - self._origin[1]) * self._scale[1]

    def _number(
        self, properties: dict[str, Any], key: str, default: float, where: str, low: float, high: float
    ) -> float:
        value = properties.get(key)
        if value is None:
            return default
        try:
            number = float(value)
        except (TypeError, ValueError, OverflowError):
            number = float("nan")
        if not low <= number <= high:
            text = f"expected a number in [{low:g}, {high:g}], got {shown(value)}"
            raise self._source.error(f"{where}.properties.{key}", text)
        return number
