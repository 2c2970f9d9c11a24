"""Options that begin with a capital letter change the robot document."""

from __future__ import annotations

import pytest

from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import default_robot, equipped, fields_of, joining, split_options
from intellwheels_maps import robot as included
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Compass, Encoders, Robot
from intellwheels_schemas.sonar_devices import DEVICES
from tests.every_case import every_case

ROBOT = Robot(
    format="iw.v1",
    kind="wheelchair",
    top_speed=1.0,
    length=1.1,
    width=0.6,
    center=0.3,
    encoders=(Encoders(id="wheels"),),
    compass=(Compass(id="a"), Compass(id="b")),
    barrier=True,
)


@pytest.mark.parametrize(
    ("mind", "name"),
    [("avoid", "intellwheels"), ("mine.py", "intellwheels"), ("person", "person"), ("car", "car"), ("door", "door")],
)
def test_mind_that_does_not_drive_a_wheelchair_has_a_robot_of_its_own(mind: str, name: str) -> None:
    assert default_robot(mind) == name
    assert included(name).kind in ("wheelchair", name)


def test_capitalised_options_belong_to_the_robot() -> None:
    robot, mind = split_options({"MotorNoise": "0.015", "speed": "1"})
    assert (robot, mind) == ({"MotorNoise": "0.015"}, {"speed": "1"})


def test_fields_of_the_robot_and_of_all_sensors_of_a_kind_are_set() -> None:
    robot = equipped(ROBOT, {"MotorNoise": "0.015", "Compass.NoiseDeg": "1", "Anchored": "true", "Kind": "car"})
    assert robot.motor_noise == 0.015
    assert [compass.noise_deg for compass in robot.compass] == [1.0, 1.0]
    assert robot.anchored
    assert robot.kind == "car"


@every_case(
    ("name", "value"),
    [
        ("MotorNose", "1"),
        ("MotorNoise", "2"),
        ("Lidar.Noise", "1"),
        ("Compass.Noise", "1"),
        ("TopSpeed", "x"),
        ("MotorNoise", "007"),
        ("MotorNoise", "1e999"),
        ("Compass.NoiseDeg", "-01"),
    ],
)
def test_unknown_field_or_wrong_value_is_refused_by_name(name: str, value: str) -> None:
    with pytest.raises(OptionError, match=f"option {name}: expected"):
        equipped(ROBOT, {name: value})


@pytest.mark.parametrize("order", [1, -1])
def test_device_gives_all_proximity_sensors_its_figures_but_for_those_that_are_set(order: int) -> None:
    changes = [("Proximity.Device", "srf08"), ("Proximity.MaxRange", "3.5"), ("Proximity.Every", "8")]
    made = equipped(included("mid-wheel"), dict(changes[::order]))
    assert len(made.proximity) == 8
    for one in made.proximity:
        assert (one.model, one.device, one.cone_deg, one.min_range, one.max_range) == (
            "sonar",
            "srf08",
            55.0,
            0.03,
            3.5,
        )
        assert (one.every, one.latency, one.crosstalk) == (8, 1, 1.0)
    later = equipped(included("mid-wheel"), {"Proximity.Latency": "3", "Proximity.Device": "srf10"})
    assert {(one.cone_deg, one.latency) for one in later.proximity} == {(72.0, 3)}
    with pytest.raises(OptionError, match=r"option Proximity.Device: expected one of srf04, .*, got 'srf99'"):
        equipped(included("mid-wheel"), {"Proximity.Device": "srf99"})


@pytest.mark.parametrize("name", ["corridor-chair", "mid-wheel"])
def test_device_pings_no_faster_than_it_can_at_50_ms(name: str) -> None:
    for device, figures in DEVICES.items():
        for one in equipped(included(name), {"Proximity.Device": device}).proximity:
            assert one.every * 0.05 >= figures.ping_period
            assert one.latency * 0.05 >= 2.0 * figures.max_range / 346.0


def test_device_with_delays_and_a_range_of_its_own_gets_the_timing_that_they_need() -> None:
    changes = {"Proximity.Device": "polaroid-6500", "Proximity.MaxRange": "4.0"}
    made = equipped(included("mid-wheel"), changes)
    assert {(one.every, one.latency) for one in made.proximity} == {(2, 1)}
    made = equipped(included("mid-wheel"), {**changes, "Proximity.SecondPingDelay": "0.04"})
    assert {(one.every, one.latency) for one in made.proximity} == {(3, 2)}


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"Proximity.Model": "ideal"}, "Proximity.Model: expected sonar with Proximity.Device, got 'ideal'"),
        ({"Proximity.Latency": "0"}, "Proximity.Latency: expected at least 1 with Proximity.Device, got 0"),
    ],
)
@pytest.mark.parametrize("order", [1, -1])
def test_option_that_no_device_can_have_is_refused(changes: dict[str, str], text: str, order: int) -> None:
    given = dict([("Proximity.Device", "srf08"), *changes.items()][::order])
    with pytest.raises(OptionError, match=f"option {text}"):
        equipped(included("mid-wheel"), given)


def test_whole_agent_joins_with_its_body_and_without_the_files_format() -> None:
    robot = joining(ROBOT, agent="chair1", role="both", instance="0" * 16, place="bed1", barrier=None)
    assert (robot.format, robot.name, robot.place, robot.barrier) == (None, "chair1", "bed1", True)
    assert robot.encoders == ROBOT.encoders


def test_mind_joins_without_a_body() -> None:
    robot = joining(ROBOT, agent="chair1", role="mind", instance="0" * 16, place=None, barrier=False)
    assert robot == Robot(name="chair1", role="mind", instance="0" * 16, barrier=False)


def test_fields_of_options() -> None:
    assert fields_of(["TopSpeed=1", "Lidar.Noise=0"]) == {"TopSpeed": "1", "Lidar.Noise": "0"}
    for wrong in (["x"], ["speed=1"], ["A=1", "A=2"]):
        with pytest.raises(WireError, match="--option: expected FIELD=VALUE"):
            fields_of(wrong)
