from __future__ import annotations

from intellwheels_maps.plane_geometry import contains, edges, side

COMB = [(0.0, 0.0), (5.0, 0.0), (5.0, 3.0), (4.0, 3.0), (4.0, 1.0), (3.0, 1.0), (3.0, 3.0), (0.0, 3.0)]


def test_edges_of_a_ring_close_it() -> None:
    assert list(edges([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]))[-1] == ((0.0, 1.0), (0.0, 0.0))


def test_side_is_positive_on_the_left() -> None:
    assert [side((0.0, 0.0), (1.0, 0.0), (0.5, y)) for y in (1.0, 0.0, -1.0)] == [1.0, 0.0, -1.0]


def test_a_point_between_the_teeth_of_a_comb_is_outside() -> None:
    assert [contains(COMB, point) for point in ((1.0, 2.0), (3.5, 2.0), (4.5, 2.0), (6.0, 2.0))] == [
        True, False, True, False,
    ]  # fmt: skip
