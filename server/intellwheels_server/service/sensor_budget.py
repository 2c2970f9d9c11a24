"""What the sensors of a robot may cost, checked when it joins or is spawned.

Rays are limited in real time only: a run at another pace takes the time it needs. The size of a robot's `Measures` is
limited always, because every reader must be able to take them.
"""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.codec import MAX_BYTES
from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Robot
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world import State
from intellwheels_server.world.sensors import rays_of, reading_bytes_of

HEARD_BYTES: Final = MAX_BYTES // 4
"""Bytes of `Measures` that are left for everything but readings: mostly what the agent hears."""
MAX_READING_BYTES: Final = MAX_BYTES - HEARD_BYTES


def check_sensor_budget(service: ServiceState, agent: str, robot: Robot, waiting: float = 0.0) -> None:
    """Refuse a robot whose sensors cost too much.

    Args:
        service: The service.
        agent: The agent whose robot it is. If it has a body already, the robot replaces that.
        robot: The robot.
        waiting: Rays per tick of bodies that come in together with it.

    Raises:
        RequestRefusedError: `limit` if it asks for more than one agent may, `full` if the others leave too little.
    """
    size = reading_bytes_of(robot)
    if size > MAX_READING_BYTES:
        raise RequestRefusedError(
            "limit",
            f"Robot: expected sensors whose readings fit into {MAX_READING_BYTES:,} bytes, got up to {size:,} bytes; "
            "use fewer sensors or fewer Rays",
        )
    if service.pacing.pace != "realtime":
        return
    options, state = service.options, service.run.state
    own = rays_of(robot) / state.setup.period
    if own > options.agent_rays:
        raise RequestRefusedError(
            "limit",
            f"Robot: expected sensors of at most {options.agent_rays:,} rays a second, got {own:,.0f}; "
            "use fewer Rays or a larger Every, or start the simulator with another --agent-rays",
        )
    models = state.body_set.models
    present = state.body_set.rays
    if agent in models:
        present = sum(model.rays for name, model in models.items() if name != agent)
    others = (present + waiting) / state.setup.period
    if own > 0.0 and own + others > options.world_rays:
        raise RequestRefusedError(
            "full",
            f"Robot: expected sensors of at most {options.world_rays:,} rays a second in the whole world, "
            f"got {own:,.0f} in addition to {others:,.0f} of other agents; "
            "the simulator's option --world-rays sets the limit",
        )


def total_rays(state: State) -> int:
    """Return the rays per tick of all bodies, rounded."""
    return round(state.body_set.rays)


def costliest(state: State) -> str | None:
    """Return the agent whose sensors cast the most rays, or None if none cast any."""
    return state.body_set.costliest
