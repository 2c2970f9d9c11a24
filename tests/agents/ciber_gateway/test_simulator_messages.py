"""What clients get."""

from __future__ import annotations

import dataclasses
from xml.etree import ElementTree

import pytest

from intellwheels_agents.ciber_gateway.ciber_robot import ciber_robot
from intellwheels_agents.ciber_gateway.client_messages import Registration
from intellwheels_agents.ciber_gateway.lab_frame import lab_of
from intellwheels_agents.ciber_gateway.simulator_messages import (
    KINDS,
    REFUSED,
    Leds,
    Readings,
    Settings,
    grid_shown,
    lab_shown,
    measures,
    reply,
    robot_shown,
)
from intellwheels_agents.robot_document import equipped
from intellwheels_maps.library import imported
from tests.agents.ciber_gateway.stand_in_clients import GRID, LAB, cut
from tests.maps.importers.drawn_floors import read
from tests.maps.importers.test_public_floors import FOLDER

FLOOR = lab_of(read({"MyLab.xml": LAB, "MyGrid.xml": GRID}).map)


def test_a_reply_fits_into_the_buffer_of_an_agent() -> None:
    robot = ciber_robot(Registration("robot"), FLOOR, gps=True, beacons=True, beacon_height=2.0)
    long = Settings(10**6, 10**6, 100, frozenset(KINDS), 9.87654e-5)
    message = reply(long, robot, FLOOR, 0.05)
    assert len(message) <= 1024
    parameters = cut(message)[0].attrib
    assert (parameters["CycleTime"], parameters["NBeacons"], parameters["MotorsNoise"]) == ("50", "1", "1.5")
    assert (parameters["GPS"], parameters["CompassSensor"], parameters["CompassRequestable"]) == ("On", "On", "On")
    assert cut(reply(Settings(), None, FLOOR, 0.1))[0].attrib["CycleTime"] == "100"
    assert cut(REFUSED).attrib == {"Status": "Refused"}


def test_measures_to_the_byte() -> None:
    readings = Readings(
        collision=True, compass=-12.0, ground=0, obstacles=[(0, 1.3), (3, 100.0)], beacons=[(0, None), (1, 45.0)],
        gps=(1.25, 2.0), heard=[(2, "a]]>b")],
    )  # fmt: skip
    assert measures(7, readings, Leds(visiting=True), running=True) == (
        b'<Measures Time="7">\n\t<Sensors Collision="Yes" Compass="-12" Ground="0">\n'
        b'\t\t<IRSensor Id="0" Value="1.3"/>\n\t\t<IRSensor Id="3" Value="100"/>\n'
        b'\t\t<BeaconSensor Id="0" Value="NotVisible"/>\n\t\t<BeaconSensor Id="1" Value="45"/>\n'
        b'\t\t<GPS X="1.25" Y="2"/>\n\t\t<Message From="2"><![CDATA[a]]]]><![CDATA[>b]]></Message>\n\t</Sensors>\n'
        b'\t<Leds EndLed="Off" ReturningLed="Off" VisitingLed="On"/>\n'
        b'\t<Buttons Start="On" Stop="Off"/>\n</Measures>\n\0'
    )
    assert cut(measures(7, Readings(), Leds(), running=False))[0].attrib == {}


def test_a_lab_and_its_grid_are_as_in_the_files() -> None:
    shown, drawn = cut(lab_shown(FLOOR, 2.0)), ElementTree.fromstring(LAB)
    assert shown.attrib == drawn.attrib
    for name in ("Beacon", "Wall/Corner"):
        assert [one.attrib for one in shown.findall(name)] == [one.attrib for one in drawn.findall(name)]
    assert [one.attrib for one in cut(grid_shown(FLOOR))] == [one.attrib for one in ElementTree.fromstring(GRID)]


def test_a_lab_that_begins_elsewhere_is_shown_from_its_corner() -> None:
    lab = dataclasses.replace(FLOOR, west=1.0, south=-2.0)
    beacon = cut(lab_shown(lab, 2.0)).find("Beacon")
    assert beacon is not None
    assert (beacon.attrib["X"], beacon.attrib["Y"]) == ("9", "8")
    assert cut(grid_shown(lab))[0].attrib == {"X": "1", "Y": "4", "Dir": "0"}


def test_the_aperture_of_beacons_is_half_of_the_cone_in_radians() -> None:
    robot = ciber_robot(Registration("robot"), FLOOR, gps=False, beacons=True, beacon_height=2.0)
    assert cut(reply(Settings(), robot, FLOOR, 0.05))[0].attrib["BeaconAperture"] == "3.14159"
    narrow = equipped(robot, {"Beacon.ConeDeg": "120"})
    assert cut(reply(Settings(), narrow, FLOOR, 0.05))[0].attrib["BeaconAperture"] == "1.0472"


def test_a_robot_with_any_name_is_well_formed() -> None:
    robot = cut(
        robot_shown(1, 'a"<&>b', 9, (1.0, 2.0, 3.14159265), "Running", collisions=2, collision=True, visited="01")
    )
    assert (robot.attrib["Name"], robot.attrib["VisitedMask"], robot[0].attrib["Dir"]) == ('a"<&>b', "01", "180")


@pytest.mark.skipif(not FOLDER.is_dir(), reason="needs the public floors in the folder PUBLIC_FLOORS")
def test_a_public_lab_is_shown_as_in_its_files() -> None:
    lab = lab_of(imported(FOLDER / "CiberRTSS08_FinalLab.xml").map)
    drawn = ElementTree.parse(FOLDER / "CiberRTSS08_FinalLab.xml").getroot()
    grid = ElementTree.parse(FOLDER / "CiberRTSS08_FinalGrid.xml").getroot()
    shown = cut(lab_shown(lab, 2.0))
    assert shown.attrib == drawn.attrib
    for name in ("Beacon", "Target", "Wall"):
        assert len(shown.findall(name)) == len(drawn.findall(name))
    corners = [sorted((float(one.attrib["X"]), float(one.attrib["Y"])) for one in wall) for wall in drawn.iter("Wall")]
    assert [
        sorted((float(one.attrib["X"]), float(one.attrib["Y"])) for one in wall) for wall in shown.iter("Wall")
    ] == corners
    assert [one.attrib for one in cut(grid_shown(lab))] == [one.attrib for one in grid]
