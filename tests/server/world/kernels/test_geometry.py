"""Depth of boxes and wall pieces, against GEOS and against cases that are exact."""

import math
from typing import Any

import numpy as np
import pytest
import shapely

from intellwheels_server.world.kernels import geometry
from intellwheels_server.world.kernels.arrays import PIECE_X0, Box, Floats, part_rows
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.wall_pieces import Solid, walls_from
from tests.every_case import every_case

NO_FLOOR = -math.inf


def depth(a: tuple[float, ...], b: tuple[float, ...], floor: float = NO_FLOOR) -> float:
    """Return the depth of two boxes given as x, y, heading, half length, half width."""
    (ax, ay, ah, al, aw), (bx, by, bh, bl, bw) = a, b
    a_s, ac = sincos(ah)
    bs, bc = sincos(bh)
    return float(geometry.box_depth(ax, ay, ac, a_s, al, aw, bx, by, bc, bs, bl, bw, floor))


def random_boxes(rng: np.random.Generator, count: int) -> Floats:
    return np.column_stack(
        [rng.uniform(0, 2.2, (count, 2)), rng.uniform(-math.pi, math.pi, count), rng.uniform(0.02, 0.7, (count, 2))]
    )


def outlines(boxes: Floats) -> Any:
    c, s = np.cos(boxes[:, 2]), np.sin(boxes[:, 2])
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    u, v = boxes[:, None, 3] * signs[:, 0], boxes[:, None, 4] * signs[:, 1]
    x = boxes[:, None, 0] + c[:, None] * u - s[:, None] * v
    y = boxes[:, None, 1] + s[:, None] * u + c[:, None] * v
    return shapely.polygons(np.stack([x, y], axis=-1))


@pytest.mark.parametrize("pairs", [20_000, pytest.param(100_000, marks=pytest.mark.soak)])
def test_overlap_of_random_pairs_is_that_of_geos(pairs: int) -> None:
    rng = np.random.default_rng(100)
    one, other = random_boxes(rng, pairs), random_boxes(rng, pairs)
    depths = np.array([depth(a, b) for a, b in zip(one.tolist(), other.tolist(), strict=True)])
    meet = shapely.intersects(outlines(one), outlines(other))
    # Within 1e-9 of touching rounding may decide either way.
    clear = np.abs(depths) > 1e-9
    assert (~clear).sum() <= 10
    assert 0.2 < meet.mean() < 0.8
    assert ((depths > 0.0) == meet)[clear].all()


def test_overlap_with_wall_pieces_is_that_of_geos() -> None:
    rng = np.random.default_rng(7)
    boxes = random_boxes(rng, 20_000)
    hull = np.array([[0.2, 0.3], [1.1, 0.0], [1.9, 0.6], [1.8, 1.7], [0.7, 1.9]])
    walls = walls_from([Solid([(float(x), float(y)) for x, y in hull], 0.0, 1.0)])
    assert walls.pieces[0, PIECE_X0] == 0.2
    depths = []
    for x, y, h, hl, hw in boxes.tolist():
        s, c = sincos(h)
        depths.append(geometry.piece_depth(walls.links, walls.edges, 0, x, y, c, s, hl, hw, NO_FLOOR))
    clear = np.abs(np.array(depths)) > 1e-9
    assert ((np.array(depths) > 0.0) == shapely.intersects(outlines(boxes), shapely.Polygon(hull)))[clear].all()


@every_case(
    ("a", "b", "expected"),
    [
        # side by side: touching, one apart, one in
        ((0, 0, 0, 2, 1), (4, 0, 0, 2, 1), 0.0),
        ((0, 0, 0, 2, 1), (5, 0, 0, 2, 1), -1.0),
        ((0, 0, 0, 2, 1), (3, 0, 0, 2, 1), 1.0),
        # parallel edges: along a whole side, and shifted along it
        ((0, 0, 0, 2, 1), (0, 2, 0, 2, 1), 0.0),
        ((0, 0, 0, 2, 1), (1, 2, 0, 2, 1), 0.0),
        # corner to corner
        ((0, 0, 0, 2, 1), (4, 2, 0, 2, 1), 0.0),
        # one inside the other, centred and not; the same box twice
        ((0, 0, 0, 4, 3), (0, 0, 0, 2, 1), 4.0),
        ((0, 0, 0, 4, 3), (1, 0, 0, 2, 1), 4.0),
        ((0, 0, 0, 2, 1), (0, 0, 0, 2, 1), 2.0),
        # a cross
        ((0, 0, 0, 4, 1), (0, 0, 0, 1, 4), 5.0),
    ],
)
def test_integer_coordinates_are_exact(a: tuple[float, ...], b: tuple[float, ...], expected: float) -> None:
    assert depth(a, b) == expected
    assert depth(b, a) == expected


@pytest.mark.parametrize(
    ("box", "expected"),
    [((0, 0, 2, 1), 1.0), ((-2, 0, 2, 1), -1.0), ((-1, 0, 2, 1), 0.0), ((3, 0, 1, 1), 3.0), ((3, 5, 1, 1), 0.0)],
)
def test_integer_coordinates_against_a_wall_are_exact(box: tuple[float, ...], expected: float) -> None:
    walls = walls_from([Solid([(1, -4), (5, -4), (5, 4), (1, 4)], 0.0, 1.0)])
    x, y, hl, hw = box
    assert geometry.piece_depth(walls.links, walls.edges, 0, x, y, 1.0, 0.0, hl, hw, NO_FLOOR) == expected


def test_depth_is_the_same_from_both_sides_to_the_bit() -> None:
    rng = np.random.default_rng(11)
    one, other = random_boxes(rng, 20_000).tolist(), random_boxes(rng, 20_000).tolist()
    assert all(depth(a, b) == depth(b, a) for a, b in zip(one, other, strict=True))


def test_floor_changes_nothing_above_it() -> None:
    rng = np.random.default_rng(12)
    for a, b in zip(random_boxes(rng, 5000).tolist(), random_boxes(rng, 5000).tolist(), strict=True):
        assert depth(a, b, 0.1) == max(depth(a, b), 0.1)


def bodies_depth(one: list[Box], pose: tuple[float, float, float], other: list[Box]) -> float:
    s, c = sincos(pose[2])
    a, b = part_rows(one), part_rows(other)
    return float(geometry.body_depth(a, 0, len(a), pose[0], pose[1], c, s, b, 0, len(b), 0.0, 0.0, 1.0, 0.0, NO_FLOOR))


def test_z_is_half_open_so_a_box_on_another_does_not_touch_it() -> None:
    low, high = [Box(0, 0, 2, 2, 0.0, 0.5)], [Box(0, 0, 2, 2, 0.5, 1.0)]
    assert bodies_depth(low, (0.0, 0.0, 0.0), high) == -math.inf
    assert bodies_depth([Box(0, 0, 2, 2, 0.0, 0.6)], (0.0, 0.0, 0.0), high) == 2.0


def test_body_is_as_deep_as_its_deepest_part() -> None:
    chair = [Box(0.25, 0.0, 1.2, 0.66, 0.0, 0.5), Box(0.0, 0.0, 0.7, 0.6, 0.5, 1.3)]
    post = [Box(0.0, 0.0, 0.1, 0.1, 0.0, 2.0)]
    # The footrests reach 0.85 m forward, the upper body 0.35.
    assert bodies_depth(chair, (-0.8, 0.0, 0.0), post) == pytest.approx(0.1)
    assert bodies_depth(chair[1:], (-0.8, 0.0, 0.0), post) == pytest.approx(-0.4)


def test_leaving_by_the_depth_along_the_normal_ends_the_overlap() -> None:
    rng = np.random.default_rng(13)
    a, b = part_rows([Box(0.1, 0.0, 1.0, 0.6, 0.0, 1.0)]), part_rows([Box(-0.4, 0.2, 0.3, 0.5, 0.0, 1.0)])
    parts = np.concatenate([a, b])
    for _ in range(2000):
        xa, ya, ha, hb = rng.uniform(-1, 1, 2).tolist() + rng.uniform(-3, 3, 2).tolist()
        (sa, ca), (sb, cb) = sincos(ha), sincos(hb)
        deep, nx, ny, part_a, part_b, px, py = geometry.body_contact(
            parts, 0, 1, xa, ya, ca, sa, 1, 2, 0.0, 0.0, cb, sb
        )
        assert (part_a, part_b) == (0, 1)
        assert math.hypot(nx, ny) == pytest.approx(1.0, abs=1e-12)
        assert deep == geometry.body_depth(a, 0, 1, xa, ya, ca, sa, b, 0, 1, 0.0, 0.0, cb, sb, NO_FLOOR)
        if deep > 0.0:
            xa, ya = xa + deep * nx, ya + deep * ny
            assert geometry.body_depth(a, 0, 1, xa, ya, ca, sa, b, 0, 1, 0.0, 0.0, cb, sb, NO_FLOOR) < 1e-12
            assert math.hypot(px, py) < 1.0


def test_box_leaves_a_wall_along_the_normal() -> None:
    rng = np.random.default_rng(14)
    walls = walls_from([Solid([(0.2, 0.3), (1.1, 0.0), (1.9, 0.6), (1.8, 1.7), (0.7, 1.9)], 0.0, 1.0)])
    for x, y, h, hl, hw in random_boxes(rng, 2000).tolist():
        s, c = sincos(h)
        args = walls.links, walls.edges, 0
        deep, nx, ny, px, py = geometry.piece_contact(*args, x, y, c, s, hl, hw)
        assert deep == geometry.piece_depth(*args, x, y, c, s, hl, hw, NO_FLOOR)
        if deep > 0.0:
            assert geometry.piece_depth(*args, x + deep * nx, y + deep * ny, c, s, hl, hw, NO_FLOOR) < 1e-12
            assert abs((px - x) * c + (py - y) * s) <= hl + 1e-12
            assert abs((py - y) * c - (px - x) * s) <= hw + 1e-12
