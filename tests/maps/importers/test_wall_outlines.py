from __future__ import annotations

import random

import pytest
import shapely

from intellwheels_maps.importers.wall_outlines import outlines


@pytest.mark.parametrize("holes", [0, 1, 5, 40])
def test_pieces_without_holes_are_together_the_area(holes: int) -> None:
    draw = random.Random(holes)
    area = shapely.box(0.0, 0.0, 50.0, 30.0)
    for _ in range(holes):
        x, y = draw.uniform(1.0, 45.0), draw.uniform(1.0, 25.0)
        area = area.difference(shapely.box(x, y, x + draw.uniform(0.5, 4.0), y + draw.uniform(0.5, 4.0)))
    pieces = [shapely.Polygon(ring) for ring in outlines(area)]
    assert all(piece.is_valid for piece in pieces)
    assert sum(piece.area for piece in pieces) == pytest.approx(area.area, rel=1e-12)
    assert shapely.symmetric_difference(shapely.union_all(pieces), area).area < 1e-9


def test_points_and_lines_are_dropped() -> None:
    assert list(outlines(shapely.LineString([(0, 0), (1, 1)]))) == []
    assert list(outlines(shapely.Polygon())) == []
