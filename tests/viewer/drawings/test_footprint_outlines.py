from __future__ import annotations

import pytest

from intellwheels_viewer.drawings.body_look import Extent
from intellwheels_viewer.drawings.footprint_outlines import centre, outline, tint

HULL = Extent(rear=-0.25, front=0.85, right=-0.31, left=0.31, bottom=0.0, top=1.3)


def test_the_frames_outer_edge_is_the_bodys_own_and_the_heading_mark_is_before_it() -> None:
    flat = outline(HULL).vertices
    assert float(flat[:, 0].min()) == pytest.approx(-0.25)
    assert float(abs(flat[:, 1]).max()) == pytest.approx(0.31)
    tip = flat[flat[:, 0].argmax()]
    assert 0.9 < tip[0] < 1.1
    assert tip[1] == pytest.approx(0.0)


def test_a_dashed_frame_has_gaps_and_the_same_edge() -> None:
    whole, dashed = outline(HULL), outline(HULL, dashed=True)
    assert dashed.vertices.min(axis=0) == pytest.approx(whole.vertices.min(axis=0))
    assert dashed.vertices.max(axis=0) == pytest.approx(whole.vertices.max(axis=0))
    assert len(dashed.faces) > len(whole.faces) + 20


def test_the_centre_of_movement_is_marked_at_the_origin() -> None:
    assert centre().vertices.mean(axis=0)[:2] == pytest.approx([0.0, 0.0], abs=0.01)


def test_a_tint_is_a_square_metre() -> None:
    assert (tint().vertices.max(axis=0) - tint().vertices.min(axis=0)).tolist() == [1.0, 1.0, 0.0]
