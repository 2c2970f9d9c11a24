from __future__ import annotations

import math

import pytest

from intellwheels_agents.bridge.stick_motion import LONGEST, StickMotion
from intellwheels_maps import robot

CHAIR = robot("intellwheels")
PER_METRE = CHAIR.encoder_ticks / (math.pi * CHAIR.wheel_diameter)


def rolled(motion: StickMotion, seconds: float, start: float = 0.0) -> tuple[int, int]:
    counts = (0, 0)
    for step in range(round(seconds / 0.02) + 1):
        counts = motion.advance(start + 0.02 * step)
    return counts


def test_wheels_roll_at_the_share_of_the_top_speed_that_the_user_has_chosen() -> None:
    motion = StickMotion(CHAIR)
    motion.speed_limit = 0.5
    motion.advance(0.0)
    motion.obey(1.0, 0.0)
    left, right = rolled(motion, 10.0)
    assert left == right
    assert left / PER_METRE == pytest.approx(0.5 * CHAIR.top_speed * 10.0, rel=0.03)


def test_a_turn_to_the_left_rolls_the_right_wheel_forward() -> None:
    motion = StickMotion(CHAIR)
    motion.advance(0.0)
    motion.obey(0.0, 0.5)
    left, right = rolled(motion, 2.0)
    assert left == -right
    assert right > 0


def test_the_chair_stands_while_nothing_is_heard() -> None:
    motion = StickMotion(CHAIR)
    motion.advance(0.0)
    motion.obey(1.0, 0.0)
    before = rolled(motion, 1.0)
    assert motion.advance(1.0 + 2.0 * LONGEST) == before
