from __future__ import annotations

import pytest

from intellwheels_viewer.drawings.table_look import table
from tests.viewer.drawings.cast import robot


def test_the_top_is_wood_and_each_leg_stands_on_the_floor() -> None:
    model = table(robot("table"))
    assert float(model.paint.vertices[:, 2].min()) == pytest.approx(0.69)
    assert len(model.light.faces) == 4 * 12
    assert float(model.light.vertices[:, 2].min()) == 0.0


def test_a_table_of_one_block_is_all_wood() -> None:
    model = table(robot("table", part=(), length=1.0, width=0.5, top=0.7))
    assert len(model.light.faces) == 0
    assert len(model.paint.faces) > 0
