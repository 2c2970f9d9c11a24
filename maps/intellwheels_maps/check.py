"""What a schema cannot say of a floor, a robot or a scene. Pure: messages in, findings out.

A finding names its element by the path of the wire's names (`Map.Wall[3]`); who has the file adds
its name and line. A check reports what makes the document useless or surely mistaken, never taste.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

from intellwheels_schemas.messages import Corner, Doorway, Map, Robot, Scene, Wall

Point: TypeAlias = tuple[float, float]

# A doorway is drawn by hand, its walls too: a centimetre is the accuracy of a plan.
_WIDTH_TOLERANCE = 0.01
# A jamb farther away than this belongs to another opening.
_JAMB_REACH = 5.0


class Finding(NamedTuple):
    """Something wrong in a document.

    Attributes:
        element: The path from the root, lists by index from 0: `Map.Wall[3]`.
        text: What is wrong, what was expected, what came.
    """

    element: str
    text: str


def check_map(document: Map) -> list[Finding]:
    """Return what is wrong with a floor, in the order of its elements; empty if nothing is."""
    findings = list(_check_shapes(document))
    findings += _duplicates("Map.Doorway", "doorway", [doorway.name for doorway in document.doorway])
    findings += _duplicates("Map.Obstacle", "obstacle", [obstacle.name for obstacle in document.obstacle])
    findings += _duplicates("Map.Zone", "zone", [zone.name for zone in document.zone])
    places = document.grid.position if document.grid else ()
    findings += _duplicates("Map.Grid.Position", "place", [place.name for place in places])
    if not findings:
        # Shapes are sound here, which the geometry below relies on.
        findings += _check_doorways(document)
        findings += _check_places(document)
    return findings


def check_robot(document: Robot) -> list[Finding]:
    """Return what is wrong with a robot file; empty if nothing is."""
    findings = []
    if document.format is None:
        findings.append(Finding("Robot", "robot file needs Format, expected 'iw.v1', got none"))
    for field in ("name", "instance", "place", "position", "crew"):
        if getattr(document, field) is not None:
            findings.append(Finding("Robot", f"{field.title()} is given at joining, expected none in a file"))
    one_part = {"Length": document.length, "Width": document.width}
    if document.part and any(value is not None for value in (*one_part.values(), document.center, document.top)):
        findings.append(Finding("Robot", "robot is either Parts or Length, Width, Center, Top, got both"))
    if not document.part:
        findings += [
            Finding("Robot", f"robot without Parts needs {name}, got none")
            for name, value in one_part.items()
            if value is None
        ]
    findings += [
        Finding(f"Robot.Part[{index}]", f"part needs Bottom below Top, got {part.bottom} and {part.top}")
        for index, part in enumerate(document.part)
        if part.bottom >= part.top
    ]
    findings += [
        Finding(f"Robot.Proximity[{index}]", f"sensor needs MinRange below MaxRange, got {low} and {high}")
        for index, (low, high) in enumerate((sensor.min_range, sensor.max_range) for sensor in document.proximity)
        if low >= high
    ]
    seen: set[str] = set()
    for element, sensor_id in _sensor_ids(document):
        if sensor_id in seen:
            findings.append(Finding(element, f"sensor {sensor_id!r} is there twice, expected ids that differ"))
        seen.add(sensor_id)
    return findings


def check_scene(document: Scene, floor: Map) -> list[Finding]:
    """Return what is wrong with a scene on its floor; empty if nothing is.

    Args:
        document: The scene.
        floor: The floor that the scene's `Map` names.
    """
    places = {place.name for place in floor.grid.position} if floor.grid else set()
    agents = [cast.name for cast in document.cast]
    findings = _duplicates("Scene.Cast", "agent", agents)
    taken: dict[str, str] = {}
    for index, cast in enumerate(document.cast):
        element = f"Scene.Cast[{index}]"
        if cast.place is None:
            continue
        if cast.place not in places:
            findings.append(Finding(element, _expected(f"place of {floor.name!r}", places, cast.place)))
        elif cast.place in taken:
            findings.append(Finding(element, f"place {cast.place!r} is already that of agent {taken[cast.place]!r}"))
        taken.setdefault(cast.place, cast.name)
    for index, reach in enumerate(document.end.reach if document.end else ()):
        element = f"Scene.End.Reach[{index}]"
        if reach.agent not in agents:
            findings.append(Finding(element, _expected("agent", agents, reach.agent)))
        if reach.place not in places:
            findings.append(Finding(element, _expected(f"place of {floor.name!r}", places, reach.place)))
    if document.hold and document.hold.reached and not (document.end and document.end.reach):
        findings.append(Finding("Scene.Hold", "Reached needs a Reach in End, got none"))
    return findings


def opening(document: Map, doorway: Doorway) -> tuple[float, float]:
    """Return how far the walls are from a doorway's centre, to its left and to its right.

    Returns:
        Two distances in m across the way through, left first; inf where no wall is within 5 m, 0 in a wall.
    """
    heading = math.radians(doorway.heading_deg)
    left = (-math.sin(heading), math.cos(heading))
    centre = (doorway.x, doorway.y)
    pieces = [piece for wall in document.wall for piece in wall_pieces(wall)]
    if any(_inside(centre, piece) for piece in pieces):
        return 0.0, 0.0
    return _reach(centre, left, pieces), _reach(centre, (-left[0], -left[1]), pieces)


def wall_pieces(wall: Wall) -> list[list[Point]]:
    """Return a wall's plan: the polygon itself, or one rectangle with flat ends for each stretch of a line."""
    corners = _points(wall.corner)
    if wall.thickness is None:
        return [corners]
    half = wall.thickness / 2
    pieces = []
    for (ax, ay), (bx, by) in zip(corners, corners[1:], strict=False):
        length = math.hypot(bx - ax, by - ay)
        nx, ny = -(by - ay) / length * half, (bx - ax) / length * half
        pieces.append([(ax - nx, ay - ny), (bx - nx, by - ny), (bx + nx, by + ny), (ax + nx, ay + ny)])
    return pieces


# ---------------------------------------------------------------- parts of the checks


def _check_shapes(document: Map) -> Iterator[Finding]:
    for index, wall in enumerate(document.wall):
        element = f"Map.Wall[{index}]"
        least = 3 if wall.thickness is None else 2
        yield from _check_corners(element, "wall", wall.corner, least, closed=wall.thickness is None)
    for index, obstacle in enumerate(document.obstacle):
        element = f"Map.Obstacle[{index}]"
        yield from _check_corners(element, f"obstacle {obstacle.name!r}", obstacle.corner, 3, closed=True)
        if obstacle.bottom >= obstacle.top:
            text = f"obstacle {obstacle.name!r} needs Bottom below Top, got {obstacle.bottom} and {obstacle.top}"
            yield Finding(element, text)
    for index, zone in enumerate(document.zone):
        yield from _check_corners(f"Map.Zone[{index}]", f"zone {zone.name!r}", zone.corner, 3, closed=True)


def _check_corners(
    element: str, what: str, corners: Sequence[Corner], least: int, *, closed: bool
) -> Iterator[Finding]:
    if len(corners) < least:
        yield Finding(element, f"{what} needs at least {least} corners, got {len(corners)}")
        return
    points = _points(corners)
    for index, (one, other) in enumerate(_edges(points) if closed else zip(points, points[1:], strict=False)):
        if one == other:
            text = f"{what} has the same corner twice running, X {_plain(one[0])} Y {_plain(one[1])}"
            yield Finding(f"{element}.Corner[{(index + 1) % len(points)}]", text)
            return
    if closed and (crossing := _crossing(points)):
        yield Finding(element, f"{what} crosses itself, edges {crossing[0]} and {crossing[1]} (from 0)")
    elif closed and _twice_area(points) == 0.0:
        yield Finding(element, f"{what} has no area, expected corners that span one")


def _duplicates(element: str, what: str, names: Sequence[str]) -> list[Finding]:
    findings = []
    seen: set[str] = set()
    for index, name in enumerate(names):
        if name in seen:
            findings.append(Finding(f"{element}[{index}]", f"{what} {name!r} is there twice, expected names that differ"))
        seen.add(name)
    return findings


def _check_doorways(document: Map) -> Iterator[Finding]:
    for index, doorway in enumerate(document.doorway):
        element = f"Map.Doorway[{index}]"
        left, right = opening(document, doorway)
        if left == 0.0:
            yield Finding(element, f"doorway {doorway.name!r} is inside a wall, expected an opening")
        elif math.inf in (left, right):
            yield Finding(element, f"doorway {doorway.name!r} needs a wall within {_JAMB_REACH} m on either side")
        elif abs(left + right - doorway.width) > _WIDTH_TOLERANCE:
            width = _plain(round(left + right, 3))
            text = f"doorway {doorway.name!r}: expected Width {width}, the opening of its walls, got {doorway.width}"
            yield Finding(element, text)
        elif abs(left - right) > _WIDTH_TOLERANCE:
            sides = f"{_plain(round(left, 3))} m left and {_plain(round(right, 3))} m right"
            yield Finding(element, f"doorway {doorway.name!r}: expected the middle of its opening, got {sides}")


def _check_places(document: Map) -> Iterator[Finding]:
    walls = [(f"wall {index}", piece) for index, wall in enumerate(document.wall) for piece in wall_pieces(wall)]
    walls += [(f"obstacle {obstacle.name!r}", _points(obstacle.corner)) for obstacle in document.obstacle]
    for index, place in enumerate(document.grid.position if document.grid else ()):
        for what, piece in walls:
            if _inside((place.x, place.y), piece):
                yield Finding(f"Map.Grid.Position[{index}]", f"place {place.name!r} is inside {what}")
                break


def _sensor_ids(document: Robot) -> Iterator[tuple[str, str]]:
    kinds = {
        "Proximity": document.proximity, "Lidar": document.lidar, "Encoders": document.encoders,
        "Odometry": document.odometry, "Compass": document.compass, "GPS": document.gps, "IMU": document.imu,
        "Beacon": document.beacon, "Ground": document.ground, "Bumper": document.bumper, "Truth": document.truth,
    }  # fmt: skip
    for kind, sensors in kinds.items():
        for index, sensor in enumerate(sensors):
            yield f"Robot.{kind}[{index}]", sensor.id


def _expected(what: str, known: Iterable[str], got: str) -> str:
    return f"expected a {what} ({', '.join(sorted(known)) or 'there are none'}), got {got!r}"


def _plain(value: float) -> str:
    return repr(float(value))


# ---------------------------------------------------------------- plane geometry


def _points(corners: Iterable[Corner]) -> list[Point]:
    return [(corner.x, corner.y) for corner in corners]


def _edges(points: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    return zip(points, [*points[1:], points[0]], strict=True)


def _twice_area(points: Sequence[Point]) -> float:
    return math.fsum(ax * by - bx * ay for (ax, ay), (bx, by) in _edges(points))


def _side(a: Point, b: Point, c: Point) -> float:
    """Return a value > 0 where c is left of the line from a to b, 0 on it."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _between(a: Point, b: Point, c: Point) -> bool:
    return min(a[0], b[0]) <= c[0] <= max(a[0], b[0]) and min(a[1], b[1]) <= c[1] <= max(a[1], b[1])


def _meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Return whether the closed segments ab and cd have a point in common."""
    c_side, d_side, a_side, b_side = _side(a, b, c), _side(a, b, d), _side(c, d, a), _side(c, d, b)
    if c_side * d_side < 0 and a_side * b_side < 0:
        return True
    ends = ((c_side, a, b, c), (d_side, a, b, d), (a_side, c, d, a), (b_side, c, d, b))
    return any(side == 0 and _between(one, other, point) for side, one, other, point in ends)


def _crossing(points: Sequence[Point]) -> tuple[int, int] | None:
    """Return the first two edges of a ring that touch and are no neighbours, or fold back on each other."""
    edges = list(_edges(points))
    count = len(edges)
    for one in range(count):
        a, b = edges[one]
        for other in range(one + 1, count):
            c, d = edges[other]
            if other == one + 1 or (one == 0 and other == count - 1):
                # Neighbours share a corner; they cross only by running back over each other.
                shared, before, after = (b, a, d) if other == one + 1 else (a, b, c)
                back = (before[0] - shared[0]) * (after[0] - shared[0]) + (before[1] - shared[1]) * (after[1] - shared[1])
                if count > 3 and _side(before, shared, after) == 0 and back > 0:
                    return one, other
            elif _meet(a, b, c, d):
                return one, other
    return None


def _inside(point: Point, ring: Sequence[Point]) -> bool:
    """Return whether a point is inside a ring; on its edge either may come out."""
    inside = False
    x, y = point
    for (ax, ay), (bx, by) in _edges(ring):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            inside = not inside
    return inside


def _reach(start: Point, direction: Point, pieces: Iterable[Sequence[Point]]) -> float:
    """Return the distance from a point to the first edge along a unit direction, inf beyond `_JAMB_REACH`."""
    end = (start[0] + direction[0] * _JAMB_REACH, start[1] + direction[1] * _JAMB_REACH)
    nearest = math.inf
    for piece in pieces:
        for a, b in _edges(piece):
            a_side, b_side = _side(start, end, a), _side(start, end, b)
            if (a_side > 0) == (b_side > 0):
                continue
            share = a_side / (a_side - b_side)
            hit = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
            distance = (hit[0] - start[0]) * direction[0] + (hit[1] - start[1]) * direction[1]
            if 0.0 <= distance <= _JAMB_REACH:
                nearest = min(nearest, distance)
    return nearest
