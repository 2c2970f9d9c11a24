"""What belongs to one robot."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace

import pytest

from intellwheels_agents.ciber_gateway.ciber_robot import TOP_SPEED
from intellwheels_agents.ciber_gateway.client_messages import Orders
from intellwheels_agents.ciber_gateway.lab_frame import lab_of
from intellwheels_agents.ciber_gateway.robot_state import RobotState
from intellwheels_agents.ciber_gateway.simulator_messages import Settings
from intellwheels_schemas.messages import (
    BeaconReading,
    CompassReading,
    Entity,
    GPSReading,
    GroundReading,
    Heard,
    Measures,
    ProximityReading,
    Robot,
    Sensors,
)
from tests.agents.ciber_gateway.stand_in_clients import GRID, LAB, cut
from tests.maps.importers.drawn_floors import read

RUN = "0123456789abcdef"
FLOOR = lab_of(read({"MyLab.xml": LAB, "MyGrid.xml": GRID}).map)


def robot_state(settings: Settings | None = None) -> RobotState:
    state = RobotState(2, "R2", "r2", settings or Settings(obstacle_noise=0.0))
    state.begin(Robot(top_speed=TOP_SPEED), 0.05, RUN, FLOOR)
    return state


def all_sensors(tick: int = 4, *, zone: str | None = "target", collision: bool = False) -> Measures:
    sensors = Sensors(
        proximity=(
            ProximityReading(id="ir0", value=0.8), ProximityReading(id="ir1", status="near"),
            ProximityReading(id="ir2", status="none"), ProximityReading(id="ir3", value=0.001),
        ),
        compass=(CompassReading(id="compass", value=math.pi / 4),),
        gps=(GPSReading(id="gps", x=3.0, y=4.0),),
        beacon=(BeaconReading(id="beacon0", value=-0.5), BeaconReading(id="beacon1", status="none")),
        ground=(GroundReading(id="ground0", zone=zone), GroundReading(id="ground1", zone="target")),
    )  # fmt: skip
    heard = (Heard(sender="r1", tick=3, distance=1.0, text="x"), Heard(sender="chair", tick=3, distance=1.0, text="y"))
    return Measures(run=RUN, tick=tick, time=tick * 0.05, collision=collision, sensors=sensors, message=heard)


def test_every_sensor_in_its_units() -> None:
    root = cut(robot_state().sense(all_sensors(), {"r1": 1}))
    sensors = root[0]
    assert root.attrib["Time"] == "4"
    assert sensors.attrib == {"Collision": "No", "Compass": "45", "Ground": "0"}
    assert [one.attrib["Value"] for one in sensors.findall("IRSensor")] == ["1.3", "100", "0", "100"]
    assert [one.attrib["Value"] for one in sensors.findall("BeaconSensor")] == ["-29", "NotVisible"]
    gps = sensors.find("GPS")
    assert gps is not None
    assert gps.attrib == {"X": "3", "Y": "4"}
    assert [(one.attrib["From"], one.text) for one in sensors.findall("Message")] == [("1", "x"), ("0", "y")]


def test_positions_count_from_the_corner_of_the_lab() -> None:
    state = robot_state()
    state.begin(Robot(top_speed=TOP_SPEED), 0.05, RUN, replace(FLOOR, west=1.0, south=-2.0))
    gps = cut(state.sense(all_sensors(), {}))[0].find("GPS")
    assert gps is not None
    assert gps.attrib == {"X": "2", "Y": "6"}
    shown = cut(state.show(Entity(name="r2", x=3.0, y=4.0, heading=0.0), 4, running=True))
    assert shown[0].attrib == {"X": "2", "Y": "6", "Dir": "0"}


@pytest.mark.parametrize(("radians", "degrees"), [(1.5 * math.pi, "-90"), (-1.25 * math.pi, "135"), (0.1134, "6")])
def test_directions_are_whole_degrees_from_minus_180_to_180(radians: float, degrees: str) -> None:
    sensors = Sensors(compass=(CompassReading(id="compass", value=radians),))
    measured = Measures(run=RUN, tick=1, time=0.05, sensors=sensors)
    assert cut(robot_state().sense(measured, {}))[0].attrib["Compass"] == degrees


def test_a_robot_is_in_a_target_with_its_whole_disc() -> None:
    assert cut(robot_state().sense(all_sensors(zone=None), {}))[0].attrib["Ground"] == "-1"


def test_noise_is_of_the_value_and_repeats_with_run_and_robot() -> None:
    def values() -> list[float]:
        state = robot_state(Settings(obstacle_noise=0.1))
        return [float(cut(state.sense(all_sensors(tick), {}))[0][0].attrib["Value"]) for tick in range(400)]

    found = values()
    assert found == values()
    assert statistics.mean(found) == pytest.approx(1.25, abs=0.03)
    # Rounded to 0.1, which adds a variance of 0.1^2 / 12.
    assert statistics.stdev(found) == pytest.approx(math.sqrt(0.01 + 0.01 / 12), rel=0.15)


def test_powers_are_travel_in_a_cycle_and_held() -> None:
    state = robot_state()
    state.obey(Orders(left=0.1, right=-7.0, say="hi"))
    actions = state.actions()
    assert actions.left_motor == pytest.approx(0.1 / 0.05 / TOP_SPEED)
    assert actions.right_motor == pytest.approx(-0.15 / 0.05 / TOP_SPEED)
    assert (actions.say, state.actions().say) == ("hi", None)
    state.obey(Orders(say="ho"))
    state.obey(Orders(left=0.1))
    assert state.actions().say == "ho"
    state.obey(Orders(left=0.0))
    assert (state.actions().left_motor, state.actions().right_motor) == (0.0, actions.right_motor)


def test_a_robot_that_has_finished_does_not_move_and_a_new_run_begins_anew() -> None:
    state = robot_state()
    state.obey(Orders(left=0.1, right=0.1, end_led=True))
    state.obey(Orders(left=0.1, right=0.1, end_led=False))
    assert (state.finished, state.actions().left_motor) == (True, 0.0)
    state.begin(Robot(top_speed=TOP_SPEED), 0.05, RUN, FLOOR)
    assert not state.finished


def test_requestable_sensors_come_once_for_each_request() -> None:
    state = robot_state(Settings(requests=2, requestable=frozenset({"obstacle", "compass"}), obstacle_noise=0.0))
    assert state.obey(Orders(requests=("IRSensor1", "Wings", "Compass", "IRSensor2"))) == 2
    sensors = cut(state.sense(all_sensors(), {}))[0]
    assert [one.attrib["Id"] for one in sensors.findall("IRSensor")] == ["1"]
    assert "Compass" in sensors.attrib
    sensors = cut(state.sense(all_sensors(5), {}))[0]
    assert (sensors.findall("IRSensor"), "Compass" in sensors.attrib, "Ground" in sensors.attrib) == ([], False, True)


def test_requests_of_sensors_that_are_not_there_take_no_place() -> None:
    state = robot_state(Settings(requests=1, requestable=frozenset({"obstacle"}), obstacle_noise=0.0))
    assert state.obey(Orders(requests=("IRSensor", "IRSensor4", "Beacon1", "Compass0", "IRSensor3"))) == 4
    sensors = cut(state.sense(all_sensors(), {}))[0]
    assert [one.attrib["Id"] for one in sensors.findall("IRSensor")] == ["3"]


def test_viewers_see_state_collisions_and_targets() -> None:
    state = robot_state()
    entity = Entity(name="r2", x=3.0, y=4.0, heading=math.pi / 2)
    for collision in (True, True, False, True):
        state.sense(all_sensors(collision=collision), {})
    shown = cut(state.show(entity, 4, running=True))
    assert (shown.attrib["State"], shown.attrib["Collisions"], shown.attrib["VisitedMask"]) == ("Running", "2", "0")
    assert shown[0].attrib == {"X": "3", "Y": "4", "Dir": "90"}
    state.obey(Orders(visiting_led=True))
    state.sense(all_sensors(), {})
    shown = cut(state.show(entity, 4, running=True))
    assert (shown.attrib["State"], shown.attrib["VisitedMask"]) == ("Waiting", "1")
    state.obey(Orders(returning_led=True))
    assert cut(state.show(entity, 4, running=True)).attrib["State"] == "Returning"
    assert cut(state.show(entity, 4, running=False)).attrib["State"] == "Stopped"
    state.obey(Orders(end_led=True))
    assert cut(state.show(entity, 4, running=True)).attrib["State"] == "Finished"
    assert cut(state.removed(9)).attrib["State"] == "Removed"


def test_a_stopped_world_shows_the_button() -> None:
    state = robot_state()
    state.sense(all_sensors(), {})
    root = cut(state.stopped())
    assert root.attrib["Time"] == "4"
    assert root[2].attrib == {"Start": "Off", "Stop": "On"}
    assert root[0].findall("Message") == []
