"""Checks where the agents of a scene start: no two bodies in one place, and none inside a wall. Pure.

It finds what is certain. The simulator decides exactly, when an agent joins.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Final

from intellwheels_maps.check import Finding, ring_of, wall_pieces
from intellwheels_maps.crossing import Point
from intellwheels_maps.plane_geometry import contains, edges, side
from intellwheels_schemas.messages import Map, Place, Robot, Scene
from intellwheels_schemas.rules import parts_of

SLACK: Final = 0.01
"""Depth of an overlap that is left to the simulator, m: bodies may touch."""

Box = tuple[list[Point], float, float]
"""The corners of an upright box or wall, m, and the heights of its lower and upper faces."""


def check_starts(scene: Scene, floor: Map, robots: Mapping[str, Robot]) -> list[Finding]:
    """Return which agents of a scene start in one another or in a wall.

    Args:
        scene: The scene.
        floor: Its map.
        robots: The body of each agent, by name. Others are not checked.
    """
    places = {place.name: place for place in floor.grid.position} if floor.grid else {}
    bodies = [
        (index, cast.name, boxes_at(robots[cast.name], places[cast.place]))
        for index, cast in enumerate(scene.cast)
        if cast.name in robots and cast.place in places
    ]
    findings = []
    walls = list(wall_boxes(floor))
    for index, name, boxes in bodies:
        inside = next((what for what, wall in walls if any(overlap(box, wall) for box in boxes)), None)
        if inside is not None:
            findings.append(
                Finding(f"Scene.Cast[{index}]", f"agent {name!r}: expected a free place, got one in {inside}")
            )
    for (_, first, some), (index, second, others) in combinations(bodies, 2):
        if any(overlap(one, other) for one in some for other in others):
            text = f"agent {second!r}: expected a free place, got one that overlaps agent {first!r}"
            findings.append(Finding(f"Scene.Cast[{index}]", text))
    return findings


def boxes_at(robot: Robot, place: Place) -> list[Box]:
    """Return the boxes of a body that stands at a place, each smaller by the slack on each side."""
    heading = math.radians(place.heading_deg)
    cos, sin = math.cos(heading), math.sin(heading)
    boxes = []
    for part in parts_of(robot):
        half_length, half_width = max(part.length / 2.0 - SLACK, 0.0), max(part.width / 2.0 - SLACK, 0.0)
        corners = []
        for along, across in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
            x, y = part.x + along * half_length, part.y + across * half_width
            corners.append((place.x + cos * x - sin * y, place.y + sin * x + cos * y))
        boxes.append((corners, part.bottom, part.top))
    return boxes


def wall_boxes(floor: Map) -> Iterator[tuple[str, Box]]:
    """Yield the name and the shape of each piece of the walls of a map, then of its obstacles."""
    for index, wall in enumerate(floor.wall):
        for piece in wall_pieces(wall):
            yield f"Wall[{index}]", (piece, wall.bottom, wall.height)
    for obstacle in floor.obstacle:
        yield f"obstacle {obstacle.name!r}", (ring_of(obstacle.corner), obstacle.bottom, obstacle.top)


def overlap(one: Box, other: Box) -> bool:
    """Return whether two boxes, or a box and a wall, have a common inside."""
    (corners, bottom, top), (others, low, high) = one, other
    if top <= low or high <= bottom:
        return False
    if any(_apart(corners, others, axis) for axis in ((1.0, 0.0), (0.0, 1.0))):
        return False
    if _is_convex(corners) and _is_convex(others):
        # Two convex shapes are apart if they are apart along the normal of one of their edges.
        both = [*edges(corners), *edges(others)]
        return not any(_apart(corners, others, (a[1] - b[1], b[0] - a[0])) for a, b in both)
    return (
        contains(corners, others[0])
        or contains(others, corners[0])
        or any(_cross(a, b, c, d) for a, b in edges(corners) for c, d in edges(others))
    )


def _apart(ring: Sequence[Point], other: Sequence[Point], axis: Point) -> bool:
    """Return whether two shapes are apart along an axis, or only touch."""
    mine = [x * axis[0] + y * axis[1] for x, y in ring]
    its = [x * axis[0] + y * axis[1] for x, y in other]
    return max(mine) <= min(its) or max(its) <= min(mine)


def _is_convex(ring: Sequence[Point]) -> bool:
    corners = zip(ring, [*ring[1:], ring[0]], [*ring[2:], *ring[:2]], strict=True)
    turns = [side(a, b, c) for a, b, c in corners]
    return min(turns) >= 0.0 or max(turns) <= 0.0


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Return whether two segments cross inside both."""
    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0
