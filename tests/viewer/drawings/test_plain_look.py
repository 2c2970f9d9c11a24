from __future__ import annotations

import pytest

from intellwheels_schemas.messages import Robot
from intellwheels_viewer.drawings.plain_look import plain
from tests.viewer.drawings.cast import robot


def test_a_crate_is_its_box() -> None:
    model = plain(robot("crate"))
    assert [float(each) for each in model.paint.vertices.max(axis=0)] == pytest.approx([0.3, 0.2, 0.5])
    assert len(model.light.faces) == 0


def test_what_goes_by_itself_has_an_arrow_on_top() -> None:
    arrow = plain(Robot(kind="robot", top_speed=1.0, length=0.6, width=0.4, top=0.5)).light.vertices
    assert float(arrow[:, 2].max()) == pytest.approx(0.51)
    assert float(arrow[:, 0].max()) == pytest.approx(0.12)
