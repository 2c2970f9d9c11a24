from __future__ import annotations

import pytest

from intellwheels_schemas.messages import Robot
from intellwheels_viewer.drawings.car_look import car


def test_a_car_stands_on_its_wheels() -> None:
    model = car(Robot(kind="car", length=4.0, width=1.8, top=1.5))
    assert float(model.dark.vertices[:, 2].min()) == pytest.approx(0.0, abs=0.01)
    assert float(model.paint.vertices[:, 2].min()) > 0.1


def test_its_glass_is_above_its_body() -> None:
    model = car(Robot(kind="car", length=4.0, width=1.8, top=1.5))
    assert float(model.light.vertices[:, 2].max()) > 1.4
