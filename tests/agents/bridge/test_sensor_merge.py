from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_agents.bridge.pose_source import PoseSource
from intellwheels_agents.bridge.sensor_merge import SensorMerge, SensorsName
from intellwheels_maps import robot
from intellwheels_schemas.messages import IMU, Odometry, Position, Proximity, ProximityReading, Robot
from intellwheels_schemas.rules import check_robot
from tests.agents.bridge.readings import reading

BODY = msgspec.structs.replace(robot("intellwheels"), odometry=(Odometry(id="way"),))
SONARS = tuple(
    msgspec.structs.replace(
        one, model="sonar", device="srf08", every=2, latency=1, crosstalk=1.0, ping_delay=0.01, second_ping_delay=0.02
    )
    for one in BODY.proximity[:2]
)
CHAIR = msgspec.structs.replace(BODY, proximity=SONARS, wheel_ratio=1.002)


@pytest.mark.parametrize(
    ("sensors", "virtual", "real"),
    [("virtual", 8, []), ("real", 0, ["front", "front-left"]), ("both", 8, ["real-front", "real-front-left"])],
)
def test_the_mind_gets_the_chosen_sensors(sensors: SensorsName, virtual: int, real: list[str]) -> None:
    made = SensorMerge(BODY, CHAIR, sensors)
    check_robot(made.robot)
    assert made.robot.type == "real"
    assert [one.id for one in made.robot.proximity if one.source == "real"] == real
    assert sum(one.source == "simulated" for one in made.robot.proximity) == virtual
    # What the chair's own sonars do wrong is in their readings.
    plain = Proximity(id="s", x=0.0, y=0.0, z=0.0, direction_deg=0.0, cone_deg=1.0, max_range=1.0, source="real")
    errors = ("model", "device", "dropout", "crosstalk", "ping_delay", "second_ping_delay", "every", "latency", "group")
    for one in made.robot.proximity:
        if one.source == "real":
            assert [getattr(one, name) for name in errors] == [getattr(plain, name) for name in errors]
    assert {one.source for one in made.robot.encoders + made.robot.odometry} == {"real"}
    source = PoseSource(CHAIR, "raw")
    source.set_start(Position(x=0.0, y=0.0, heading=0.0))
    heard = (ProximityReading(id="front", value=1.5, tick=3), ProximityReading(id="other", status="none"))
    forwarded = made.sensors(reading(1, proximity=heard), source)
    assert [(one.id, one.value, one.tick) for one in forwarded.proximity] == [(name, 1.5, None) for name in real[:1]]


def test_the_true_wheel_figures_are_not_revealed() -> None:
    assert SensorMerge(CHAIR, CHAIR, "both").robot.wheel_ratio == 1.0


def test_odometry_is_the_pose_relative_to_the_start() -> None:
    source = PoseSource(CHAIR, "raw")
    source.set_start(Position(x=3.0, y=1.0, heading=math.pi / 2.0))
    metre = round(CHAIR.encoder_ticks / (math.pi * CHAIR.wheel_diameter))
    source.add(reading(1, 100, 100))
    newest = reading(2, 100 + metre, 100 + metre)
    source.add(newest)
    forwarded = SensorMerge(BODY, CHAIR, "virtual").sensors(newest, source)
    (way,) = forwarded.odometry
    assert (way.x, way.y, way.heading) == pytest.approx((1.0, 0.0, 0.0), abs=1e-3)
    assert (forwarded.encoders[0].left, forwarded.encoders[0].right) == (metre, metre)


def test_a_chair_of_another_simulation_is_simulated_hardware() -> None:
    assert SensorMerge(BODY, CHAIR, "virtual", "simulated").robot.hardware == "simulated"
    assert Robot().hardware == "real"


@pytest.mark.parametrize(
    ("sensors", "has_motion", "units"),
    [
        ("virtual", True, [("imu", "simulated")]),
        ("real", True, [("imu", "real")]),
        ("both", True, [("imu", "simulated"), ("real-imu", "real")]),
        ("real", False, [("imu", "simulated")]),
    ],
)
def test_a_real_inertial_unit_counts_like_a_sonar(
    sensors: SensorsName, has_motion: bool, units: list[tuple[str, str]]
) -> None:
    chair = msgspec.structs.replace(BODY, imu=(IMU(id="imu", noise=0.1),))
    made = SensorMerge(chair, chair, sensors, has_motion=has_motion)
    check_robot(made.robot)
    assert [(one.id, one.source) for one in made.robot.imu] == units
    source = PoseSource(CHAIR, "raw")
    source.set_start(Position(x=0.0, y=0.0, heading=0.0))
    real = [name for name, kind in units if kind == "real"]
    heard = made.sensors(reading(1, motion=(0.5, -0.1, 0.2)), source).imu
    assert [(one.id, one.forward, one.left, one.turn_rate) for one in heard] == [
        (name, 0.5, -0.1, 0.2) for name in real
    ]
    assert made.sensors(reading(2), source).imu == ()
