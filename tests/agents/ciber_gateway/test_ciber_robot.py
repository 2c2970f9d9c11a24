"""The robot of the ancestor: its shape, its motors and its sensors, in the world of the simulator."""

from __future__ import annotations

import math

import msgspec
import pytest
from shapely.geometry import Point, box
from shapely.ops import unary_union

from intellwheels_agents.ciber_gateway.ciber_robot import CYCLE, TOP_SPEED, ciber_robot
from intellwheels_agents.ciber_gateway.client_messages import Registration
from intellwheels_agents.ciber_gateway.lab_frame import lab_of
from intellwheels_agents.robot_document import equipped
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Actions, Map, Measures, Position, Robot, Sensors
from intellwheels_schemas.rules import check_robot
from intellwheels_server.world import Setup, advance, apply, begin, measures
from tests.agents.ciber_gateway.stand_in_clients import GRID, LAB
from tests.maps.importers.drawn_floors import read

QUIET = {"MotorNoise": "0", "Compass.NoiseDeg": "0", "Beacon.NoiseDeg": "0", "GPS.Noise": "0"}


def lab_map() -> Map:
    return read({"MyLab.xml": LAB, "MyGrid.xml": GRID}).map


def quiet_robot(registration: Registration, height: float = 2.0) -> Robot:
    robot = ciber_robot(registration, lab_of(lab_map()), gps=True, beacons=True, beacon_height=height)
    return equipped(robot, QUIET)


def sensed(x: float, y: float, heading: float, height: float = 2.0) -> Measures:
    state = begin(Setup(floor=lab_map(), seed="1"), run="0123456789abcdef")
    place = Position(x=x, y=y, heading=heading)
    robot = quiet_robot(Registration("robot", "r", 0, (0.0, 90.0, -90.0, 540.0)), height)
    state, _ = apply(state, [Join(agent="r", robot=msgspec.structs.replace(robot, position=place))])
    return measures(state, "r")


def test_its_boxes_are_in_the_disc_and_nearly_fill_it() -> None:
    robot = quiet_robot(Registration("robot"))
    check_robot(robot)
    shape = unary_union([box(-p.length / 2, -p.width / 2, p.length / 2, p.width / 2) for p in robot.part])
    disc = Point(0.0, 0.0).buffer(0.5 + 1e-9, quad_segs=256)
    assert shape.within(disc.buffer(1e-3))
    assert min(Point(0, 0).distance(Point(*at)) for at in shape.exterior.coords) == pytest.approx(0.4757, abs=1e-3)


def sensors_of(found: Measures) -> Sensors:
    assert found.sensors is not None
    return found.sensors


def test_what_it_senses_in_a_lab() -> None:
    found = sensors_of(sensed(2.0, 2.0, math.pi / 2))
    # The edge of the cone ahead meets the border at x = 0. The wall on the right is at x = 5.
    assert [reading.value for reading in found.proximity] == pytest.approx([4.0, 1.5, 2.5, 1.5], abs=0.01)
    assert found.compass[0].value == pytest.approx(math.pi / 2)
    assert (found.gps[0].x, found.gps[0].y) == (2.0, 2.0)
    assert found.beacon[0].status == "none"  # behind the wall
    assert {reading.zone for reading in found.ground} == {None}


def test_beacons_are_seen_over_lower_walls_only() -> None:
    seen = sensors_of(sensed(2.0, 6.0, 0.0)).beacon[0]
    assert seen.value == pytest.approx(0.0, abs=0.01)
    assert sensors_of(sensed(2.0, 2.0, 0.0)).beacon[0].value is None
    above = sensors_of(sensed(2.0, 2.0, 0.0, height=4.0)).beacon[0]
    assert above.value == pytest.approx(math.atan2(4.0, 8.0), abs=0.01)


def test_ground_sensors_agree_inside_a_target_only() -> None:
    assert {reading.zone for reading in sensors_of(sensed(10.0, 5.2, 0.0)).ground} == {"target"}
    assert {reading.zone for reading in sensors_of(sensed(10.0, 4.8, 0.0)).ground} == {"target", None}


def driven(left: float, right: float, cycles: int) -> tuple[float, float]:
    """Return the x and the heading of a robot that starts at the origin of both, after cycles with two powers."""
    state = begin(Setup(floor=lab_map(), seed="1"), run="0123456789abcdef")
    robot = equipped(quiet_robot(Registration("robot")), {"GPS.Step": "0", "Compass.StepDeg": "0"})
    state, _ = apply(
        state, [Join(agent="r", robot=msgspec.structs.replace(robot, position=Position(x=1.0, y=4.0, heading=0.0)))]
    )
    actions = Actions(left_motor=left / CYCLE / TOP_SPEED, right_motor=right / CYCLE / TOP_SPEED)
    for _ in range(cycles):
        state, _ = advance(state, Inputs(actions={"r": actions}))
    sensors = sensors_of(measures(state, "r"))
    x, heading = sensors.gps[0].x, sensors.compass[0].value
    assert x is not None
    assert heading is not None
    return x - 1.0, heading


def test_it_moves_by_the_law_of_the_simulator_but_for_the_lag() -> None:
    power, travel, law = 0.1, 0.0, 0.0
    for _ in range(12):
        law = 0.5 * power + 0.5 * law
        travel += law
    assert driven(power, power, 12)[0] == pytest.approx(travel - (1 / math.log(2) - 1) * power, abs=1e-3)
    assert driven(-power / 2, power / 2, 12)[1] == pytest.approx(travel - (1 / math.log(2) - 1) * power, abs=1e-3)


def test_without_gps_beacons_and_targets_it_has_no_such_sensors() -> None:
    robot = ciber_robot(Registration("robot"), lab_of(Map(format="iw.v1", name="m")), gps=False, beacons=False,
                        beacon_height=1.0)  # fmt: skip
    assert (robot.gps, robot.beacon, robot.ground) == ((), (), ())
