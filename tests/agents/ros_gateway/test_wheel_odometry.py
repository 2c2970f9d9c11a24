"""Odometry from the encoders or the odometry sensor of a chair that drives known arcs."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.ros_gateway.wheel_odometry import OdometrySample, WheelOdometry
from intellwheels_maps import robot
from intellwheels_schemas.messages import EncodersReading, OdometryReading, Sensors

CHAIR = robot("intellwheels")
METRE = CHAIR.encoder_ticks / (math.pi * CHAIR.wheel_diameter)


def encoders(left: float, right: float, tick: int | None = None) -> Sensors:
    reading = EncodersReading(id="wheels", tick=tick, left=round(left * METRE), right=round(right * METRE))
    return Sensors(encoders=(reading,))


def drive(odometry: WheelOdometry, left: float, right: float, ticks: int) -> OdometrySample:
    """Roll both wheels by so many metres, evenly."""
    found = None
    for tick in range(ticks + 1):
        found = odometry.update(encoders(left * tick / ticks, right * tick / ticks), tick)
    assert found is not None
    return found


def test_a_metre_ahead_is_a_metre_along_x() -> None:
    sample = drive(WheelOdometry(CHAIR, 0.05), 1.0, 1.0, 20)
    assert (sample.pose.x, sample.pose.y, sample.pose.heading) == pytest.approx((1.0, 0.0, 0.0), abs=1e-3)
    assert (sample.speed, sample.turn_rate) == pytest.approx((1.0, 0.0), abs=0.02)


def test_turn_on_the_spot() -> None:
    quarter = math.pi / 2.0 * CHAIR.track / 2.0
    sample = drive(WheelOdometry(CHAIR, 0.1), -quarter, quarter, 10)
    assert (sample.pose.x, sample.pose.y, sample.pose.heading) == pytest.approx((0.0, 0.0, math.pi / 2.0), abs=2e-3)
    assert sample.turn_rate == pytest.approx(math.pi / 2.0, rel=0.05)


def test_covariance_grows_with_the_way() -> None:
    short, long = (drive(WheelOdometry(CHAIR, 0.05), way, way, 40).covariance for way in (1.0, 4.0))
    assert 0.0 < short[0] < long[0]
    assert 0.0 < short[5] < long[5]
    # Variance of the heading: 2 k s / b^2.
    assert short[5] == pytest.approx(2e-5 / CHAIR.track**2, rel=0.01)


def test_odometry_sensor_is_taken_as_it_is_and_gives_the_same_velocity() -> None:
    odometry = WheelOdometry(robot("lidar-chair"), 0.05)
    radius, step = 2.0, 0.02
    for tick in range(30):
        angle = tick * step
        reading = OdometryReading(
            id="odometry", x=radius * math.sin(angle), y=radius * (1.0 - math.cos(angle)), heading=angle
        )
        sample = odometry.update(Sensors(odometry=(reading,)), tick)
    assert sample is not None
    assert (sample.pose.x, sample.pose.heading) == (reading.x, reading.heading)
    assert (sample.speed, sample.turn_rate) == pytest.approx((radius * step / 0.05, step / 0.05))
    assert sample.covariance[0] > 0.0


def test_a_late_or_repeated_sample_counts_once_at_its_own_tick() -> None:
    odometry = WheelOdometry(CHAIR, 0.05)
    first = odometry.update(encoders(0.0, 0.0, tick=8), 10)
    assert first is not None
    assert first.tick == 8
    assert odometry.update(encoders(0.0, 0.0, tick=8), 11) is None
    assert odometry.update(None, 12) is None
    assert odometry.update(Sensors(), 12) is None


def test_first_counts_are_the_origin() -> None:
    sample = WheelOdometry(CHAIR, 0.05).update(encoders(7.0, 9.0), 100)
    assert sample is not None
    assert (sample.pose.x, sample.pose.heading, sample.speed) == (0.0, 0.0, 0.0)
