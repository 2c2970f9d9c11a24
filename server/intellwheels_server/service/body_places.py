"""Where bodies are, and where they come in: their places, poses and the change by which they join."""

from __future__ import annotations

import msgspec

from intellwheels_schemas.file_records import Join
from intellwheels_schemas.messages import Position, Robot
from intellwheels_server.service.connected_agents import BridgeStatus
from intellwheels_server.service.roster import Member
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world import State
from intellwheels_server.world.kernels import rows


def body_join(service: ServiceState, member: Member) -> Join:
    """Return the change by which a member joins: its body at its place in the scene, and at nobody else's."""
    agent, robot = member.agent, member.robot
    if not member.has_body:
        return Join(agent=agent, robot=named(robot, agent))
    others = reserved_places(service, besides=agent)
    own = service.options.reserved.get(agent)
    if own in reserved_places(service) and robot.place is None and robot.position is None:
        robot = msgspec.structs.replace(robot, place=own)
    return Join(agent=agent, robot=named(robot, agent), reserved=others)


def reserved_places(service: ServiceState, besides: str = "") -> tuple[str, ...]:
    """Return the places that are kept for agents, sorted. A place that this map does not have is nobody's."""
    if not service.options.reserved:
        return ()
    grid = service.run.state.setup.floor.grid
    known = {spot.name for spot in grid.position} if grid is not None else set()
    reserved = service.options.reserved.items()
    return tuple(sorted(place for agent, place in reserved if agent != besides and place in known))


def is_unowned(service: ServiceState, agent: str) -> bool:
    """Return whether the body of an agent is here without the agent, which can happen after a restore.

    Bodies that an operator spawned do not count: they have no instance.
    """
    model = service.run.state.body_set.models.get(agent)
    return model is not None and model.robot.instance is not None and service.agents.roster.body(agent) is None


def bridge_status(state: State, agent: str, now: float) -> BridgeStatus:
    """Return the status of a real body that reports now, with its flags in the world. The body must be here."""
    flags = state.flags[:, state.body_set.index[agent]]
    return BridgeStatus(reported_at=now, stale=bool(flags[rows.STALE]), halted=bool(flags[rows.HALTED]))


def position_of(state: State, agent: str) -> Position:
    """Return the pose of a body. It must be here."""
    x, y, heading = state.numbers[[rows.X, rows.Y, rows.HEADING], state.body_set.index[agent]].tolist()
    return Position(x=x, y=y, heading=heading)


def named(robot: Robot, agent: str) -> Robot:
    """Return a robot with the name of its agent."""
    return robot if robot.name is not None else msgspec.structs.replace(robot, name=agent)
