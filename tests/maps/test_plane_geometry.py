from __future__ import annotations

from intellwheels_maps.plane_geometry import bounds, contains, edges, is_within, side

COMB = [(0.0, 0.0), (5.0, 0.0), (5.0, 3.0), (4.0, 3.0), (4.0, 1.0), (3.0, 1.0), (3.0, 3.0), (0.0, 3.0)]


def test_edges_of_a_ring_close_it() -> None:
    assert list(edges([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]))[-1] == ((0.0, 1.0), (0.0, 0.0))


def test_side_is_positive_on_the_left() -> None:
    assert [side((0.0, 0.0), (1.0, 0.0), (0.5, y)) for y in (1.0, 0.0, -1.0)] == [1.0, 0.0, -1.0]


def test_a_point_between_the_teeth_of_a_comb_is_outside() -> None:
    assert [contains(COMB, point) for point in ((1.0, 2.0), (3.5, 2.0), (4.5, 2.0), (6.0, 2.0))] == [
        True, False, True, False,
    ]  # fmt: skip


def test_bounds_hold_all_points_and_a_margin_goes_all_round() -> None:
    box = bounds(COMB)
    assert box == (0.0, 5.0, 0.0, 3.0)
    assert [is_within(box, point) for point in ((0.0, 3.0), (5.1, 1.0), (1.0, -0.1))] == [True, False, False]
    assert [is_within(box, point, 0.2) for point in ((5.1, 3.1), (5.3, 1.0), (1.0, -0.3))] == [True, False, False]
