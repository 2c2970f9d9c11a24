import math

import pytest

from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.path_follower import BRAKING, MIN_SPEED, TURN_RATE, PathFollower, braking
from intellwheels_agents.pure_pursuit import Path
from intellwheels_schemas.messages import Position, Robot


def at(x: float, y: float, heading: float) -> Odometry:
    return Odometry(Robot(length=1.0, width=0.6), Position(x=x, y=y, heading=heading))


def test_straight_path_is_driven_straight_at_full_speed() -> None:
    steering = PathFollower(0.6).steer(Path([(0.0, 0.0), (10.0, 0.0)]), at(0.0, 0.0, 0.0), 10.0)
    assert steering == (0.6, 0.0, 0.0)
    assert not steering.turns


def test_beside_the_path_it_steers_back() -> None:
    steering = PathFollower(0.5).steer(Path([(0.0, 0.0), (10.0, 0.0)]), at(0.0, 0.1, 0.0), 10.0)
    reach = math.hypot(0.45, 0.1)
    # 2 y / L^2 of Coulter's paper, y = -0.1 to the right.
    assert steering.curvature == pytest.approx(-2.0 * 0.1 / reach**2)


def test_facing_away_from_the_path_it_turns_in_place_first() -> None:
    pilot, path = PathFollower(0.5), Path([(0.0, 0.0), (10.0, 0.0)])
    steering = pilot.steer(path, at(0.0, 0.0, 2.0), 10.0)
    assert steering == (0.0, 0.0, -TURN_RATE)
    # It goes on turning until it looks along the path, not only until it could drive.
    assert pilot.steer(path, at(0.0, 0.0, math.radians(30.0)), 10.0).turns
    assert not pilot.steer(path, at(0.0, 0.0, math.radians(10.0)), 10.0).turns


def test_speed_allows_a_stop_within_the_stopping_distance() -> None:
    path = Path([(0.0, 0.0), (10.0, 0.0)])
    assert PathFollower(2.0).steer(path, at(0.0, 0.0, 0.0), 0.5).speed == pytest.approx(math.sqrt(2.0 * BRAKING * 0.5))
    assert PathFollower(2.0).steer(path, at(0.0, 0.0, 0.0), 0.0).speed == MIN_SPEED
    assert braking(-1.0) == 0.0
