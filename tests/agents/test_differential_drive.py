"""Motor powers from speeds, and a pose from encoders and compass."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_maps import robot
from intellwheels_schemas.messages import Actions, CompassReading, EncodersReading, OdometryReading, Position, Sensors
from tests.agents.kinematics import Body

CHAIR = robot("intellwheels")


def test_quarter_of_the_top_speed_is_a_quarter_of_the_power() -> None:
    assert powers(CHAIR, 0.25 * CHAIR.top_speed, 0.0) == (0.25, 0.25)


def test_left_turn_drives_the_right_wheel() -> None:
    left, right = powers(CHAIR, 0.0, 1.0)
    assert right == -left == pytest.approx(CHAIR.track / 2.0 / CHAIR.top_speed)


def test_excessive_speed_is_scaled_down_on_the_same_curve() -> None:
    left, right = powers(CHAIR, 2.0, 2.0)
    assert right == 1.0
    speed, rate = CHAIR.top_speed * (left + right) / 2.0, CHAIR.top_speed * (right - left) / CHAIR.track
    assert speed == pytest.approx(rate)


def test_odometry_follows_the_driven_arc() -> None:
    body = Body(CHAIR)
    odometry = Odometry(CHAIR, body.position)
    for _ in range(100):
        odometry.update(body.measures([]).sensors)
        body.step(Actions(left_motor=0.3, right_motor=0.6))
    odometry.update(body.measures([]).sensors)
    # An encoder tick is 0.6 mm here, and a heading a tick off is 1 mrad.
    assert (odometry.x, odometry.y) == pytest.approx((body.x, body.y), abs=2e-3)
    assert odometry.heading == pytest.approx(body.heading, abs=2e-3)


def test_encoder_counts_before_the_mind_started_are_ignored() -> None:
    odometry = Odometry(CHAIR, Position(x=1.0, y=2.0, heading=0.0))
    odometry.update(Sensors(encoders=(EncodersReading(id="wheels", left=5000, right=5000),)))
    assert (odometry.x, odometry.y) == (1.0, 2.0)


def test_compass_corrects_drift_across_the_wrap_of_the_angle() -> None:
    odometry = Odometry(CHAIR, Position(x=0.0, y=0.0, heading=math.pi - 0.01))
    for _ in range(200):
        odometry.update(Sensors(compass=(CompassReading(id="compass", value=-math.pi + 0.01),)))
    assert odometry.heading == pytest.approx(-math.pi + 0.01, abs=1e-4)


@pytest.mark.parametrize(
    ("angle", "same"), [(math.pi, math.pi), (-math.pi, math.pi), (3 * math.pi, math.pi), (0.5, 0.5)]
)
def test_headings_are_in_the_half_open_interval(angle: float, same: float) -> None:
    assert wrapped(angle) == pytest.approx(same)


def test_odometry_sensor_takes_precedence_over_encoders() -> None:
    chair = robot("corridor-chair")
    pose = Odometry(chair, Position(x=1.0, y=2.0, heading=math.pi / 2.0))
    wheels = (EncodersReading(id="wheels", left=500, right=500),)
    pose.update(Sensors(encoders=wheels, odometry=(OdometryReading(id="pose", x=3.0, y=0.5, heading=0.1),)))
    assert (pose.x, pose.y, pose.heading) == pytest.approx((0.5, 5.0, math.pi / 2.0 + 0.1))
    assert pose.turned == pytest.approx(0.1)
