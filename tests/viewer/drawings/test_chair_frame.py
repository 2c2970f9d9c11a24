from __future__ import annotations

import pytest

from intellwheels_viewer.drawings.chair_frame import arm_ends, arm_height, frame_of
from tests.viewer.drawings.cast import robot


def test_the_seat_is_the_highest_part_above_the_floor() -> None:
    frame = frame_of(robot("intellwheels"))
    assert (frame.rear, frame.front, frame.wide) == pytest.approx((-0.4, 0.3, 0.6))
    assert frame.seat < arm_height(frame) < frame.back < frame.hull.top
    start, end = arm_ends(frame)
    assert frame.rear < start < end < frame.hull.front
