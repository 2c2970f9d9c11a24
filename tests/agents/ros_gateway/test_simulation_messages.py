"""Messages for bodies and maps."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.ros_gateway.ros_types import encode_message
from intellwheels_agents.ros_gateway.simulation_messages import (
    TYPE_BOX,
    entity_state,
    named_pose,
    spawnable,
    world_resource,
)
from intellwheels_maps import robot
from intellwheels_schemas.messages import Entity, Place


def test_state_has_its_twist_in_the_map_frame() -> None:
    state = entity_state(Entity(name="c", x=1.0, y=2.0, heading=math.pi / 2.0, speed=0.5, turn_rate=0.1), 1.5)
    assert state.header.frame_id == "map"
    assert (state.twist.linear.x, state.twist.linear.y, state.twist.angular.z) == pytest.approx((0.0, 0.5, 0.1))
    assert encode_message(state)


def test_spawnable_is_in_a_box() -> None:
    found = spawnable("intellwheels", robot("intellwheels"))
    upper, lower = found.spawn_bounds.points
    assert (found.entity_resource.uri, found.spawn_bounds.type) == ("intellwheels", TYPE_BOX)
    assert (upper.x, upper.y, upper.z, lower.x) == pytest.approx((0.696, 0.33, 1.3, -0.504))


def test_place_and_world() -> None:
    place = named_pose(Place(name="goal1", x=1.0, y=2.0, heading_deg=180.0, kinds=("goal",)))
    assert (place.name, place.tags, place.pose.position.y) == ("goal1", ["goal"], 2.0)
    assert abs(place.pose.orientation.z) == pytest.approx(1.0)
    assert world_resource("ward", "ward", "A ward").world_resource.uri == "ward"
