"""Imports buildings of Open-RMF, as its traffic editor writes them: `NAME.building.yaml`. Pure.

One level becomes a map. Walls have the thickness that Open-RMF builds them with. Doors have their leaves. Named
vertices and vertices of lanes are places, lanes are routes, and floors and the cabins of lifts are zones. Models of
furniture have no dimensions in the file, so they are left out.

Coordinates are pixels of a drawing, x to the right and y down. The measurements of the level give their scale. The map
has its origin at the top left of the drawing, so y is negative.

Source:
    Door conventions: the message Door of rmf_building_map_msgs. A leaf turns about the start of its door, clockwise
    seen from above for a positive `motion_direction`; a sliding leaf slides towards the start.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final, cast

from intellwheels_maps.crossing import Point
from intellwheels_maps.importers.floor_draft import FloorDraft, Leaf
from intellwheels_maps.importers.floor_source import FloorSource, Imported, chosen_level
from intellwheels_maps.importers.safe_yaml import read_yaml
from intellwheels_schemas.explain import shown
from intellwheels_schemas.messages import Door, DoorKind

THICKNESS: Final = 0.1
"""Thickness of the walls that Open-RMF builds, m."""

KINDS: Final = {
    "hinged": "hinged",
    "double_hinged": "double-hinged",
    "sliding": "sliding",
    "double_sliding": "double-sliding",
    "telescope": "sliding",
    "double_telescope": "double-sliding",
}
"""The kinds of doors. A telescope door is one that slides, in leaves that the map does not tell apart."""

_NOT_IN_A_MAP: Final = ("models", "holes", "features", "constraints")


def import_rmf_building(source: FloorSource) -> Imported:
    """Return the map of one level of a building.

    Raises:
        WireError: The file is invalid, or has no such level.
    """
    return _Building(source).import_level()


class _Building:
    """A building while one of its levels is read. Errors and what is left out have the place in the file."""

    def __init__(self, source: FloorSource) -> None:
        self._source = source
        self._document = read_yaml(source)
        levels = self._table(self._document.get("levels"), "levels")
        self._level_names = sorted(
            (str(name) for name in levels), key=lambda name: (self._elevation(levels, name), name)
        )
        self._name = chosen_level(source, self._level_names)
        self._at = f"levels.{self._name}"
        self._level = self._table({str(key): level for key, level in levels.items()}[self._name], self._at)
        self._draft = FloorDraft(source)
        self._pixels = self._vertices()
        self._scale = self._metres_a_pixel()

    def import_level(self) -> Imported:
        """Return the map of the level."""
        for other in self._level_names:
            if other != self._name:
                self._draft.leave_out(f"levels.{other}", "another level, which FILE#LEVEL imports")
        for where, start, end, settings in self._edges("walls"):
            height = self._setting(settings, "texture_height", 2.5, f"{where}.texture_height", 0.01, 1000.0)
            self._draft.wall((self._point(start), self._point(end)), where, thickness=THICKNESS, height=height)
        for where, start, end, settings in self._edges("doors"):
            self._door(where, start, end, settings)
        self._places_and_routes()
        self._lifts()
        for index, floor in enumerate(self._list(self._level, "floors")):
            where = f"{self._at}.floors[{index}]"
            numbers = self._list(self._table(floor, where), "vertices")
            self._draft.zone(f"floor{index + 1}", [self._point(self._vertex(one, where)) for one in numbers], where)
        for key in _NOT_IN_A_MAP:
            for index, _ in enumerate(self._list(self._level, key)):
                self._draft.leave_out(f"{self._at}.{key}[{index}]", f"{key} are not in the map")
        name = self._document.get("name")
        return self._draft.finish(f"{name}, {self._name}" if isinstance(name, str) and name else "")

    # ------------------------------------------------------------ parts of a level

    def _vertices(self) -> list[Point]:
        points = []
        for index, vertex in enumerate(self._list(self._level, "vertices")):
            where = f"{self._at}.vertices[{index}]"
            if not isinstance(vertex, list) or len(vertex) < 2:
                raise self._source.error(where, f"expected a list of x, y, z and a name, got {shown(vertex)}")
            points.append((self._number(vertex[0], where), self._number(vertex[1], where)))
        return points

    def _metres_a_pixel(self) -> float:
        """Return the scale of the drawing: the mean of the measurements, as Open-RMF takes it."""
        system = self._document.get("coordinate_system", "reference_image")
        if system == "cartesian_meters":
            return 1.0
        if system != "reference_image":
            text = f"expected reference_image or cartesian_meters, got {shown(system)}"
            raise self._source.error("coordinate_system", text)
        scales = []
        for where, start, end, settings in self._edges("measurements"):
            pixels = math.dist(self._pixels[start], self._pixels[end])
            metres = self._setting(settings, "distance", 0.0, f"{where}.distance", 0.0, 1e6)
            if pixels <= 0.0 or metres <= 0.0:
                raise self._source.error(where, f"expected a distance above 0, got {metres:g} m and {pixels:g} pixels")
            scales.append(metres / pixels)
        if not scales:
            raise self._source.error(f"{self._at}.measurements", "expected a measurement for the scale, got none")
        return math.fsum(scales) / len(scales)

    def _door(self, where: str, start: int, end: int, settings: dict[str, Any]) -> None:
        kind = self._text(settings, "type", "")
        name = self._text(settings, "name", "") or "door"
        if start == end:
            raise self._source.error(where, "expected two vertices, got one twice")
        if self._text(settings, "motion_axis", "start") == "end":
            start, end = end, start
        door = None
        if kind in KINDS:
            turn = self._setting(settings, "motion_degrees", 90.0, f"{where}.motion_degrees", -360.0, 360.0)
            turn *= self._setting(settings, "motion_direction", 1.0, f"{where}.motion_direction", -1.0, 1.0)
            # Clockwise about the left jamb is against the heading.
            door = Door(kind=cast(DoorKind, KINDS[kind]), side="left", swing_deg=-turn)
        else:
            self._draft.leave_out(where, f"door of the kind {shown(kind)} (its opening is kept)")
        self._draft.door(name, where, Leaf(self._point(start), self._point(end), door))

    def _places_and_routes(self) -> None:
        lanes = list(self._edges("lanes"))
        on_lanes = {vertex for _, start, end, _ in lanes for vertex in (start, end)}
        names: dict[int, str] = {}
        for index, vertex in enumerate(self._list(self._level, "vertices")):
            name = vertex[3] if len(vertex) > 3 and isinstance(vertex[3], str) else ""
            if not name and index not in on_lanes:
                continue
            # A body may start at a place that has a name. The other vertices are only on the way.
            kinds = () if name else ("waypoint",)
            where = f"{self._at}.vertices[{index}]"
            names[index] = self._draft.place(name or f"vertex{index}", self._point(index), where, kinds=kinds)
        for _, start, end, settings in lanes:
            both = self._value(settings, "bidirectional", True)
            self._draft.route((names[start], names[end]), one_way=not both)

    def _lifts(self) -> None:
        for name, given in self._table(self._document.get("lifts") or {}, "lifts").items():
            where = f"lifts.{name}"
            lift = self._table(given, where)
            if self._name not in self._table(lift.get("level_doors") or {}, f"{where}.level_doors"):
                continue
            centre = self._lift_centre(str(name), lift, where)
            if centre is None:
                self._draft.leave_out(where, "lift whose place on this level is not in the file")
                continue
            half_x = self._number(lift.get("width"), f"{where}.width") / 2
            half_y = self._number(lift.get("depth"), f"{where}.depth") / 2
            yaw = self._number(lift.get("yaw", 0), f"{where}.yaw")
            cos, sin = math.cos(yaw), math.sin(yaw)
            ring = [
                (centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y)
                for x, y in ((-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y))
            ]
            self._draft.zone(str(name), ring, where, title=str(name))
            for door in self._table(lift.get("doors") or {}, f"{where}.doors"):
                self._draft.leave_out(f"{where}.doors.{door}", "doors of lifts are not in the map")

    def _lift_centre(self, name: str, lift: dict[Any, Any], where: str) -> Point | None:
        """Return the middle of a cabin. Its coordinates are those of one level; on others, a vertex may mark it."""
        if lift.get("reference_floor_name") == self._name:
            return self._metres((self._number(lift.get("x"), where), self._number(lift.get("y"), where)))
        for index, vertex in enumerate(self._list(self._level, "vertices")):
            settings = vertex[4] if len(vertex) > 4 and isinstance(vertex[4], dict) else {}
            if self._value(settings, "lift_cabin", "") == name:
                return self._point(index)
        return None

    # ------------------------------------------------------------ values

    def _metres(self, pixel: Point) -> Point:
        up = 1.0 if self._document.get("coordinate_system") == "cartesian_meters" else -1.0
        return pixel[0] * self._scale, up * pixel[1] * self._scale

    def _point(self, vertex: int) -> Point:
        return self._metres(self._pixels[vertex])

    def _edges(self, key: str) -> Iterator[tuple[str, int, int, dict[str, Any]]]:
        """Yield the place, the two vertices and the settings of each edge of a kind."""
        for index, edge in enumerate(self._list(self._level, key)):
            where = f"{self._at}.{key}[{index}]"
            if not isinstance(edge, list) or len(edge) < 2:
                raise self._source.error(where, f"expected a list of two vertices and settings, got {shown(edge)}")
            settings = edge[2] if len(edge) > 2 and isinstance(edge[2], dict) else {}
            yield where, self._vertex(edge[0], where), self._vertex(edge[1], where), settings

    def _vertex(self, number: object, where: str) -> int:
        if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < len(self._pixels):
            text = f"expected the number of one of the {len(self._pixels)} vertices, got {shown(number)}"
            raise self._source.error(where, text)
        return number

    def _value(self, settings: dict[str, Any], key: str, default: Any) -> Any:
        """Return a setting, which is written as a pair of a type and a value."""
        pair = settings.get(key)
        return pair[1] if isinstance(pair, list) and len(pair) == 2 else default

    def _text(self, settings: dict[str, Any], key: str, default: str) -> str:
        value = self._value(settings, key, default)
        return value if isinstance(value, str) else default

    def _setting(
        self, settings: dict[str, Any], key: str, default: float, where: str, low: float, high: float
    ) -> float:
        value = self._number(self._value(settings, key, default), where)
        if not low <= value <= high:
            raise self._source.error(where, f"expected a number in [{low:g}, {high:g}], got {value:g}")
        return value

    def _elevation(self, levels: dict[Any, Any], name: str) -> float:
        level = levels.get(name)
        value = level.get("elevation", 0.0) if isinstance(level, dict) else 0.0
        return self._number(value, f"levels.{name}.elevation")

    def _number(self, value: object, where: str) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e8:
            raise self._source.error(where, f"expected a number within 1e8, got {shown(value)}")
        return float(value)

    def _table(self, value: object, where: str) -> dict[Any, Any]:
        if not isinstance(value, dict):
            raise self._source.error(where, f"expected keys and values, got {shown(value)}")
        return value

    def _list(self, table: dict[Any, Any], key: str) -> list[Any]:
        value = table.get(key)
        # An empty list is also written as {}.
        if value is None or value == {}:
            return []
        if not isinstance(value, list):
            raise self._source.error(f"{self._at}.{key}", f"expected a list, got {shown(value)}")
        return value
