"""Walls become convex pieces that cover what was drawn, exactly and always in the same way."""

import math

import numpy as np
import pytest
import shapely
from shapely.geometry import LineString, Polygon
from shapely.ops import unary_union

from intellwheels_maps.crossing import Point
from intellwheels_server.world.kernels.arrays import (
    CELL,
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    NORMAL_X,
    NORMAL_Y,
    OFFSET,
    OUTER,
    PIECE_THICKNESS,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    WALL,
    Walls,
)
from intellwheels_server.world.wall_pieces import Line, Solid, walls_from
from tests.every_case import every_case


def polygons(walls: Walls) -> list[Polygon]:
    return [Polygon(walls.edges[link[FIRST_EDGE] : link[END_EDGE], [EDGE_X, EDGE_Y]]) for link in walls.links]


L_SHAPE = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (3.0, 4.0), (3.0, 1.0), (0.0, 1.0)]
COMB = [(0.0, 0.0), (7.0, 0.0), (7.0, 3.0), (6.0, 3.0), (6.0, 1.0), (4.0, 1.0), (4.0, 3.0), (3.0, 3.0), (3.0, 1.0),
        (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]  # fmt: skip
STAR = [
    ((1.0 if k % 2 else 3.0) * math.cos(k * math.pi / 7), (1.0 if k % 2 else 3.0) * math.sin(k * math.pi / 7))
    for k in range(14)
]


@pytest.mark.parametrize("corners", [L_SHAPE, COMB, STAR, L_SHAPE[::-1], [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]])
def test_pieces_of_a_solid_are_convex_and_cover_it_without_overlap(corners: list[Point]) -> None:
    pieces = polygons(walls_from([Solid(corners, 0.0, 2.5)]))
    assert all(piece.exterior.is_ccw for piece in pieces)
    assert all(piece.convex_hull.area == pytest.approx(piece.area, rel=1e-12) for piece in pieces)
    assert sum(piece.area for piece in pieces) == pytest.approx(Polygon(corners).area, rel=1e-12)
    assert unary_union(pieces).symmetric_difference(Polygon(corners)).area < 1e-12


def test_pieces_of_random_star_shapes_cover_them_exactly() -> None:
    rng = np.random.default_rng(3)
    for _ in range(40):
        angles = np.sort(rng.uniform(0, 2 * math.pi, 12))
        radii = rng.uniform(0.3, 3.0, 12)
        corners = [(float(r * math.cos(t)), float(r * math.sin(t))) for r, t in zip(radii, angles, strict=True)]
        if not Polygon(corners).is_valid:
            continue
        pieces = polygons(walls_from([Solid(corners, 0.0, 1.0)]))
        assert sum(piece.area for piece in pieces) == pytest.approx(Polygon(corners).area, rel=1e-9)
        assert unary_union(pieces).symmetric_difference(Polygon(corners)).area < 1e-9


def test_convex_solid_stays_one_piece_with_its_own_corners() -> None:
    walls = walls_from([Solid([(2, -5), (3, -5), (3, 5), (2, 5)], 0.0, 2.5)])
    assert walls.edges[:, [EDGE_X, EDGE_Y]].tolist() == [[2, -5], [3, -5], [3, 5], [2, 5]]
    assert walls.edges[:, [NORMAL_X, NORMAL_Y, OFFSET]].tolist() == [[0, -1, 5], [1, 0, 3], [0, 1, 5], [-1, 0, -2]]


def test_corner_in_a_straight_side_is_left_out() -> None:
    walls = walls_from([Solid([(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)], 0.0, 1.0)])
    assert walls.links[:, [FIRST_EDGE, END_EDGE]].tolist() == [[0, 4]]


def test_corners_stay_exact_in_pieces() -> None:
    walls = walls_from([Solid(COMB, 0.0, 1.0)])
    assert {tuple(corner) for corner in walls.edges[:, [EDGE_X, EDGE_Y]].tolist()} == set(COMB)


def test_outer_edges_of_the_pieces_are_the_outline() -> None:
    edges = walls_from([Solid(L_SHAPE, 0.0, 1.0)]).edges
    outer = edges[edges[:, OUTER] == 1.0]
    assert len(outer) < len(edges)
    assert set(edges[:, OUTER].tolist()) == {0.0, 1.0}
    corners = {tuple(corner) for corner in outer[:, [EDGE_X, EDGE_Y]].tolist()}
    assert corners == {(float(x), float(y)) for x, y in L_SHAPE}
    assert len(outer) == len(L_SHAPE)


def test_index_of_a_piece_is_the_place_of_its_wall() -> None:
    walls = walls_from([Solid(L_SHAPE, 0.0, 1.0), Line([(9.0, 0.0), (9.0, 3.0), (12.0, 3.0)], 0.1, 0.0, 2.0)])
    assert walls.links[:, WALL].tolist() == [0, 0, 1, 1, 1]


@every_case("turn_deg", [-150, -120, -90, -45, -10, 10, 30, 60, 89, 90, 100, 135, 170])
def test_no_gap_opens_where_a_line_turns(turn_deg: float) -> None:
    turn = math.radians(turn_deg)
    corners = [(0.0, 0.0), (2.0, 0.0), (2.0 + 2.0 * math.cos(turn), 2.0 * math.sin(turn))]
    body = unary_union(polygons(walls_from([Line(corners, 0.2, 0.0, 2.0)])))
    # Mitred up to a right angle, cut flat beyond, as shapely's own buffers of the two styles.
    style = "mitre" if abs(turn_deg) <= 90 else "bevel"
    expected = LineString(corners).buffer(0.1, cap_style="flat", join_style=style)
    assert expected.difference(body).area < 1e-9
    assert body.difference(expected).area < 1e-9


def test_closed_line_has_no_gap_at_its_first_corner() -> None:
    corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0), (0.0, 0.0)]
    body = unary_union(polygons(walls_from([Line(corners, 0.1, 0.0, 2.0)])))
    ring = shapely.box(-0.05, -0.05, 4.05, 3.05).difference(shapely.box(0.05, 0.05, 3.95, 2.95))
    assert body.symmetric_difference(ring).area < 1e-12


def test_thickness_is_between_sides_that_face_away_from_each_other() -> None:
    line = walls_from([Line([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)], 0.1, 0.0, 2.0)])
    # A joint is no wall by itself: whoever goes through it is in the next.
    assert line.pieces[:, PIECE_THICKNESS].tolist() == [pytest.approx(0.1), pytest.approx(0.1), math.inf]
    assert walls_from([Solid(L_SHAPE, 0.0, 1.0)]).pieces[:, PIECE_THICKNESS].tolist() == [1.0, 1.0]
    round_corner = [(math.cos(k * 0.01), math.sin(k * 0.01)) for k in range(158)]
    quarter = walls_from([Solid([(0.0, 0.0), *round_corner], 0.0, 1.0)])
    assert quarter.pieces[:, PIECE_THICKNESS].min() > 0.5


def test_every_piece_is_in_every_cell_its_box_overlaps() -> None:
    rng = np.random.default_rng(5)
    lines = [Line([tuple(p), tuple(p + rng.normal(0, 2, 2))], 0.1, 0.0, 2.0) for p in rng.uniform(0, 30, (60, 2))]
    walls = walls_from(lines)
    columns, rows = walls.cells[0], walls.cells[1]
    x0, y0, size = walls.frame.tolist()
    assert size == walls.frame[CELL] == 1.0
    for row in range(rows):
        for column in range(columns):
            at = 2 + row * columns + column
            held = set(walls.cells[walls.cells[at] : walls.cells[at + 1]].tolist())
            inside = (
                (walls.pieces[:, PIECE_X0] < x0 + size * (column + 1))
                & (walls.pieces[:, PIECE_X1] >= x0 + size * column)
                & (walls.pieces[:, PIECE_Y0] < y0 + size * (row + 1))
                & (walls.pieces[:, PIECE_Y1] >= y0 + size * row)
            )
            assert held == set(np.nonzero(inside)[0].tolist())


def test_no_walls_make_an_empty_grid() -> None:
    walls = walls_from([])
    assert walls.pieces.shape == (0, 7)
    assert walls.cells.tolist() == [1, 1, 4, 4]


def test_large_floor_gets_larger_cells() -> None:
    walls = walls_from([Line([(-9000.0, -9000.0), (9000.0, 9000.0)], 0.1, 0.0, 2.0)])
    assert walls.cells[0] * walls.cells[1] <= 1 << 16


@every_case(
    ("wall", "words"),
    [
        (Solid([(0, 0), (1, 0)], 0, 1), "wall 0: a solid needs at least 3 corners, got 2"),
        (Solid([(0, 0), (1, 0), (0, 0)], 0, 1), "wall 0: a solid needs at least 3 corners, got 2"),
        (Solid([(0, 0), (1, 0), (2, 0)], 0, 1), "wall 0: expected an area, got corners in one line"),
        (Solid([(0, 0), (1, 1), (1, 0), (0, 1)], 0, 1), "wall 0: expected a polygon that does not cross itself, got "),
        (Solid([(0, 0), (math.nan, 1), (1, 0)], 0, 1), "wall 0: expected finite corners, got "),
        (Solid([(0, 0), (1, 1), (1, 0)], 2, 1), "wall 0: expected a top above its bottom, got bottom 2 and top 1"),
        (Line([(0, 0)], 0.1, 0, 1), "wall 0: a line needs at least 2 corners, got 1"),
        (Line([(0, 0), (0, 0)], 0.1, 0, 1), "wall 0: expected corners that differ, got "),
        (Line([(0, 0), (1, 0)], 0.0, 0, 1), "wall 0: expected a thickness of at least 1e-09 m, got 0"),
        (Line([(1, 0), (1, 1)], 1e-20, 0, 1), "wall 0: expected a thickness of at least 1e-09 m, got 1e-20"),
        (Line([(0, 0), (1e-200, 0)], 0.1, 0, 1), "wall 0: expected corners at least 1e-09 m apart, got "),
        (Solid([(0, 0), (1, 0), (1, 1e-200)], 0, 1), "wall 0: expected corners at least 1e-09 m apart, got "),
    ],
)
def test_impossible_wall_is_refused_with_the_reason(wall: Solid | Line, words: str) -> None:
    with pytest.raises(ValueError, match=words[:-1] if words.endswith(" ") else f"^{words}$"):
        walls_from([wall])


def test_long_slanting_walls_do_not_fill_a_grid_of_small_cells() -> None:
    walls = walls_from([Line([(0.0, 0.0), (9_000.0 + k, 9_000.0)], 0.1, 0.0, 2.5) for k in range(200)])
    assert len(walls.cells) < 1 << 21


def test_solid_with_a_hole_in_its_ring_is_cut_round_the_hole() -> None:
    outside = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    hole = [(2.0, 2.0), (2.0, 8.0), (8.0, 8.0), (8.0, 2.0)]
    ring = [*outside, outside[0], *hole, hole[0]]
    for corners in (ring, ring[::-1], ring[6:] + ring[:6], [*ring, ring[0]]):
        walls = walls_from([Solid(corners, 0.0, 2.0)])
        pieces = [shapely.Polygon(walls.edges[first:end, :2]) for first, end, _ in walls.links]
        assert all(piece.is_valid for piece in pieces)
        assert sum(piece.area for piece in pieces) == pytest.approx(64.0)
        cut = shapely.union_all(pieces)
        assert cut.equals(shapely.Polygon(outside, [hole]))
        # The wall is 2 m thick wherever it is thin; the edge that leads to the hole is inside it.
        assert min(walls.pieces[:, PIECE_THICKNESS]) == pytest.approx(2.0)


def test_hole_may_touch_the_outside_and_holes_may_hang_on_one_another() -> None:
    outside = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    one, two = [(2.0, 2.0), (2.0, 4.0), (4.0, 4.0), (4.0, 2.0)], [(5.0, 5.0), (5.0, 7.0), (7.0, 5.0)]
    chain = [*outside, outside[0], one[0], one[1], one[2], *two, two[0], one[2], one[3], one[0]]
    touching = [*outside, outside[0], (4.0, 8.0), (8.0, 4.0)]
    for corners, area in ((chain, 94.0), (touching, 76.0)):
        walls = walls_from([Solid(corners, 0.0, 2.0)])
        pieces = [shapely.Polygon(walls.edges[first:end, :2]) for first, end, _ in walls.links]
        assert sum(piece.area for piece in pieces) == pytest.approx(area)
        assert shapely.union_all(pieces).area == pytest.approx(area)
