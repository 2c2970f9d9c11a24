from __future__ import annotations

import math

import numpy as np
import pytest
import viser

from intellwheels_viewer.drawings.selection import Selection, ring_of, rings
from tests.viewer.drawings.cast import entity, node, robot


def test_the_ring_is_around_the_whole_footprint() -> None:
    x, y, radius = ring_of(robot("rear-wheel"))
    assert (x, y) == pytest.approx((0.3003, 0.0))
    assert radius > math.hypot(1.1, 0.62) / 2


def test_the_dark_ring_shows_on_both_sides_of_the_yellow_one() -> None:
    yellow, dark = (np.hypot(*shape.vertices[:, :2].T) for shape in rings(1.0))
    assert dark.min() < yellow.min() == pytest.approx(1.0)
    assert dark.max() > yellow.max()


def test_the_ring_follows_and_is_made_anew_only_for_another_size(scene: viser.SceneApi) -> None:
    selection = Selection(scene)
    selection.show(robot("rear-wheel"), entity("a", 1.0, 2.0, math.pi))
    ring = node(scene, "/selection/ring")
    assert ring.position == pytest.approx([0.6997, 2.0, 0.0])
    selection.show(None, None)
    assert not ring.visible
    selection.show(robot("rear-wheel"), entity("a", 5.0))
    assert node(scene, "/selection/ring") is ring
    assert ring.visible
    selection.show(robot("table"), entity("table"))
    assert node(scene, "/selection/ring") is not ring
