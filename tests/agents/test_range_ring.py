"""The objects that a ring of cones sees."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.range_ring import CONES, RangeRing, with_ring
from intellwheels_maps import robot
from intellwheels_schemas.messages import Position, ProximityReading, Sensors, Status

BODY = with_ring(robot("person"))


def seen(**metres: float | Status) -> Sensors:
    """Return the readings of a ring that sees only these ranges, by cone: c0, c1, ..."""
    readings = []
    for i in range(CONES):
        value = metres.get(f"c{i}")
        if isinstance(value, float):
            readings.append(ProximityReading(id=f"ring-{i}", value=value))
        else:
            readings.append(ProximityReading(id=f"ring-{i}", status=value or "none"))
    return Sensors(proximity=tuple(readings))


@pytest.fixture
def pose() -> Odometry:
    return Odometry(BODY, Position(x=1.0, y=2.0, heading=math.pi / 2.0))


def test_ring_covers_all_directions() -> None:
    directions = sorted(sensor.direction_deg for sensor in BODY.proximity)
    assert [b - a for a, b in pairwise(directions)] == pytest.approx([7.5] * (CONES - 1))


def test_object_is_where_the_range_is_a_minimum(pose: Odometry) -> None:
    ring = RangeRing(BODY, 0.05)
    ring.update(seen(c11=2.2, c12=2.0, c13=2.3, c30=4.0), pose)
    assert [one.metres for one in ring.objects] == [2.0, 4.0]
    # Cone 12 looks to the left of a body that looks north: west.
    assert (ring.objects[0].x, ring.objects[0].y) == pytest.approx((-1.0, 2.0))


def test_two_cones_that_see_one_edge_make_one_object(pose: Odometry) -> None:
    ring = RangeRing(BODY, 0.05)
    ring.update(seen(c0=2.0, c1=2.0), pose)
    assert [one.bearing for one in ring.objects] == pytest.approx([math.pi / 2.0 + math.radians(3.75)])


def test_approaching_object_has_its_velocity(pose: Odometry) -> None:
    ring = RangeRing(BODY, 0.05)
    for i in range(60):
        ring.update(seen(c0=4.0 - 0.05 * i), pose)
    (found,) = ring.objects
    assert (found.velocity_x, found.velocity_y) == pytest.approx((0.0, -1.0), abs=0.01)
    (point,) = ring.near(1.5, pose.heading)
    assert point == pytest.approx((1.05, 0.0, -1.0, 0.0), abs=0.01)


def test_object_that_jumps_is_a_new_one(pose: Odometry) -> None:
    ring = RangeRing(BODY, 0.05)
    ring.update(seen(c0=4.0), pose)
    ring.update(seen(c0=2.0), pose)
    assert (ring.objects[0].velocity_x, ring.objects[0].velocity_y) == (0.0, 0.0)


def test_failed_cone_keeps_its_last_range(pose: Odometry) -> None:
    ring = RangeRing(BODY, 0.05)
    ring.update(seen(c0=2.0), pose)
    ring.update(seen(c0="fault"), pose)
    assert [one.metres for one in ring.objects] == [2.0]


def test_gap_is_in_front_of_the_body_only(pose: Odometry) -> None:
    ring = RangeRing(BODY, 0.05)
    ring.update(seen(c12=0.4, c24=0.4), pose)
    assert ring.gap() == math.inf
    ring.update(seen(c0=1.0), pose)
    assert ring.gap() == pytest.approx(0.825)


def test_way_out_is_the_nearest_free_direction(pose: Odometry) -> None:
    ring = RangeRing(BODY, 0.05)
    ring.update(seen(**{f"c{i % CONES}": 0.5 for i in range(-2, 10)}), pose)
    assert ring.gap() < 0.4
    found = ring.way_out(0.0, 0.6)
    assert -math.pi / 2.0 < found < 0.0
    assert ring.gap(round(found / math.radians(7.5))) > 0.6
    assert ring.way_out(math.pi, 0.6) == pytest.approx(math.pi)
