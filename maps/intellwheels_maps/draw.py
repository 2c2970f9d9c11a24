"""Draws a map as SVG. Pure: a `Map` in, text out.

The unit of the drawing is 1 cm, because renderers draw letters smaller than one unit badly. The y axis of SVG points
down and that of a map points up: only `_x`, `_y` and `_cm` convert metres to units of the drawing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from xml.sax.saxutils import escape

from intellwheels_maps.check import points_of, wall_pieces
from intellwheels_maps.crossing import Point
from intellwheels_schemas.messages import Doorway, Map, Place, Route, Wall, Zone

_MARGIN = 0.6  # m: margin around the walls
_PIXELS_A_METRE = 40
# Largest width and height of a drawing, in pixels. A whole hospital is scaled down to it.
_MAX_PIXELS = 4000
_STYLE = """
.zone{fill:#eef3f8;stroke:none}
.zone-title{fill:#5a6b7b;font-size:32px;text-anchor:middle}
.wall{fill:#30363d;stroke:none}
.line{fill:none;stroke:#30363d;stroke-linejoin:miter}
.obstacle{fill:#d9b98a;stroke:#8a6a3a;stroke-width:2}
.overhead{fill:#d9b98a;fill-opacity:0.45;stroke:#8a6a3a;stroke-width:2;stroke-dasharray:6 4}
.doorway{stroke:#2a8f5b;stroke-width:5;fill:none}
.place{stroke:#c0392b;stroke-width:3;fill:#ffffff}
.other{stroke:#3a5fc0;stroke-width:3;fill:#ffffff}
.name{fill:#30363d;font-size:18px}
.route{stroke:#8fb8c9;stroke-width:3;fill:none;stroke-dasharray:10 6}
.scale{stroke:#30363d;stroke-width:3}
"""


def draw(document: Map) -> str:
    """Return the drawing of a map as an SVG document.

    Zones and titles are drawn below obstacles, walls and doorways. A doorway is a line across the opening, with a short
    line in its heading. A place is a ring with a short line in its heading. It is red if a wheelchair may start there,
    and blue otherwise. Routes, and obstacles that do not reach down to the floor, are dashed.
    """
    obstacles = [(obstacle, points_of(obstacle.corner)) for obstacle in document.obstacle]
    zones = [(zone, points_of(zone.corner)) for zone in document.zone]
    places = document.grid.position if document.grid else ()
    pieces = [piece for wall in document.wall for piece in wall_pieces(wall)]
    shapes = [*pieces, *(ring for _, ring in obstacles), *(ring for _, ring in zones)]
    west, south, east, north = _bounds([*shapes, [(place.x, place.y) for place in places]])
    south -= 0.5  # m: a line below the map for the scale
    across, up = east - west, north - south
    pixels = min(_PIXELS_A_METRE, _MAX_PIXELS / max(across, up))
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{_x(west)} {_y(north)} {_cm(across)} {_cm(up)}"'
        f' width="{round(across * pixels)}" height="{round(up * pixels)}" font-family="sans-serif">',
        f"<title>{escape(document.title or document.name)}</title>",
        f"<style>{_STYLE}</style>",
        f'<rect x="{_x(west)}" y="{_y(north)}" width="{_cm(across)}" height="{_cm(up)}" fill="#ffffff"/>',
        *(_polygon("zone", ring) for _, ring in zones),
        *(
            _polygon("overhead" if obstacle.bottom > 0 else "obstacle", ring, obstacle.name)
            for obstacle, ring in obstacles
        ),
        *(_wall(wall) for wall in document.wall),
        *(_zone_title(zone, ring) for zone, ring in zones),
        *(_doorway(doorway) for doorway in document.doorway),
        *(_route(route, places) for route in document.route),
        *(_place(place) for place in places),
        _metre(west + _MARGIN, south + 0.3),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _cm(value: float) -> str:
    return f"{round(value * 100, 1) + 0.0:g}"


def _x(value: float) -> str:
    return _cm(value)


def _y(value: float) -> str:
    return _cm(-value)


def _bounds(shapes: Iterable[Sequence[Point]]) -> tuple[float, float, float, float]:
    points = [point for shape in shapes for point in shape] or [(0.0, 0.0)]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs) - _MARGIN, min(ys) - _MARGIN, max(xs) + _MARGIN, max(ys) + _MARGIN


def _list(points: Sequence[Point]) -> str:
    return " ".join(f"{_x(x)},{_y(y)}" for x, y in points)


def _polygon(kind: str, ring: Sequence[Point], title: str | None = None) -> str:
    inner = f"<title>{escape(title)}</title>" if title else ""
    return f'<polygon class="{kind}" points="{_list(ring)}">{inner}</polygon>'


def _wall(wall: Wall) -> str:
    points = points_of(wall.corner)
    if wall.thickness is None:
        return _polygon("wall", points)
    # A line that returns to its first corner is drawn as a polygon, so that this corner is also mitred.
    shape, points = ("polygon", points[:-1]) if points[0] == points[-1] else ("polyline", points)
    return f'<{shape} class="line" stroke-width="{_cm(wall.thickness)}" points="{_list(points)}"/>'


def _text(kind: str, x: float, y: float, text: str) -> str:
    return f'<text class="{kind}" x="{_x(x)}" y="{_y(y)}">{escape(text)}</text>'


def _line(kind: str, x0: float, y0: float, x1: float, y1: float) -> str:
    return f'<line class="{kind}" x1="{_x(x0)}" y1="{_y(y0)}" x2="{_x(x1)}" y2="{_y(y1)}"/>'


def _zone_title(zone: Zone, ring: Sequence[Point]) -> str:
    # Near the top edge, where beds and places are rare.
    middle = (min(x for x, _ in ring) + max(x for x, _ in ring)) / 2
    return _text("zone-title", middle, max(y for _, y in ring) - 0.4, zone.title or zone.name)


def _doorway(doorway: Doorway) -> str:
    heading = math.radians(doorway.heading_deg)
    cos, sin, half = math.cos(heading), math.sin(heading), doorway.width / 2
    x, y = doorway.x, doorway.y
    across = _line("doorway", x - half * sin, y + half * cos, x + half * sin, y - half * cos)
    through = _line("doorway", x, y, x + 0.3 * cos, y + 0.3 * sin)
    return f"<g><title>{escape(doorway.name)}</title>{across}{through}</g>"


def _place(place: Place) -> str:
    heading = math.radians(place.heading_deg)
    kind = "place" if not place.kinds or "wheelchair" in place.kinds else "other"
    ring = f'<circle class="{kind}" cx="{_x(place.x)}" cy="{_y(place.y)}" r="12"/>'
    stroke = _line(kind, place.x, place.y, place.x + 0.35 * math.cos(heading), place.y + 0.35 * math.sin(heading))
    return ring + stroke + _text("name", place.x + 0.16, place.y + 0.14, place.name)


def _route(route: Route, places: Sequence[Place]) -> str:
    at = {place.name: (place.x, place.y) for place in places}
    points = _list([at[name] for name in route.places if name in at])
    return f'<polyline class="route" points="{points}"><title>{escape(route.name)}</title></polyline>'


def _metre(x: float, y: float) -> str:
    return _line("scale", x, y, x + 1.0, y) + _text("name", x + 1.1, y - 0.06, "1 m")
