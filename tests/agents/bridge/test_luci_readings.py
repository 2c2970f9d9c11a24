from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from intellwheels_agents.bridge.luci_readings import MAX_POINTS, WheelTurns, motion_of, nearest, points_of, stick_of
from intellwheels_agents.bridge.luci_schema import message
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Proximity, ProximityReading

FRONT = Proximity(id="front", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, min_range=0.1, max_range=3.0)
LEFT = Proximity(id="left", x=0.0, y=0.3, z=0.4, direction_deg=90.0, cone_deg=30.0, max_range=3.0)


def imu(**more: float) -> Any:
    return SimpleNamespace(
        **{"gravity_x": 0.0, "gravity_y": 0.0, "gravity_z": 9.8, "acceleration_x": 0.0, "acceleration_y": 0.0,
           "gyro_z": 0.0, **more}
    )  # fmt: skip


def test_points_ahead_of_the_chair_lie_on_our_x_axis() -> None:
    # LUCI: y forward, x to the right.
    arc = [message("Point3D", x=0.5, y=2.0)]
    heard = message("UltrasonicDistances", distances=[message("UltrasonicDistance", arc_points=arc)])
    assert points_of(heard, "UltrasonicDistances") == [(2.0, -0.5)]
    radar = message("RadarPoints", points=[message("RadarPoint", x=-1.0, y=0.0)])
    assert points_of(radar, "RadarPoints") == [(0.0, 1.0)]


@pytest.mark.parametrize("x", [2000.0, math.nan, math.inf])
def test_points_that_are_not_in_metres_are_named(x: float) -> None:
    radar = message("RadarPoints", points=[message("RadarPoint", x=x, y=0.0)])
    with pytest.raises(WireError, match=r"RadarPoints\.points: expected metres in \[-100, 100\], got"):
        points_of(radar, "RadarPoints")


def test_a_message_with_very_many_points_is_read_as_far_as_allowed() -> None:
    radar = message("RadarPoints", points=[message("RadarPoint", x=1.0)] * (MAX_POINTS + 10))
    assert len(points_of(radar, "RadarPoints")) == MAX_POINTS


def test_a_sonar_reports_the_nearest_point_in_its_cone() -> None:
    points = [(2.5, 0.0), (1.5, 0.1), (0.0, 1.3), (-2.0, 0.0)]
    front, left = nearest((FRONT, LEFT), points)
    assert front.value == pytest.approx(math.hypot(1.0, 0.1))
    assert left.value == pytest.approx(1.0)


def test_without_a_value_the_status_says_why() -> None:
    assert nearest((FRONT,), [(3.6, 0.0)]) == (ProximityReading(id="front", status="none"),)
    assert nearest((FRONT,), [(0.55, 0.0)]) == (ProximityReading(id="front", status="near"),)
    assert nearest((FRONT,), []) == (ProximityReading(id="front", status="none"),)
    assert nearest((FRONT,), None) == (ProximityReading(id="front", status="fault"),)


def test_an_inertial_unit_is_read_in_our_frame() -> None:
    assert motion_of(imu(acceleration_x=-0.3, acceleration_y=0.5, gyro_z=0.2)) == (0.5, 0.3, 0.2)


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        ({"gravity_z": 1.0}, r"ImuData\.gravity: expected 9\.81 m/s2, at most 1 off, got 1\.0"),
        ({"gravity_z": 1e200}, r"ImuData\.gravity: expected"),
        ({"gravity_z": math.nan}, r"ImuData\.gravity: expected"),
        ({"gyro_z": 28.6}, r"ImuData\.gyro_z: expected rad/s in \[-6\.5, 6\.5\], got 28\.6"),
        ({"acceleration_x": 980.0}, r"ImuData\.acceleration: expected m/s2 in \[-30, 30\]"),
    ],
)
def test_wrong_units_of_an_inertial_unit_are_named(wrong: dict[str, float], expected: str) -> None:
    with pytest.raises(WireError, match=expected):
        motion_of(imu(**wrong))


def test_a_joystick_turns_left_with_negative_values() -> None:
    assert stick_of(message("JoystickData", forward_back=50, left_right=-20), "JoystickData") == (0.5, 0.2)
    with pytest.raises(WireError, match=r"JoystickData: expected whole numbers in \[-100, 100\], got \(150, 100\)"):
        stick_of(message("JoystickData", forward_back=150, left_right=100), "JoystickData")


def test_wheels_are_followed_across_360_degrees_in_both_directions() -> None:
    turns = WheelTurns(360)
    assert turns.update(350.0, 10.0) == (0, 0)
    assert turns.update(10.0, 350.0) == (20, -20)
    assert turns.update(359.0, 20.0) == (9, 10)
    turns.forget_angles()
    assert turns.update(180.0, 180.0) == (9, 10)


def test_a_reversed_encoder_counts_down_forward() -> None:
    turns = WheelTurns(360, frozenset({"left"}))
    turns.update(100.0, 100.0)
    assert turns.update(90.0, 110.0) == (10, 10)


@pytest.mark.parametrize("angle", [-0.1, 361.0, math.nan, math.inf])
def test_an_angle_out_of_range_is_named_and_changes_nothing(angle: float) -> None:
    turns = WheelTurns(360)
    turns.update(100.0, 100.0)
    with pytest.raises(WireError, match=r"EncoderData\.right_angle: expected degrees in \[0, 360\], got"):
        turns.update(120.0, angle)
    assert turns.update(100.0, 100.0) == (0, 0)


def test_angles_in_radians_are_named_after_a_turn_of_a_wheel() -> None:
    turns = WheelTurns(360)
    for step in range(1, 63):
        turns.update(0.1 * step, 0.1 * step - 0.05)
    turns.update(0.1, 0.05)
    with pytest.raises(WireError, match="EncoderData: expected degrees, got angles up to 2 pi only"):
        turns.update(0.5, 0.45)


@pytest.mark.parametrize("step", [0.1, 1.5, 5.5])
def test_angles_in_degrees_that_begin_near_zero_are_taken(step: float) -> None:
    turns = WheelTurns(360)
    for number in range(100):
        left, right = turns.update((0.2 + step * number) % 360.0, (0.4 + step * number) % 360.0)
    assert left == right == round(99 * step)


def test_a_single_zero_is_made_up_for_and_a_lost_magnet_is_named() -> None:
    turns = WheelTurns(360)
    turns.update(355.0, 100.0)
    assert turns.update(0.0, 105.0) == (0, 5)
    assert turns.update(5.0, 110.0) == (10, 10)
    turns.update(0.0, 115.0)
    with pytest.raises(WireError, match=r"EncoderData\.left_angle: expected the angle of a magnet, got 0"):
        turns.update(0.0, 128.0)
    # The magnet is back: nobody knows how far the wheel has turned.
    assert turns.update(200.0, 130.0)[0] == 10


def test_both_wheels_at_zero_have_no_magnets() -> None:
    with pytest.raises(WireError, match="expected the angle of a magnet"):
        WheelTurns(360).update(0.0, 0.0)
