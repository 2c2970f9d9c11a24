"""The wedge is exact: GEOS, asked for the distance to solid and wedge together, says the same."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from shapely.geometry import MultiPoint, Point, Polygon

from intellwheels_server.world.kernels.wedge_distance import box_in_wedge, polygon_in_wedge
from intellwheels_server.world.wall_pieces import Solid, walls_from

_FAR = 50.0


def _wedge_polygon(x: float, y: float, direction: float, half: float) -> Polygon:
    """Return a wedge out to where nothing is, as straight pieces of at most a quarter turn."""
    if half >= math.pi:
        return Point(x, y).buffer(_FAR)
    pieces = max(4, math.ceil(half * 8))
    angles = np.linspace(direction - half, direction + half, pieces + 1)
    return Polygon([(x, y), *((x + _FAR * math.cos(a), y + _FAR * math.sin(a)) for a in angles)])


def _seen_by_geos(solid: Polygon, x: float, y: float, direction: float, half: float) -> float:
    seen = shapely.intersection(solid, _wedge_polygon(x, y, direction, half))
    return math.inf if seen.is_empty else float(shapely.distance(Point(x, y), seen))


def _box(x: float, y: float, heading: float, length: float, width: float) -> Polygon:
    c, s = math.cos(heading), math.sin(heading)
    corners = [(-length, -width), (length, -width), (length, width), (-length, width)]
    return Polygon([(x + (c * u - s * v) / 2, y + (s * u + c * v) / 2) for u, v in corners])


def _to_box(x: float, y: float, direction: float, half: float, box: tuple[float, float, float, float, float]) -> float:
    bx, by, heading, length, width = box
    c, s = math.cos(heading), math.sin(heading)
    square = box_in_wedge(
        c * (x - bx) + s * (y - by),
        c * (y - by) - s * (x - bx),
        math.cos(direction - heading),
        math.sin(direction - heading),
        math.cos(half),
        math.sin(half) if half < math.pi else 0.0,
        length / 2,
        width / 2,
    )
    return math.sqrt(square)


def _to_polygon(solid: Polygon, x: float, y: float, direction: float, half: float) -> float:
    edges = walls_from([Solid(list(solid.exterior.coords), 0.0, 1.0)]).edges
    square = polygon_in_wedge(
        edges,
        0,
        len(edges),
        x,
        y,
        math.cos(direction),
        math.sin(direction),
        math.cos(half),
        math.sin(half) if half < math.pi else 0.0,
    )
    return math.sqrt(square)


def compare(scenes: int, seed: int) -> tuple[float, int, int]:
    """Return the largest difference from GEOS, how many scenes saw something and how many were skipped.

    A scene is skipped when the solid only touches the wedge: a cone 1e-9 rad wider or narrower
    then sees it or not.
    """
    random = np.random.default_rng(seed)
    worst, seen, skipped = 0.0, 0, 0
    for scene in range(scenes):
        x, y = random.uniform(-10, 10, 2)
        direction = random.uniform(-math.pi, math.pi)
        half = random.choice([random.uniform(0.005, math.pi), math.radians(15), math.pi / 2, math.pi])
        away, bearing = 5 * random.random() ** 2, random.uniform(-math.pi, math.pi)
        bx, by = x + away * math.cos(bearing), y + away * math.sin(bearing)
        if scene % 2:
            # Tables' legs, posts, chairs, long walls.
            box = (bx, by, random.uniform(-math.pi, math.pi), *(random.choice([0.02, 0.1, 0.7, 1.2, 8.0], 2)))
            solid = _box(*box)
            ours = _to_box(x, y, direction, half, box)
            straight = _to_polygon(solid, x, y, direction, half)
            agreed = ours == straight or abs(ours - straight) < 1e-9
        else:
            solid = MultiPoint(random.normal(0, random.choice([0.05, 1.0]), (7, 2)) + np.array([bx, by])).convex_hull
            ours = _to_polygon(solid, x, y, direction, half)
            agreed = True
        theirs = _seen_by_geos(solid, x, y, direction, half)
        if math.isinf(ours) != math.isinf(theirs) or not agreed:
            narrow = _seen_by_geos(solid, x, y, direction, half * (1 - 1e-9))
            wide = _seen_by_geos(solid, x, y, direction, min(half * (1 + 1e-9), math.pi))
            assert math.isinf(narrow) != math.isinf(wide), (scene, ours, theirs)
            skipped += 1
        elif not math.isinf(ours):
            worst = max(worst, abs(ours - theirs))
            seen += 1
    return worst, seen, skipped


def test_wedge_agrees_with_geos() -> None:
    worst, seen, skipped = compare(1000, seed=3)
    assert worst < 1e-9
    assert seen > 250
    assert skipped <= 1


@pytest.mark.soak
def test_wedge_agrees_with_geos_on_twenty_thousand_scenes() -> None:
    worst, seen, skipped = compare(20_000, seed=4)
    assert worst < 1e-9
    assert seen > 5000
    assert skipped <= 2


def test_thin_leg_inside_the_cone_is_seen() -> None:
    # A leg of 2 mm at 3.9 m anywhere in a cone of 30 degrees, where a fan of 31 rays leaves gaps of 68 mm.
    for bearing in np.linspace(-math.radians(14.9), math.radians(14.9), 997):
        leg = (3.9 * math.cos(bearing), 3.9 * math.sin(bearing), 0.3, 0.002, 0.002)
        assert _to_box(0.0, 0.0, 0.0, math.radians(15), leg) == pytest.approx(3.9, abs=0.002)


def test_wall_ahead_is_its_perpendicular_distance_and_beside_the_cone_not() -> None:
    # A wall 2 m to the left, 100 m long: seen by a cone that reaches 90 degrees, at an edge by a narrower one.
    wall = (0.0, 2.5, 0.0, 100.0, 1.0)
    assert _to_box(0.0, 0.0, 0.0, math.pi / 2, wall) == pytest.approx(2.0, abs=1e-15)
    assert _to_box(0.0, 0.0, 0.0, math.radians(30), wall) == pytest.approx(4.0, abs=1e-14)
    assert _to_box(0.0, 0.0, -0.6, math.radians(30), wall) == math.inf


def test_apex_inside_or_on_the_edge_is_at_distance_zero() -> None:
    square = Polygon([(0, 0), (2, 0), (2, 2), (0, 2)])
    for x, y in [(1.0, 1.0), (0.0, 1.0), (2.0, 2.0)]:
        assert _to_polygon(square, x, y, 0.3, 0.2) == 0.0
        assert _to_box(x, y, 0.3, 0.2, (1.0, 1.0, 0.0, 2.0, 2.0)) == 0.0


def test_cone_of_a_whole_turn_sees_behind() -> None:
    assert _to_box(0.0, 0.0, 0.0, math.pi, (-3.0, 0.0, 0.0, 2.0, 2.0)) == 2.0


def test_nothing_is_missed_where_two_edges_meet() -> None:
    # Both sides of the wedge pass the near corner of a diamond within rounding.
    corners = Polygon([(1.0, 0.0), (2.0, -1.0), (3.0, 0.0), (2.0, 1.0)])
    for direction in np.linspace(-1e-15, 1e-15, 41):
        assert _to_polygon(corners, 0.0, 0.0, direction, 1e-16) == pytest.approx(1.0, abs=1e-12)
