"""Imports a storey of a building model in IFC. Pure.

The bodies of walls, columns, windows, railings and the like are cut `CUT` above the storey: what the cut meets is a
wall, or an obstacle if it is furniture. Doors are doorways with their leaves, and spaces are zones. The coordinates are
those of the project or, if it has a map conversion, those of the projected system that it names.

Geometry is made by a library in C++, so a damaged model can take long or more memory than its size suggests.

Source:
    IfcDoor and IfcDoorTypeOperationEnum of ISO 16739-1: the width is along x, and a leaf opens along y, with its hinge
    on the side that the operation names, as seen along y.
"""

from __future__ import annotations

import math
from collections import Counter
from importlib import import_module
from typing import Any, Final

from intellwheels_maps.crossing import Point
from intellwheels_maps.importers.floor_draft import FloorDraft, Leaf
from intellwheels_maps.importers.floor_source import FloorSource, Imported, chosen_level
from intellwheels_maps.importers.wall_outlines import outlines
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown
from intellwheels_schemas.messages import Door, DoorKind, Side

CUT: Final = 0.6
"""Height of the cut above the storey, m."""

MAX_PRODUCTS: Final = 20_000
"""Most products whose bodies are cut."""

MAX_TRIANGLES: Final = 5_000_000
"""Most triangles of all bodies together."""

WALLS: Final = (
    "IfcWall", "IfcColumn", "IfcWindow", "IfcCurtainWall", "IfcRailing", "IfcMember", "IfcPlate", "IfcStair",
    "IfcStairFlight", "IfcBuildingElementProxy", "IfcBeam",
)  # fmt: skip
"""Products that are walls where the cut meets them."""

OBSTACLES: Final = ("IfcFurnishingElement", "IfcSanitaryTerminal", "IfcElectricAppliance")
"""Products that are obstacles where the cut meets them."""

OPERATIONS: Final[dict[str, tuple[DoorKind, Side]]] = {
    "SINGLE_SWING_LEFT": ("hinged", "left"),
    "SINGLE_SWING_RIGHT": ("hinged", "right"),
    "DOUBLE_DOOR_SINGLE_SWING": ("double-hinged", "left"),
    "SLIDING_TO_LEFT": ("sliding", "left"),
    "SLIDING_TO_RIGHT": ("sliding", "right"),
    "DOUBLE_DOOR_SLIDING": ("double-sliding", "left"),
}
"""The doors that a map can have. Of the others only the opening is kept."""


def import_ifc(source: FloorSource) -> Imported:
    """Return the map of a storey.

    Raises:
        WireError: The file is no model, or has no such storey.
    """
    try:
        return _Model(source).imported()
    except WireError:
        raise
    except (RuntimeError, ValueError, TypeError, AttributeError, KeyError) as error:
        # A model may say anything, also what its schema forbids.
        text = f"expected a model in IFC, got {type(error).__name__}: {shown(str(error))}"
        raise source.error("", text, "malformed") from None


class _Model:
    """A building model while one of its storeys is read."""

    def __init__(self, source: FloorSource) -> None:
        self._source = source
        self._file = self._opened()
        self._unit = float(_library("util.unit").calculate_unit_scale(self._file))
        storeys: dict[str, Any] = {}
        for storey in sorted(self._file.by_type("IfcBuildingStorey"), key=self._elevation):
            storeys.setdefault(str(storey.Name or f"#{storey.id()}"), storey)
        self._name = chosen_level(source, list(storeys))
        self._base = self._elevation(storeys[self._name])
        self._draft = FloorDraft(source)
        for other in storeys:
            if other != self._name:
                self._draft.leave_out(f"storey {other}", "another storey, which FILE#STOREY imports")
        self._east, self._north, self._turn, self._epsg = self._conversion()
        self._triangles = MAX_TRIANGLES

    def imported(self) -> Imported:
        """Return the map of the storey."""
        products = self._file.by_type("IfcProduct")
        if len(products) > MAX_PRODUCTS:
            text = f"expected at most {MAX_PRODUCTS:,} products, got {len(products):,}"
            raise self._source.error("", text, "too-many")
        others: Counter[str] = Counter()
        for product in products:
            where = f"#{product.id()} {product.is_a()}"
            if product.is_a("IfcDoor"):
                self._door(product, where)
            elif product.is_a("IfcSpace"):
                for ring in self._cut(product, where)[0]:
                    self._draft.zone(str(product.Name or "space"), ring, where, title=str(product.LongName or ""))
            elif any(product.is_a(kind) for kind in (*WALLS, *OBSTACLES)):
                rings, bottom, top = self._cut(product, where)
                for ring in rings:
                    if any(product.is_a(kind) for kind in WALLS):
                        self._draft.wall(ring, where, height=top, bottom=bottom)
                    else:
                        self._draft.obstacle(str(product.Name or product.is_a()), ring, top, where)
            elif product.Representation is not None:
                others[product.is_a()] += 1
        for kind, count in sorted(others.items()):
            self._draft.leave_out(kind, "product that is no part of a floor", count)
        return self._draft.finish(self._name, epsg=self._epsg)

    # ------------------------------------------------------------ parts

    def _cut(self, product: Any, where: str) -> tuple[list[list[Point]], float, float]:
        """Return the outlines of a cut, and the lowest and the highest point of the body above the storey, m."""
        import numpy as np  # noqa: PLC0415 - of an extra

        if product.Representation is None:
            return [], 0.0, 0.0
        geom = _library("geom")
        settings = geom.settings()
        settings.set("use-world-coords", True)
        try:
            geometry = geom.create_shape(settings, product).geometry
        except RuntimeError:
            self._draft.leave_out(where, "product whose body cannot be made")
            return [], 0.0, 0.0
        corners = np.array(geometry.verts, dtype=float).reshape(-1, 3)
        faces = np.array(geometry.faces, dtype=int).reshape(-1, 3)
        self._triangles -= len(faces)
        if self._triangles < 0:
            raise self._source.error(where, f"expected at most {MAX_TRIANGLES:,} triangles, got more", "too-many")
        if not len(faces):
            return [], 0.0, 0.0
        heights = corners[:, 2] - self._base
        if not heights.min() < CUT < heights.max():
            return [], 0.0, 0.0
        rings = [[self._site(point) for point in ring] for ring in outlines(section(corners, faces, self._base + CUT))]
        return rings, round(max(float(heights.min()), 0.0), 4), round(float(heights.max()), 4)

    def _door(self, door: Any, where: str) -> None:
        width = float(door.OverallWidth or 0.0) * self._unit
        if door.ObjectPlacement is None or not 0.1 < width < 20.0:
            self._draft.leave_out(where, "door without a place or a width")
            return
        matrix = _library("util.placement").get_local_placement(door.ObjectPlacement)
        x, y, z = (float(matrix[row][3]) * self._unit for row in range(3))
        if abs(z - self._base) > CUT:
            return
        along = float(matrix[0][0]), float(matrix[1][0])
        ends = self._site((x, y)), self._site((x + along[0] * width, y + along[1] * width))
        operation = str(getattr(door, "OperationType", None) or "")
        leaf = None
        if operation in OPERATIONS:
            kind, side = OPERATIONS[operation]
            leaf = Door(kind=kind, side=side, swing_deg=90.0)
        else:
            self._draft.leave_out(where, f"door of the operation {shown(operation)} (its opening is kept)")
        self._draft.door(str(door.Name or "door"), where, Leaf(*ends, leaf))

    def _conversion(self) -> tuple[float, float, float, str | None]:
        """Return easting and northing of the project's origin, m, its angle, and the name of the projected system."""
        found = self._file.by_type("IfcMapConversion") if self._file.schema != "IFC2X3" else []
        if not found:
            return 0.0, 0.0, 0.0, None
        one = found[0]
        turn = math.atan2(float(one.XAxisOrdinate or 0.0), float(one.XAxisAbscissa or 1.0))
        name = str(one.TargetCRS.Name or "") if one.TargetCRS is not None else ""
        return float(one.Eastings), float(one.Northings), turn, name[:200] or None

    def _site(self, point: Point) -> Point:
        cos, sin = math.cos(self._turn), math.sin(self._turn)
        return self._east + cos * point[0] - sin * point[1], self._north + sin * point[0] + cos * point[1]

    def _elevation(self, storey: Any) -> float:
        return float(storey.Elevation or 0.0) * self._unit

    def _opened(self) -> Any:
        if not self._source.data.lstrip()[:13].startswith(b"ISO-10303-21"):
            raise self._source.error("line 1", "expected ISO-10303-21, the start of a model in IFC", "malformed")
        if b"END-ISO-10303-21" not in self._source.data[-200:]:
            raise self._source.error("", "expected END-ISO-10303-21 at the end, got a truncated file", "malformed")
        try:
            return import_module("ifcopenshell").file.from_string(self._source.data.decode("latin-1"))
        except Exception as error:  # the library has no class for what it cannot read
            text = f"expected a model in IFC, got {shown(str(error))}"
            raise self._source.error("", text, "malformed") from None


def _library(module: str) -> Any:
    """Return a module of ifcopenshell, which has its own extra and few types."""
    return import_module(f"ifcopenshell.{module}")


def section(corners: Any, faces: Any, height: float) -> Any:
    """Return the area in which a horizontal plane cuts a closed body.

    Args:
        corners: float[n, 3], m.
        faces: int[m, 3], the corners of triangles.
        height: z of the plane. Corners on it are taken to be above.
    """
    import numpy as np  # noqa: PLC0415 - of an extra
    import shapely  # noqa: PLC0415

    triangles = corners[faces]
    above = triangles[:, :, 2] >= height
    crossed = triangles[np.any(above, axis=1) & ~np.all(above, axis=1)]
    ends = []
    for one, other in ((0, 1), (1, 2), (2, 0)):
        a, b = crossed[:, one], crossed[:, other]
        crosses = (a[:, 2] >= height) != (b[:, 2] >= height)
        share = (height - a[:, 2]) / np.where(crosses, b[:, 2] - a[:, 2], 1.0)
        point = a[:, :2] + share[:, None] * (b[:, :2] - a[:, :2])
        ends.append(np.where(crosses[:, None], point, np.nan))
    all_ends = np.stack(ends, axis=1)
    kept = ~np.isnan(all_ends[:, :, 0])
    segments = all_ends[kept].reshape(-1, 2, 2).round(6)
    lines = [line for line in shapely.linestrings(segments) if line.length > 0.0]
    if not lines:
        return shapely.Polygon()
    areas = shapely.get_parts(shapely.polygonize([*shapely.get_parts(shapely.node(shapely.union_all(lines)))]))
    # A hole of the body is an area of its own, inside another one: an odd number of outlines counts.
    found = shapely.Polygon()
    for area in sorted(areas, key=lambda one: -shapely.Polygon(one.exterior).area):
        found = shapely.union(found, area) if _is_inside(area, segments) else found
    # The edges of triangles leave corners on straight lines.
    return shapely.simplify(found, 1e-6)


def _is_inside(area: Any, segments: Any) -> bool:
    """Return whether a point in an area has an odd number of outlines on its right."""
    import numpy as np  # noqa: PLC0415 - of an extra

    point = area.representative_point()
    a, b = segments[:, 0], segments[:, 1]
    crosses = (a[:, 1] > point.y) != (b[:, 1] > point.y)
    x = a[:, 0] + (point.y - a[:, 1]) / np.where(crosses, b[:, 1] - a[:, 1], 1.0) * (b[:, 0] - a[:, 0])
    return bool(np.count_nonzero(crosses & (x > point.x)) % 2)
