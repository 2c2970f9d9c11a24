from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_maps import library
from intellwheels_maps.check import wall_pieces
from intellwheels_viewer.drawings.building_colours import DAY
from intellwheels_viewer.drawings.door_frames import CASING, HEAD, ceiling_at, fittings

ROOM, WARD = library.floor("room"), library.floor("ward")


def test_a_frame_leaves_the_clear_width_and_stands_on_both_faces() -> None:
    frame = fittings(ROOM, None, DAY)[DAY.frame].vertices
    below = frame[frame[:, 2] < 1.0]
    inner = abs(below[:, 1] - 4.0).min()
    assert inner == pytest.approx(0.55, abs=0.005)
    assert float(abs(below[:, 1] - 4.0).max()) == pytest.approx(0.55 + CASING)
    assert float(below[:, 0].min()) == pytest.approx(8.95 - 0.018, abs=0.012)
    assert float(below[:, 0].max()) == pytest.approx(9.05 + 0.018, abs=0.012)


def test_only_a_whole_wall_has_a_lintel_and_nobody_can_touch_it() -> None:
    whole = fittings(ROOM, None, DAY)
    lintel = whole[next(rgb for rgb in whole if rgb != DAY.frame)].vertices
    assert (float(lintel[:, 2].min()), float(lintel[:, 2].max())) == pytest.approx((HEAD, 2.5))
    assert ceiling_at(ROOM, ROOM.doorway[0]) == 2.5
    cut = fittings(ROOM, 1.1, DAY)
    assert list(cut) == [DAY.frame]
    assert float(cut[DAY.frame].vertices[:, 2].max()) == pytest.approx(1.1)


def test_every_frame_of_the_ward_lies_at_a_wall() -> None:
    corners = np.array([corner for wall in WARD.wall for piece in wall_pieces(wall) for corner in piece])
    low, high = corners.min(axis=0) - 0.05, corners.max(axis=0) + 0.05
    frames = fittings(WARD, 1.1, DAY)[DAY.frame].vertices
    assert (frames[:, :2] >= low).all()
    assert (frames[:, :2] <= high).all()
    for doorway in WARD.doorway:
        reach = np.hypot(frames[:, 0] - doorway.x, frames[:, 1] - doorway.y)
        assert reach.min() == pytest.approx(doorway.width / 2, abs=0.02)
    assert all(math.isfinite(value) for value in frames.flat)
