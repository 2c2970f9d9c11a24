"""The messages and services of `simulation_interfaces` 2.1 that the gateway uses, as field lists.

Source:
    ROS package simulation_interfaces 2.1.0, Apache License 2.0. The type hashes in the tests are those of its C code.
"""

from __future__ import annotations

from typing import Final

PACKAGE: Final = "simulation_interfaces"

MESSAGES: Final[dict[str, str]] = {
    "Resource": "string uri; string resource_string",
    "Result": "uint8 result; string error_message",
    "SimulationState": "uint8 state",
    "SimulatorFeatures": "uint16[] features; string[] spawn_formats; string custom_info",
    "EntityCategory": "uint8 category",
    "EntityInfo": "EntityCategory category; string description; string[] tags",
    "EntityState": (
        "std_msgs/Header header; geometry_msgs/Pose pose; geometry_msgs/Twist twist; geometry_msgs/Accel acceleration"
    ),
    "Bounds": "uint8 type; geometry_msgs/Vector3[] points",
    "TagsFilter": "string[] tags; uint8 filter_mode",
    "EntityFilters": "string filter; EntityCategory[] categories; TagsFilter tags; Bounds bounds",
    "NamedPose": "string name; string description; string[] tags; geometry_msgs/Pose pose",
    "Spawnable": "Resource entity_resource; string description; Bounds spawn_bounds",
    "WorldResource": "string name; Resource world_resource; string description; string[] tags",
}
"""The fields of each message."""

SERVICES: Final[dict[str, tuple[str, str]]] = {
    "GetSimulatorFeatures": ("", "SimulatorFeatures features"),
    "GetSimulationState": ("", "SimulationState state; Result result"),
    "SetSimulationState": ("SimulationState state", "Result result"),
    "StepSimulation": ("uint64 steps", "Result result"),
    "ResetSimulation": ("uint8 scope", "Result result"),
    "GetSpawnables": ("string[] sources", "Result result; Spawnable[] spawnables"),
    "SpawnEntity": (
        "string name; bool allow_renaming; Resource entity_resource; string entity_namespace; "
        "geometry_msgs/PoseStamped initial_pose",
        "Result result; string entity_name",
    ),
    "DeleteEntity": ("string entity", "Result result"),
    "GetEntities": ("EntityFilters filters", "Result result; string[] entities"),
    "GetEntitiesStates": ("EntityFilters filters", "Result result; string[] entities; EntityState[] states"),
    "GetEntityState": ("string entity", "Result result; EntityState state"),
    "SetEntityState": (
        "string entity; EntityState state; bool set_pose; bool set_twist; bool set_acceleration", "Result result"
    ),
    "GetEntityInfo": ("string entity", "Result result; EntityInfo info"),
    "GetNamedPoses": ("TagsFilter tags", "Result result; NamedPose[] poses"),
    "GetAvailableWorlds": (
        "string[] additional_sources; TagsFilter filter; bool offline_only; bool continue_on_error",
        "Result result; WorldResource[] worlds",
    ),
    "GetCurrentWorld": ("", "Result result; WorldResource world"),
    "LoadWorld": (
        "Resource world_resource; bool fail_on_unsupported_element; bool ignore_missing_or_unsupported_assets",
        "Result result; WorldResource world",
    ),
}  # fmt: skip
"""The fields of the request and of the response of each service."""
