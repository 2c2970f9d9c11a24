"""The included robots have the dimensions of the design: turning radii, heights, sensor positions."""

from __future__ import annotations

import math

import pytest
from shapely.geometry import Point, box

from intellwheels_maps import names, robot
from intellwheels_schemas.sonar_devices import DEVICES
from tests.every_case import every_case

CHAIRS = {
    "rear-wheel": (1.10, 0.62, 0.227, 0.905),
    "mid-wheel": (1.15, 0.655, 0.5, 0.662),
    "front-wheel": (1.10, 0.655, 0.72, 0.857),
    "intellwheels": (1.20, 0.66, 0.42, 0.770),
}
"""Length, width, centre of movement as a share of the length from the rear edge, turning radius; metres."""


def test_all_expected_robots_are_there() -> None:
    assert set(names("robots")) >= {*CHAIRS, "door", "table", "person", "crate"}


@pytest.mark.parametrize("name", CHAIRS)
def test_chair_turns_on_its_radius(name: str) -> None:
    corners = [
        (part.x + side_x * part.length / 2, part.y + side_y * part.width / 2)
        for part in robot(name).part
        for side_x in (-1, 1)
        for side_y in (-1, 1)
    ]
    # Three decimals are what the design gives.
    assert max(math.hypot(*corner) for corner in corners) == pytest.approx(CHAIRS[name][3], abs=0.0005)


@pytest.mark.parametrize("name", CHAIRS)
def test_base_of_a_chair_has_its_preset_outline(name: str) -> None:
    length, width, centre, _ = CHAIRS[name]
    base = robot(name).part[0]
    assert (base.length, base.width) == (length, width)
    assert base.length / 2 - base.x == pytest.approx(centre * length, abs=1e-9)
    assert (base.bottom, base.top) == (0.0, 0.5)


@pytest.mark.parametrize("name", CHAIRS)
def test_upper_body_is_shorter_and_lies_above_the_base(name: str) -> None:
    base, upper = robot(name).part
    assert (upper.bottom, upper.top) == (0.5, 1.3)
    assert upper.length < base.length
    below = box(base.x - base.length / 2, -base.width / 2, base.x + base.length / 2, base.width / 2)
    above = box(upper.x - upper.length / 2, -upper.width / 2, upper.x + upper.length / 2, upper.width / 2)
    assert below.contains(above)


@pytest.mark.parametrize("name", CHAIRS)
def test_proximity_sensors_sit_on_the_outline_and_look_outwards(name: str) -> None:
    document = robot(name)
    base = document.part[0]
    outline = box(base.x - base.length / 2, -base.width / 2, base.x + base.length / 2, base.width / 2)
    ids = {sensor.id for sensor in document.proximity}
    assert ids == {"front", "front-left", "left", "back-left", "back", "back-right", "right", "front-right"}
    for sensor in document.proximity:
        assert Point(sensor.x, sensor.y).distance(outline.exterior) < 1e-9
        direction = math.radians(sensor.direction_deg)
        ahead = Point(sensor.x + 0.01 * math.cos(direction), sensor.y + 0.01 * math.sin(direction))
        assert not outline.contains(ahead)
        assert base.bottom <= sensor.z < base.top


@pytest.mark.parametrize("name", CHAIRS)
def test_chair_has_the_sensors_that_a_mind_needs(name: str) -> None:
    document = robot(name)
    assert document.kind == "wheelchair"
    assert 0.9 <= document.top_speed <= 1.1
    assert (len(document.encoders), len(document.compass), len(document.bumper)) == (1, 1, 1)
    assert document.track < document.part[0].width


def test_acceleration_curves_of_the_chairs_differ() -> None:
    assert len({robot(name).acceleration_curve for name in CHAIRS}) == len(CHAIRS)


@every_case("name", names("robots"))
def test_shipped_robot_has_no_noise_of_its_own(name: str) -> None:
    """Noise is set by scenes, so that tests of the motion can use the same robots."""
    document = robot(name)
    assert document.motor_noise == 0.0
    assert all(compass.noise_deg == 0.0 for compass in document.compass)


def test_srf08_chair_is_the_corridor_chair_with_sonars_that_fire_in_turn() -> None:
    """A sonar that can exist: the device's beam and period, and neighbours that do not fire together."""
    sonars, plain = robot("srf08-chair").proximity, robot("corridor-chair").proximity
    assert [(one.id, one.x, one.y, one.direction_deg) for one in sonars] == [
        (one.id, one.x, one.y, one.direction_deg) for one in plain
    ]
    device = DEVICES["srf08"]
    for before, one in zip((sonars[-1], *sonars), sonars, strict=False):
        assert (one.model, one.device, one.cone_deg) == ("sonar", "srf08", device.cone_deg)
        assert (one.min_range, one.max_range, one.latency) == (device.min_range, device.max_range, 1)
        assert abs(one.group - before.group) * 0.05 >= device.ping_period
        assert one.every * 0.05 == pytest.approx(0.4)
    assert [[one.group for one in sonars].count(group) for group in range(8)] == [4, 0] * 4


def test_door_has_the_papers_leaf_and_two_sensors_on_each_side() -> None:
    document = robot("door")
    assert (document.length, document.width, document.center, document.top) == (1.0, 0.1, 0.99, 2.0)
    assert document.anchored
    assert document.top_speed > 0
    assert {sensor.mount for sensor in document.proximity} == {"start"}
    outward = [sensor for sensor in document.proximity if sensor.y]
    sides = [math.copysign(1, sensor.y) for sensor in outward]
    assert (sides.count(1), sides.count(-1)) == (2, 2)
    assert all(sensor.direction_deg == math.copysign(90, sensor.y) for sensor in outward)


def test_door_has_a_sensor_from_jamb_to_jamb() -> None:
    """The gap between the outward cones, in the plane of the leaf, is as wide as two people."""
    [across] = [sensor for sensor in robot("door").proximity if not sensor.y]
    assert across.direction_deg == 0.0
    # From 0.01 m beyond the free edge to the other jamb, 1.06 m away.
    assert (across.x, across.min_range) == (-1.0, 0.0)
    assert across.max_range > 1.06


def test_door_sensors_see_the_corridor_wall_no_nearer_than_the_design_says() -> None:
    """A 30 degree cone at y = +-0.3 meets the wall at 1.2 m from 3.48 m on (SIMULATION, doors)."""
    for sensor in robot("door").proximity:
        if not sensor.y:
            continue
        y = -0.49 - sensor.x  # the hinge at (6, -0.49) looks towards -y
        assert abs(y) == pytest.approx(0.3)
        assert (1.2 - abs(y)) / math.sin(math.radians(sensor.cone_deg / 2)) == pytest.approx(3.48, abs=0.005)


def test_table_is_a_top_on_four_legs_that_end_below_it() -> None:
    top, *legs = robot("table").part
    assert (top.bottom, top.top) == (0.69, 0.72)
    assert len(legs) == 4
    plate = box(top.x - top.length / 2, -top.width / 2, top.x + top.length / 2, top.width / 2)
    for leg in legs:
        assert (leg.bottom, leg.top) == (0.0, top.bottom)
        assert plate.contains(
            box(leg.x - leg.length / 2, leg.y - leg.width / 2, leg.x + leg.length / 2, leg.y + leg.width / 2)
        )
    assert robot("table").top_speed == 0.0


def test_base_of_every_chair_passes_below_the_table_top_and_its_upper_body_does_not() -> None:
    top = robot("table").part[0]
    for name in CHAIRS:
        base, upper = robot(name).part
        assert base.top <= top.bottom
        assert upper.bottom < top.top <= upper.top
