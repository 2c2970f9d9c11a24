"""Messages of `simulation_interfaces` for bodies and maps. Pure."""

from __future__ import annotations

import math
from typing import Any

from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.robot_frames import MAP
from intellwheels_agents.ros_gateway.ros_messages import accel_message, header, pose_message, twist_message, vector
from intellwheels_agents.ros_gateway.ros_types import made_of
from intellwheels_agents.ros_gateway.simulation_types import PACKAGE
from intellwheels_schemas.messages import Entity, Place, Robot
from intellwheels_schemas.rules import parts_of

TYPE_BOX = 1
"""Bounds that are a box: its upper right and its lower left corner."""


def _type(name: str) -> Any:
    return made_of(f"{PACKAGE}/msg/{name}")


def spawnable(name: str, document: Robot) -> Any:
    """Return the `Spawnable` of an included robot: its name as URI, its kind, and the box around it."""
    parts = parts_of(document)
    upper = vector(
        max(part.x + part.length / 2.0 for part in parts),
        max(part.y + part.width / 2.0 for part in parts),
        max(part.top for part in parts),
    )
    lower = vector(
        min(part.x - part.length / 2.0 for part in parts),
        min(part.y - part.width / 2.0 for part in parts),
        min(part.bottom for part in parts),
    )
    return _type("Spawnable")(
        entity_resource=_type("Resource")(uri=name, resource_string=""),
        description=document.kind,
        spawn_bounds=_type("Bounds")(type=TYPE_BOX, points=[upper, lower]),
    )


def entity_state(entity: Entity, seconds: float) -> Any:
    """Return the `EntityState` of a body at a simulated time, s; pose and twist are in the map frame."""
    along_x, along_y = entity.speed * math.cos(entity.heading), entity.speed * math.sin(entity.heading)
    return _type("EntityState")(
        header=header(MAP, seconds),
        pose=pose_message(PlanePose(entity.x, entity.y, entity.heading)),
        twist=twist_message(along_x, entity.turn_rate, along_y),
        acceleration=accel_message(),
    )


def named_pose(place: Place) -> Any:
    """Return the `NamedPose` of a place of the map; the kinds of body that it is for are its tags."""
    pose = pose_message(PlanePose(place.x, place.y, math.radians(place.heading_deg)))
    return _type("NamedPose")(name=place.name, description="", tags=list(place.kinds), pose=pose)


def world_resource(name: str, uri: str, title: str) -> Any:
    """Return the `WorldResource` of a map."""
    resource = _type("Resource")(uri=uri, resource_string="")
    return _type("WorldResource")(name=name, world_resource=resource, description=title, tags=[])
