"""Imports drawings in DXF. Pure.

The names of layers tell what is a wall, a window or a door (`plan_layers`). Everything on other layers is left out,
because a plan does not say how high it is. Blocks are expanded. A window is a wall, because a body cannot pass it.

- An outline on a wall layer is a solid wall if it is thin, and otherwise a line around an area.
- Lines and arcs on wall layers are the faces of walls. A thin area between them is a solid wall. The rest are lines.
- A line has the width of its polyline; without one, it is `LINE` thick.
- The arc of a door leaf has its hinge in the middle; the end of the arc that fills an opening is the other jamb. Two
  leaves that meet are one door. A wall that is a line, or hardly thicker, is open where a door is drawn on it.
"""

from __future__ import annotations

import io
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, Final, NamedTuple

from intellwheels_maps.crossing import Point
from intellwheels_maps.importers.dxf_shapes import Shape, ShapeReader
from intellwheels_maps.importers.floor_draft import FloorDraft, Leaf
from intellwheels_maps.importers.floor_source import FloorSource, Imported, check_no_level
from intellwheels_maps.importers.plan_layers import part_of
from intellwheels_maps.importers.wall_outlines import outlines
from intellwheels_schemas.explain import shown
from intellwheels_schemas.messages import Door

LINE: Final = 0.02
"""Thickness of a wall that is a single line without a width, m."""

THIN: Final = 0.15
"""Largest thickness of a wall that is open where a door is drawn on it, m."""

THICKEST: Final = 0.8
"""Largest mean thickness of a solid wall, m: twice its area over its outline."""

LEAVES: Final = (0.4, 2.0)
"""Smallest and largest radius of the arc of a door leaf, m."""

MAX_LINES: Final = 100_000
"""Most pieces of lines on wall layers."""


MAX_CROSSINGS: Final = 300_000
"""Most pairs of pieces of lines on wall layers that touch or cross, beside neighbours."""

MAX_BYTES: Final = 32 << 20
"""Longest drawing, 32 MiB."""

MEETING: Final = 0.2
"""Farthest that the ends of two leaves of one door are apart, and a door from the line that it opens, m."""


class _Face(NamedTuple):
    """A line, or a thin outline, whose first corner is also the last."""

    points: list[Point]
    where: str
    solid: bool = False


class _DrawnDoor(NamedTuple):
    name: str
    where: str
    leaves: list[Leaf]


def import_dxf(source: FloorSource) -> Imported:
    """Return the map in the model space of a drawing.

    Raises:
        WireError: It is no drawing, has no units or no walls, or is too large.
    """
    check_no_level(source)
    document = _document(source)
    reader = ShapeReader(source, document, _metres_a_unit(source, document))
    draft = FloorDraft(source)
    faces: list[_Face] = []
    doors: list[_DrawnDoor] = []
    others: Counter[tuple[str, str]] = Counter()
    for entity in document.modelspace():
        kind, layer = entity.dxftype(), str(entity.dxf.layer)
        part = part_of(layer, str(entity.dxf.name) if kind == "INSERT" else "")
        if part is None:
            others[layer, kind] += 1
            continue
        where = f"layer {layer!r}, {kind} {entity.dxf.handle}"
        shapes = reader.shapes(entity)
        if not shapes:
            others[layer, kind] += 1
        elif part == "door":
            door = _door(entity, shapes, where)
            if door is not None:
                doors.append(door)
            elif kind != "LINE":
                draft.leave_out(where, "part of a door that has no arc")
        elif part == "window" and kind == "INSERT":
            draft.wall(_box(entity, shapes), where)
        else:
            for shape in shapes:
                _add_wall(draft, shape, faces, where)
    _add_faces(source, draft, faces, doors)
    for door in _joined(doors):
        draft.door(door.name, door.where, *door.leaves)
    for (layer, kind), count in sorted(others.items()):
        draft.leave_out(f"layer {shown(layer)}", f"{kind}, not known as walls, windows or doors", count)
    return draft.finish()


def _document(source: FloorSource) -> Any:
    from ezdxf import recover  # noqa: PLC0415 - of an extra
    from ezdxf.lldxf.const import DXFError  # noqa: PLC0415

    if len(source.data) > MAX_BYTES:
        raise source.error("", f"expected at most {MAX_BYTES:,} bytes, got {len(source.data):,}", "too-long")
    if source.data.startswith(b"AutoCAD Binary DXF"):
        raise source.error("", "expected DXF as text, got a binary one; save it as ASCII", "malformed")
    if not source.data.rstrip().endswith(b"EOF"):
        raise source.error(
            "", "expected a drawing in DXF that ends in EOF, got another or a truncated file", "malformed"
        )
    try:
        return _read_quickly(source.data) or recover.read(io.BytesIO(source.data))[0]
    except (DXFError, OSError, ValueError, TypeError, KeyError, AttributeError, IndexError) as error:
        # A drawing that is damaged enough also fails in places where the library expects none of it.
        text = f"expected a drawing in DXF, got {type(error).__name__}: {shown(str(error))}"
        raise source.error("", text, "malformed") from None


def _read_quickly(data: bytes) -> Any:
    """Return a drawing of a recent version without damage, or None for one that needs a slower reader."""
    import ezdxf  # noqa: PLC0415 - of an extra
    from ezdxf.lldxf.const import DXFError  # noqa: PLC0415

    try:
        # From this version on, drawings are UTF-8.
        return ezdxf.read(io.StringIO(data.decode())) if _version(data) >= b"AC1021" else None  # type: ignore[attr-defined]
    except (DXFError, ValueError, TypeError, KeyError, AttributeError, IndexError):
        return None


def _version(data: bytes) -> bytes:
    _, found, rest = data[:4096].partition(b"$ACADVER")
    words = rest.split(maxsplit=2)
    return words[1] if found and len(words) > 1 else b""


def _metres_a_unit(source: FloorSource, document: Any) -> float:
    from ezdxf.enums import InsertUnits  # noqa: PLC0415 - of an extra
    from ezdxf.units import conversion_factor  # noqa: PLC0415

    unit = document.header.get("$INSUNITS", 0)
    if not unit:
        raise source.error("$INSUNITS", "expected the unit of the drawing, got none; set it in the drawing")
    try:
        return float(conversion_factor(InsertUnits(unit), InsertUnits.Meters))
    except (KeyError, TypeError, ValueError, IndexError):
        raise source.error("$INSUNITS", f"expected the number of a unit of length, got {shown(unit)}") from None


def _add_wall(draft: FloorDraft, shape: Shape, faces: list[_Face], where: str) -> None:
    import shapely  # noqa: PLC0415 - of an extra

    if shape.closed and len(shape.points) > 2:
        area = shapely.Polygon(shape.points)
        if area.is_valid and thickness(area) <= THIN:
            faces.append(_Face([*shape.points, shape.points[0]], where, solid=True))
            return
        if area.is_valid and thickness(area) <= THICKEST:
            draft.wall(shape.points, where)
            return
    points = [*shape.points, shape.points[0]] if shape.closed else shape.points
    if shape.width > 0.0:
        draft.wall(points, where, thickness=shape.width)
    elif len(points) > 1:
        faces.append(_Face(points, where))


def thickness(area: Any) -> float:
    """Return the mean thickness of a long polygon, m: twice its area over its outline."""
    return 2 * float(area.area) / float(area.length) if area.length else 0.0


def _add_faces(source: FloorSource, draft: FloorDraft, faces: Sequence[_Face], doors: Sequence[_DrawnDoor]) -> None:
    """Add the walls between lines, and the lines that are no face of one, open where doors are drawn on them."""
    import shapely  # noqa: PLC0415 - of an extra

    if not faces:
        return
    _check_crossings(source, faces)
    lines = [shapely.LineString(face.points) for face in faces if not face.solid]
    areas = shapely.get_parts(shapely.polygonize([*shapely.get_parts(shapely.node(shapely.union_all(lines)))]))
    solid = shapely.union_all([area for area in areas if thickness(area) <= THICKEST])
    for ring in outlines(solid):
        draft.wall(ring, "lines on wall layers")
    between = shapely.buffer(solid, 1e-4)
    rest = [
        shapely.Polygon(face.points) if face.solid else shapely.difference(shapely.LineString(face.points), between)
        for face in faces
    ]
    together = shapely.union_all(shapely.buffer(rest, 1e-4))
    gaps = shapely.union_all([gap for door in doors for gap in _gaps(door, together)])
    for face, left in zip(faces, shapely.difference(rest, gaps), strict=True):
        for ring in outlines(left):
            draft.wall(ring, face.where)
        for part in shapely.get_parts(left):
            if part.geom_type == "LineString" and part.length > 1e-3:
                draft.wall([(float(x), float(y)) for x, y in part.coords], face.where, thickness=LINE)


def _check_crossings(source: FloorSource, faces: Sequence[_Face]) -> None:
    """Check that lines can be cut at one another: each crossing makes new pieces.

    Raises:
        WireError: There are too many lines or crossings.
    """
    import shapely  # noqa: PLC0415 - of an extra

    pieces = [pair for face in faces for pair in pairwise(face.points)]
    if len(pieces) > MAX_LINES:
        raise source.error("", f"expected at most {MAX_LINES:,} pieces of lines on wall layers, got more", "too-many")
    segments = shapely.linestrings(pieces)
    tree = shapely.STRtree(segments)
    left = MAX_CROSSINGS + 3 * len(pieces)  # a piece touches itself and its neighbours
    for first in range(0, len(pieces), 200):
        left -= len(tree.query(segments[first : first + 200], predicate="intersects")[0])
        if left < 0:
            text = f"expected at most {MAX_CROSSINGS:,} crossings of lines on wall layers, got more"
            raise source.error("", text, "too-many")


def _gaps(door: _DrawnDoor, walls: Any) -> list[Any]:
    """Return what a door drawn on thin walls takes out of them; nothing if it is drawn in an opening."""
    import shapely  # noqa: PLC0415 - of an extra

    closed = [shapely.LineString([leaf.left, leaf.right]) for leaf in door.leaves]
    on_walls = [line for line in closed if all(walls.distance(shapely.Point(end)) <= MEETING for end in line.coords)]
    if any(walls.distance(line.interpolate(0.5, normalized=True)) > MEETING for line in on_walls):
        return []
    return [line.buffer(MEETING, cap_style="flat") for line in on_walls]


def _door(entity: Any, shapes: Sequence[Shape], where: str) -> _DrawnDoor | None:
    """Return the door that a block or an arc stands for, or None for something else on a layer of doors."""
    insert = entity.dxftype() == "INSERT"
    leaves = [leaf for shape in shapes for leaf in _leaves(shape)]
    if not leaves and insert:
        a, b, c, d = _box(entity, shapes)
        # Across the middle of the block, along its longer side.
        ends = (_middle(d, a), _middle(b, c)) if math.dist(a, b) >= math.dist(b, c) else (_middle(a, b), _middle(c, d))
        leaves = [Leaf(*ends, None)]
    return _DrawnDoor(str(entity.dxf.name) if insert else "door", where, leaves) if leaves else None


def _joined(doors: Sequence[_DrawnDoor]) -> Iterable[_DrawnDoor]:
    """Yield the doors, two whose leaves meet as one of two leaves."""
    rest = list(doors)
    while rest:
        door = rest.pop(0)
        for number, other in enumerate(rest):
            double = next((both for one in door.leaves for two in other.leaves if (both := _double(one, two))), None)
            if double is not None:
                del rest[number]
                yield _DrawnDoor(door.name, f"{door.where} and {other.where}", [double, *door.leaves, *other.leaves])
                break
        else:
            yield door


def _double(one: Leaf, two: Leaf) -> Leaf | None:
    """Return two leaves as one door if they meet when closed, and open to the same side."""
    if one.door is None or two.door is None or math.dist(one.right, two.right) > MEETING:
        return None
    together = math.dist(one.left, one.right) + math.dist(two.left, two.right)
    # The second leaf is drawn from the other jamb, so its sides are the other way round.
    same_side = one.door.swing_deg * two.door.swing_deg < 0
    if not same_side or abs(math.dist(one.left, two.left) - together) > MEETING:
        return None
    return Leaf(one.left, two.left, Door(kind="double-hinged", side="left", swing_deg=one.door.swing_deg))


def _leaves(shape: Shape) -> Iterable[Leaf]:
    """Yield how the arc of a leaf can be read: closed at either end, with the hinge in its middle."""
    if shape.arc is None or not LEAVES[0] <= shape.arc.radius <= LEAVES[1] or not 45 <= shape.arc.sweep <= 135:
        return
    hinge, ends = shape.arc.middle, (shape.points[0], shape.points[-1])
    for closed, turn in ((ends[0], shape.arc.sweep), (ends[1], -shape.arc.sweep)):
        # The hinge is the left jamb: the leaf opens along the heading if it turns anticlockwise from its closed end.
        yield Leaf(hinge, closed, Door(kind="hinged", side="left", swing_deg=round(turn, 1)))


def _box(insert: Any, shapes: Sequence[Shape]) -> list[Point]:
    """Return the corners of the box around a block, along the axes of the block."""
    angle = math.radians(float(insert.dxf.rotation))
    cos, sin = math.cos(angle), math.sin(angle)
    points = [(x * cos + y * sin, y * cos - x * sin) for shape in shapes for x, y in shape.points]
    west, east = min(x for x, _ in points), max(x for x, _ in points)
    south, north = min(y for _, y in points), max(y for _, y in points)
    return [
        (x * cos - y * sin, x * sin + y * cos) for x, y in ((west, south), (east, south), (east, north), (west, north))
    ]


def _middle(a: Point, b: Point) -> Point:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
