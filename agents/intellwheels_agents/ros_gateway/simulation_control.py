"""The services of `simulation_interfaces`, answered with the control verbs of the contract. Pure but for its `World`.

A response has the result code of the contract's `Result` (`RESULT_CODES`), or a code of the service itself (101 and
up). An option of a request that cannot be honoured is refused with FEATURE_UNSUPPORTED, never ignored.

Source:
    ROS package simulation_interfaces 2.1.0: the result codes, the features and the states.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, Protocol

import msgspec
import numpy as np

from intellwheels_agents.ros_gateway.entity_filter import category_of, matching, tags_match, tags_of
from intellwheels_agents.ros_gateway.plane_pose import PlanePose, pose_on_floor
from intellwheels_agents.ros_gateway.robot_frames import MAP
from intellwheels_agents.ros_gateway.ros_types import blank
from intellwheels_agents.ros_gateway.simulation_messages import entity_state, named_pose, spawnable, world_resource
from intellwheels_agents.ros_gateway.simulation_types import PACKAGE
from intellwheels_maps import names, robot
from intellwheels_schemas.codec import decode, encoding_of
from intellwheels_schemas.errors import WireError, wrong_value
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import (
    Body,
    Clock,
    Delete,
    Entity,
    Load,
    Map,
    Pause,
    Position,
    Quit,
    Record,
    Reset,
    Result,
    Resume,
    Robot,
    Spawn,
    Step,
    Teleport,
)
from intellwheels_schemas.names import check_agent
from intellwheels_schemas.version import version_text

UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, FAILED = range(5)
RESULT_CODES: Final = {
    "ok": OK, "unsupported": UNSUPPORTED, "not-found": NOT_FOUND, "incorrect-state": INCORRECT_STATE, "failed": FAILED,
}  # fmt: skip
"""The code of ROS for each code of a `Result`."""

NAME_NOT_UNIQUE, NAME_INVALID, UNSUPPORTED_FORMAT, NO_RESOURCE, NAMESPACE_INVALID, PARSE_ERROR = range(101, 107)
SPAWN_INVALID_POSE: Final = 109
STATE_INVALID_POSE: Final = 101
WORLD_NO_RESOURCE, WORLD_PARSE_ERROR = 102, 103
ALREADY_IN_STATE: Final = 101
STOPPED, PLAYING, PAUSED, QUITTING = range(4)
_SCOPES: Final = (0, 255)
"""The scopes of a reset that mean everything."""
_STATES: Final = {"waiting": STOPPED, "ended": STOPPED, "running": PLAYING, "paused": PAUSED}
FEATURES: Final = (
    0, 1, 2, 4, 8, 9,  # spawn, delete, named poses, tags, categories, spawn from text
    10, 11, 12, 14,  # entity state, set entity state, entity info, spawnables
    20, 24, 25, 26,  # reset, state, set state, pause
    31, 32,  # single and multiple steps
    40, 41, 43, 44,  # load a world, from text, the current world, the worlds
)  # fmt: skip
"""The features of `SimulatorFeatures` that are supported."""
MOST_STEPS: Final = 1_000_000
_WORLD_FRAMES: Final = ("", "world", MAP)


class World(Protocol):
    """A world, as a client of the contract sees it. Every method raises `ConnectionError` without an answer."""

    def control(self, verb: Verb, message: Record) -> Result:
        """Send a control verb, and return its result, also that of an error reply."""
        ...

    def clock(self) -> Clock:
        """Return the clock."""
        ...

    def bodies(self) -> Sequence[Body]:
        """Return all bodies."""
        ...

    def entities(self) -> tuple[float, Sequence[Entity]]:
        """Return the simulated time, s, and the true states of all bodies."""
        ...

    def floor(self) -> Map:
        """Return the map."""
        ...


class _RefusedError(Exception):
    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class SimulationControl:
    """Answers requests."""

    def __init__(self, world: World) -> None:
        """Take the world that is controlled."""
        self._world = world

    def services(self) -> Mapping[str, tuple[str, Callable[[Any], Any]]]:
        """Return the services by name: the type, and the function that answers a request."""
        table: dict[str, Callable[[Any, Any], None]] = {
            "GetSimulatorFeatures": self._features, "GetSimulationState": self._state,
            "SetSimulationState": self._set_state, "StepSimulation": self._step, "ResetSimulation": self._reset,
            "GetSpawnables": self._spawnables, "SpawnEntity": self._spawn, "DeleteEntity": self._delete,
            "GetEntities": self._entities, "GetEntitiesStates": self._entities_states,
            "GetEntityState": self._entity_state, "SetEntityState": self._set_entity_state,
            "GetEntityInfo": self._entity_info, "GetNamedPoses": self._named_poses,
            "GetAvailableWorlds": self._worlds, "GetCurrentWorld": self._current_world, "LoadWorld": self._load,
        }  # fmt: skip
        return {
            f"/{_snake(name)}": (f"{PACKAGE}/srv/{name}", self._guarded(name, fill)) for name, fill in table.items()
        }

    def _guarded(self, name: str, fill: Callable[[Any, Any], None]) -> Callable[[Any], Any]:
        """Return the function that makes a response, lets `fill` complete it, and turns errors into result codes."""

        def answer(request: Any) -> Any:
            response = blank(f"{PACKAGE}/srv/{name}_Response")
            try:
                if hasattr(response, "result"):
                    response.result.result = OK
                fill(request, response)
            except _RefusedError as error:
                response.result.result, response.result.error_message = error.code, str(error)
            except (WireError, ConnectionError) as error:
                response.result.result, response.result.error_message = FAILED, str(error)
            return response

        return answer

    def _do(self, verb: Verb, message: Record) -> None:
        result = self._world.control(verb, message)
        if result.code != "ok":
            raise _RefusedError(RESULT_CODES[result.code], result.text or result.code)

    # ------------------------------------------------------------ the run

    def _features(self, _request: Any, response: Any) -> None:
        features = response.features
        features.features = np.array(FEATURES, dtype=np.uint16)
        features.spawn_formats = ["iw.v1"]
        features.custom_info = version_text()

    def _state(self, _request: Any, response: Any) -> None:
        response.state.state = _STATES[self._world.clock().state]

    def _set_state(self, request: Any, _response: Any) -> None:
        wanted = request.state.state
        if wanted not in (STOPPED, PLAYING, PAUSED, QUITTING):
            raise _RefusedError(UNSUPPORTED, f"state: expected 0 to 3, got {wanted}")
        if wanted == QUITTING:
            self._do("quit", Quit())
            return
        clock = self._world.clock()
        if wanted == STOPPED:
            if clock.state == "paused" and clock.tick == 0:
                raise _RefusedError(ALREADY_IN_STATE, "the run is stopped: paused at its start")
            self._do("pause", Pause())
            self._do("reset", Reset())
            return
        if _STATES[clock.state] == wanted:
            raise _RefusedError(ALREADY_IN_STATE, f"the run is {clock.state}")
        self._do(*(("resume", Resume()) if wanted == PLAYING else ("pause", Pause())))

    def _step(self, request: Any, _response: Any) -> None:
        if not 1 <= request.steps <= MOST_STEPS:
            raise _RefusedError(FAILED, f"steps: expected a whole number in [1, {MOST_STEPS}], got {request.steps}")
        self._do("step", Step(count=int(request.steps)))

    def _reset(self, request: Any, _response: Any) -> None:
        if request.scope not in _SCOPES:
            raise _RefusedError(UNSUPPORTED, f"scope: expected SCOPE_DEFAULT or SCOPE_ALL, got {request.scope}")
        self._do("reset", Reset())

    # ------------------------------------------------------------ bodies

    def _spawnables(self, request: Any, response: Any) -> None:
        if request.sources:
            raise _RefusedError(UNSUPPORTED, f"sources: expected none, got {request.sources[0]!r}")
        response.spawnables = [spawnable(name, robot(name)) for name in names("robots")]

    def _spawn(self, request: Any, response: Any) -> None:
        if request.entity_namespace:
            raise _RefusedError(NAMESPACE_INVALID, "entity_namespace: expected none, a spawned body has no topics")
        document = _resource(request.entity_resource)
        name = self._free_name(request.name, document, renames=request.allow_renaming)
        pose = _pose_in_world(request.initial_pose, "initial_pose", SPAWN_INVALID_POSE)
        body = msgspec.structs.replace(document, format=None, name=name, barrier=None)
        self._do("spawn", Spawn(robot=body, position=_position(pose)))
        response.entity_name = name

    def _free_name(self, wanted: str, document: Robot, *, renames: bool) -> str:
        """Return the name of a new body."""
        if wanted or not renames:
            try:
                check_agent(wanted, "name")
            except WireError as error:
                raise _RefusedError(NAME_INVALID, error.text) from None
        taken = {body.robot.name for body in self._world.bodies()}
        if wanted and wanted not in taken:
            return wanted
        if not renames:
            raise _RefusedError(NAME_NOT_UNIQUE, f"name: expected one that no body has, got {wanted!r}")
        stem = (wanted or document.kind.lower().replace(".", "-"))[:24]
        free = (f"{stem}-{number}" for number in range(1, len(taken) + 2))
        return check_agent(next(name for name in free if name not in taken), "name")

    def _delete(self, request: Any, _response: Any) -> None:
        self._do("delete", Delete(agent=_agent(request.entity)))

    def _entities(self, request: Any, response: Any) -> None:
        response.entities = [name for name, _ in self._found(request.filters)[1]]

    def _entities_states(self, request: Any, response: Any) -> None:
        seconds, found = self._found(request.filters)
        response.entities = [name for name, _ in found]
        response.states = [entity_state(entity, seconds) for _, entity in found]

    def _found(self, filters: Any) -> tuple[float, list[tuple[str, Entity]]]:
        """Return the bodies that filters let pass, in the order of their names."""
        robots = {body.robot.name: body.robot for body in self._world.bodies()}
        seconds, entities = self._world.entities()
        known = [(entity, robots[entity.name]) for entity in entities if entity.name in robots]
        try:
            passed = matching(filters, known)
        except WireError as error:
            raise _RefusedError(UNSUPPORTED, error.text) from None
        return seconds, [(entity.name, entity) for entity in passed]

    def _entity_state(self, request: Any, response: Any) -> None:
        seconds, entities = self._world.entities()
        for entity in entities:
            if entity.name == request.entity:
                response.state = entity_state(entity, seconds)
                return
        raise _RefusedError(NOT_FOUND, f"entity: expected one of the bodies, got {request.entity[:80]!r}")

    def _set_entity_state(self, request: Any, _response: Any) -> None:
        if request.set_twist or request.set_acceleration:
            raise _RefusedError(UNSUPPORTED, "expected set_pose only: motors move a body")
        if request.set_pose:
            pose = _pose_in_world(request.state, "state", STATE_INVALID_POSE)
            self._do("teleport", Teleport(agent=_agent(request.entity), position=_position(pose)))

    def _entity_info(self, request: Any, response: Any) -> None:
        for body in self._world.bodies():
            if body.robot.name == request.entity:
                response.info.category.category = category_of(body.robot.kind)
                response.info.description = body.robot.kind
                response.info.tags = tags_of(body.robot)
                return
        raise _RefusedError(NOT_FOUND, f"entity: expected one of the bodies, got {request.entity[:80]!r}")

    # ------------------------------------------------------------ the map

    def _named_poses(self, request: Any, response: Any) -> None:
        grid = self._world.floor().grid
        places = grid.position if grid is not None else ()
        response.poses = [named_pose(place) for place in places if tags_match(request.tags, place.kinds)]

    def _worlds(self, request: Any, response: Any) -> None:
        if request.additional_sources:
            first = request.additional_sources[0]
            raise _RefusedError(UNSUPPORTED, f"additional_sources: expected none, got {first[:80]!r}")
        if tags_match(request.filter, ()):
            response.worlds = [world_resource(name, name, "") for name in names("floors")]

    def _current_world(self, _request: Any, response: Any) -> None:
        document = self._world.floor()
        uri = document.name if document.name in names("floors") else ""
        response.world = world_resource(document.name, uri, document.title or "")

    def _load(self, request: Any, response: Any) -> None:
        uri, text = request.world_resource.uri, request.world_resource.resource_string
        if not uri and not text:
            raise _RefusedError(WORLD_NO_RESOURCE, "world_resource: expected a uri or a resource_string, got none")
        if uri and uri not in names("floors"):
            raise _RefusedError(NOT_FOUND, f"uri: expected one of {', '.join(names('floors'))}, got {uri[:80]!r}")
        try:
            load = Load(name=uri) if uri else Load(map=_decoded(Map, text))
        except WireError as error:
            raise _RefusedError(WORLD_PARSE_ERROR, error.text) from None
        self._do("load", load)
        self._current_world(request, response)


def _snake(name: str) -> str:
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).removeprefix("_")


def _decoded(kind: type[Any], text: str) -> Any:
    data = text.strip().encode()
    return decode(kind, data, encoding_of("", data))


def _resource(resource: Any) -> Robot:
    """Return the robot that a resource names or contains."""
    uri, text = resource.uri, resource.resource_string
    if not uri and not text:
        raise _RefusedError(NO_RESOURCE, "entity_resource: expected a uri or a resource_string, got none")
    if uri:
        if uri not in names("robots"):
            expected = f"expected one of {', '.join(names('robots'))}"
            raise _RefusedError(UNSUPPORTED_FORMAT, f"uri: {expected}, got {uri[:80]!r}")
        return robot(uri)
    try:
        found: Robot = _decoded(Robot, text)
    except WireError as error:
        raise _RefusedError(PARSE_ERROR, error.text) from None
    return found


def _agent(name: str) -> str:
    try:
        return check_agent(name, "entity")
    except WireError as error:
        raise _RefusedError(NOT_FOUND, error.text) from None


def _pose_in_world(stamped: Any, where: str, code: int) -> PlanePose:
    try:
        if stamped.header.frame_id not in _WORLD_FRAMES:
            raise wrong_value(f"{where}.header.frame_id", "map or world", repr(stamped.header.frame_id[:80]))
        return pose_on_floor(stamped.pose, where)
    except WireError as error:
        raise _RefusedError(code, error.text) from None


def _position(pose: PlanePose) -> Position:
    return Position(x=pose.x, y=pose.y, heading=pose.heading)
