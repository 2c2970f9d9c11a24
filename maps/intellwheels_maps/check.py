"""Checks of maps, robots and scenes that need geometry or another file. Pure: documents in, findings out.

The rules for one or several fields belong to the contract (`intellwheels_schemas.rules`) and are checked first.

A finding gives the path of its element (`Map.Wall[3]`); `library` adds the file and the line.
A check reports only errors that make a document unusable, and certain mistakes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from intellwheels_maps.crossing import Point
from intellwheels_maps.keyholes import find_fault
from intellwheels_maps.plane_geometry import bounds, contains, edges, is_within, side
from intellwheels_schemas.codec import MAX_BYTES, VERSION, Encoding, encode
from intellwheels_schemas.explain import did_you_mean
from intellwheels_schemas.messages import Corner, Doorway, Map, Robot, Scene, Wall

# m: contact cannot tell corners apart that are closer.
_SHORTEST = 1e-9
# m: doorways and walls are drawn by hand, and drawings are accurate to a centimetre.
_WIDTH_TOLERANCE = 0.01
# m: a wall farther away than this belongs to another opening.
_JAMB_REACH = 5.0

_Piece = tuple[list[Point], tuple[float, float, float, float]]
"""A polygon and its bounds."""


# Bytes: the simulator delivers its map in one message, which has a key and a header too.
MAP_BYTES = MAX_BYTES - 4096


class Finding(NamedTuple):
    """An error in a document.

    Attributes:
        element: The path from the root, with list indices from 0: `Map.Wall[3]`.
        text: What is wrong, what was expected and what was found.
    """

    element: str
    text: str


def check_map(document: Map) -> list[Finding]:
    """Return the errors in a map; empty if it is valid."""
    findings = list(_check_shapes(document))
    findings += _duplicates("Map.Doorway", "doorway", [doorway.name for doorway in document.doorway])
    findings += _duplicates("Map.Obstacle", "obstacle", [obstacle.name for obstacle in document.obstacle])
    findings += _duplicates("Map.Zone", "zone", [zone.name for zone in document.zone])
    places = document.grid.position if document.grid else ()
    findings += _duplicates("Map.Grid.Position", "place", [place.name for place in places])
    findings += _duplicates("Map.Route", "route", [route.name for route in document.route])
    findings += _check_routes(document)
    findings += _check_size(document)
    if not findings:
        # The geometry below relies on valid shapes.
        findings += _check_doorways(document)
        findings += _check_places(document)
    return findings


def check_robot(document: Robot) -> list[Finding]:
    """Return the errors in a robot file; empty if it is valid."""
    findings = []
    if document.format is None:
        findings.append(Finding("Robot", f"expected Format {VERSION!r} in a robot file, got none"))
    if document.position is not None:
        findings.append(
            Finding("Robot.Position", "expected no Position in a robot file: it is set when an agent joins")
        )
    return findings


def check_scene(document: Scene, floor: Map) -> list[Finding]:
    """Return the errors in a scene; empty if it is valid.

    Args:
        document: The scene.
        floor: The map that the scene's `Map` gives.
    """
    findings = []
    known = sorted(place.name for place in floor.grid.position) if floor.grid else []
    expected = f"expected one of the places of {floor.name!r} ({', '.join(known) or 'none'})"
    taken: dict[str, str] = {}
    for index, cast in enumerate(document.cast):
        element = f"Scene.Cast[{index}]"
        if cast.place is None:
            continue
        if cast.place not in known:
            findings.append(Finding(element, f"{expected}, got {cast.place!r}{did_you_mean(cast.place, known)}"))
        elif cast.place in taken:
            findings.append(Finding(element, f"place {cast.place!r} is already taken by agent {taken[cast.place]!r}"))
        taken.setdefault(cast.place, cast.name)
    reaches = document.end.reach if document.end else ()
    for index, reach in enumerate(reaches):
        if reach.place not in known:
            findings.append(
                Finding(
                    f"Scene.End.Reach[{index}]", f"{expected}, got {reach.place!r}{did_you_mean(reach.place, known)}"
                )
            )
    if document.hold and document.hold.reached and not reaches:
        findings.append(Finding("Scene.Hold", "Reached: expected a Reach in End, got none"))
    return findings


def opening(document: Map, doorway: Doorway) -> tuple[float, float]:
    """Return the distances from the centre of a doorway to the walls on its left and on its right.

    Returns:
        Two distances in m, left first; inf if no wall is within 5 m, both 0 if the centre is inside a wall.
    """
    return _opening([piece for wall in document.wall for piece in _bounded(wall_pieces(wall))], doorway)


def _opening(pieces: Iterable[_Piece], doorway: Doorway) -> tuple[float, float]:
    heading = math.radians(doorway.heading_deg)
    left = (-math.sin(heading), math.cos(heading))
    centre = (doorway.x, doorway.y)
    near = [piece for piece, box in pieces if is_within(box, centre, _JAMB_REACH + _WIDTH_TOLERANCE)]
    if any(contains(piece, centre) for piece in near):
        return 0.0, 0.0
    return _reach(centre, left, near), _reach(centre, (-left[0], -left[1]), near)


def _bounded(pieces: Iterable[list[Point]]) -> list[_Piece]:
    return [(piece, bounds(piece)) for piece in pieces]


def wall_pieces(wall: Wall) -> list[list[Point]]:
    """Return the polygons of a wall: the polygon itself, or for a line one rectangle with flat ends per segment."""
    if wall.thickness is None:
        return [ring_of(wall.corner)]
    corners = points_of(wall.corner)
    half = wall.thickness / 2
    pieces = []
    for (ax, ay), (bx, by) in pairwise(corners):
        length = math.hypot(bx - ax, by - ay)
        nx, ny = -(by - ay) / length * half, (bx - ax) / length * half
        pieces.append([(ax - nx, ay - ny), (bx - nx, by - ny), (bx + nx, by + ny), (ax + nx, ay + ny)])
    return pieces


def points_of(corners: Iterable[Corner]) -> list[Point]:
    """Return corners as points, in metres."""
    return [(corner.x, corner.y) for corner in corners]


def ring_of(corners: Iterable[Corner]) -> list[Point]:
    """Return the corners of a polygon as points, in metres, without a last one that repeats the first."""
    points = points_of(corners)
    return points[:-1] if len(points) > 3 and points[0] == points[-1] else points


# ---------------------------------------------------------------- parts of the checks


def _check_size(document: Map) -> Iterator[Finding]:
    for encoding in (Encoding.JSON, Encoding.XML):
        size = len(encode(document, encoding))
        if size > MAP_BYTES:
            text = (
                f"expected a map of at most {MAP_BYTES:,} bytes as one message in {encoding.name}, got {size:,}; "
                "use fewer corners or fewer digits"
            )
            yield Finding("Map", text)
            return


def _check_shapes(document: Map) -> Iterator[Finding]:
    for index, wall in enumerate(document.wall):
        yield from _check_corners(f"Map.Wall[{index}]", "wall", wall.corner, closed=wall.thickness is None)
        if wall.thickness is not None and wall.thickness < _SHORTEST:
            text = f"wall: expected a Thickness of at least {_SHORTEST} m, got {_plain(wall.thickness)}"
            yield Finding(f"Map.Wall[{index}]", text)
    for index, obstacle in enumerate(document.obstacle):
        yield from _check_corners(f"Map.Obstacle[{index}]", f"obstacle {obstacle.name!r}", obstacle.corner, closed=True)
    for index, zone in enumerate(document.zone):
        yield from _check_corners(f"Map.Zone[{index}]", f"zone {zone.name!r}", zone.corner, closed=True)


def _check_corners(element: str, what: str, corners: Sequence[Corner], *, closed: bool) -> Iterator[Finding]:
    points = ring_of(corners) if closed else points_of(corners)
    for index, (one, other) in enumerate(edges(points) if closed else pairwise(points)):
        if math.dist(one, other) < _SHORTEST:
            place = f"X {_plain(one[0])} Y {_plain(one[1])}"
            fault = "the same corner twice in a row" if one == other else f"corners less than {_SHORTEST} m apart"
            yield Finding(f"{element}.Corner[{(index + 1) % len(points)}]", f"{what} has {fault}, {place}")
            return
    if closed and (crossing := find_fault(points)):
        yield Finding(element, f"{what} crosses itself: edges {crossing[0]} and {crossing[1]}, counted from 0")
    elif closed and _twice_area(points) == 0.0:
        yield Finding(element, f"{what} has no area: its corners are on one line")


def _duplicates(element: str, what: str, names: Sequence[str]) -> list[Finding]:
    findings = []
    seen: set[str] = set()
    for index, name in enumerate(names):
        if name in seen:
            findings.append(Finding(f"{element}[{index}]", f"{what} {name!r} exists twice, expected different names"))
        seen.add(name)
    return findings


def _check_routes(document: Map) -> Iterator[Finding]:
    known = {place.name for place in document.grid.position} if document.grid else set[str]()
    for index, route in enumerate(document.route):
        element = f"Map.Route[{index}]"
        if len(route.places) < 2:
            yield Finding(element, f"route {route.name!r}: expected at least 2 places, got {len(route.places)}")
        for place in dict.fromkeys(route.places):
            if place not in known:
                text = f"route {route.name!r}: expected places of the map, got {place!r}{did_you_mean(place, known)}"
                yield Finding(element, text)


def _check_doorways(document: Map) -> Iterator[Finding]:
    pieces = [piece for wall in document.wall for piece in _bounded(wall_pieces(wall))] if document.doorway else []
    for index, doorway in enumerate(document.doorway):
        element = f"Map.Doorway[{index}]"
        left, right = _opening(pieces, doorway)
        if left == 0.0:
            yield Finding(element, f"doorway {doorway.name!r}: expected an opening, got the inside of a wall")
        elif math.inf in (left, right):
            yield Finding(element, f"doorway {doorway.name!r}: expected a wall within {_JAMB_REACH} m on each side")
        elif abs(left + right - doorway.width) > _WIDTH_TOLERANCE:
            width = _plain(round(left + right, 3))
            text = f"doorway {doorway.name!r}: expected Width {width}, the gap between its walls, got {doorway.width}"
            yield Finding(element, text)
        elif abs(left - right) > _WIDTH_TOLERANCE:
            sides = f"{_plain(round(left, 3))} m left and {_plain(round(right, 3))} m right"
            yield Finding(element, f"doorway {doorway.name!r}: expected the middle of the opening, got {sides}")


def _check_places(document: Map) -> Iterator[Finding]:
    walls = [(f"Wall[{index}]", piece) for index, wall in enumerate(document.wall) for piece in wall_pieces(wall)]
    walls += [(f"obstacle {obstacle.name!r}", ring_of(obstacle.corner)) for obstacle in document.obstacle]
    solids = [(what, piece, bounds(piece)) for what, piece in walls]
    for index, place in enumerate(document.grid.position if document.grid else ()):
        for what, piece, box in solids:
            if is_within(box, (place.x, place.y)) and contains(piece, (place.x, place.y)):
                yield Finding(f"Map.Grid.Position[{index}]", f"place {place.name!r} is inside {what}")
                break


def _plain(value: float) -> str:
    return repr(float(value))


# ---------------------------------------------------------------- plane geometry


def _twice_area(points: Sequence[Point]) -> float:
    return math.fsum(ax * by - bx * ay for (ax, ay), (bx, by) in edges(points))


def _reach(start: Point, direction: Point, pieces: Iterable[Sequence[Point]]) -> float:
    """Return the distance from a point to the first edge along a unit vector, m; inf beyond `_JAMB_REACH`."""
    end = (start[0] + direction[0] * _JAMB_REACH, start[1] + direction[1] * _JAMB_REACH)
    nearest = math.inf
    for piece in pieces:
        for a, b in edges(piece):
            a_side, b_side = side(start, end, a), side(start, end, b)
            if (a_side > 0) == (b_side > 0):
                continue
            share = a_side / (a_side - b_side)
            hit = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
            distance = (hit[0] - start[0]) * direction[0] + (hit[1] - start[1]) * direction[1]
            if 0.0 <= distance <= _JAMB_REACH:
                nearest = min(nearest, distance)
    return nearest
