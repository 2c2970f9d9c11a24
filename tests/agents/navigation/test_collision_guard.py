"""What the guard of `aided` and `seek` lets a body do. Tests of these minds drive it among walls."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from intellwheels_agents.navigation.collision_guard import CollisionGuard
from intellwheels_maps import robot
from intellwheels_schemas.messages import Measures
from tests.agents.kinematics import RUN, context


def test_chair_that_brakes_over_more_than_it_sees_drives_slowly_and_says_so() -> None:
    slow = msgspec.structs.replace(robot("rear-wheel"), acceleration_limit=0.3)
    near = tuple(msgspec.structs.replace(one, max_range=0.6) for one in slow.proximity)
    for body, mode in ((slow, "aided"), (msgspec.structs.replace(slow, proximity=near), "slow")):
        guard = CollisionGuard(context(body), "aided", 0.8)
        guard.perceive(Measures(run=RUN, tick=0, time=0.0))
        answer = guard.drive(0.8, 0.0, "aided")
        assert answer.mode == mode
        assert (answer.left_motor == pytest.approx(0.8)) is (mode == "aided")


def test_strip_is_free_up_to_the_nearest_point_in_it() -> None:
    guard = CollisionGuard(context(robot("rear-wheel")), "seek", 0.6, by_itself=True)
    straight, left = (0.0, 1.0), (1.0, 0.0)
    assert guard.free_lengths([straight, left], 0.3, 2.0, 9.0) == [2.0, 2.0]
    guard.points = np.array([(1.5, 0.2), (1.2, -0.29), (1.1, 0.31), (0.1, 1.8), (-0.2, -0.5)])
    assert guard.free_lengths([straight, left], 0.3, 2.0, 9.0) == [1.2, 1.8]
    # Beyond the reach, and too far to be looked at.
    assert guard.free_lengths([straight, left], 0.3, 1.0, 9.0) == [1.0, 1.0]
    assert guard.free_lengths([straight, left], 0.3, 2.0, math.hypot(1.2, 0.29)) == [2.0, 2.0]
