from __future__ import annotations

import pytest

from intellwheels_maps import library
from intellwheels_viewer.drawings import street

STREET = library.floor("crossing")


def test_the_bars_of_a_crossing_lie_along_the_traffic_and_within_it() -> None:
    _, crossing = STREET.zone
    bars = street.bars(crossing, 0.0)
    assert len(bars.faces) == 2 * 6
    assert bars.vertices.min(axis=0)[:2] == pytest.approx([-1.9, -2.75])
    assert bars.vertices.max(axis=0)[:2] == pytest.approx([1.9, 2.75])


def test_kerbs_are_at_both_edges_and_end_at_the_crossing() -> None:
    kerbs = street.kerbs(STREET).vertices
    assert sorted({round(float(y), 2) for y in kerbs[:, 1]}) == [-3.0, -2.84, 2.84, 3.0]
    assert not ((kerbs[:, 0] > -1.99) & (kerbs[:, 0] < 1.99)).any()
    assert float(kerbs[:, 0].max()) == pytest.approx(30.0)


def test_the_middle_of_the_street_has_dashes_but_not_on_the_crossing() -> None:
    lines = street.lines(STREET).vertices
    middle = lines[abs(lines[:, 1]) < 0.07]
    assert len(middle) == 4 * 14
    assert float(abs(middle[:, 0]).min()) > 2.0


def test_a_building_has_neither() -> None:
    ward = library.floor("ward")
    assert len(street.kerbs(ward).faces) == len(street.lines(ward).faces) == 0
