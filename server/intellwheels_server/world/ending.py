"""The end condition, evaluated after every step."""

from __future__ import annotations

from intellwheels_schemas.messages import End, Map
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.placement import place_named
from intellwheels_server.world.state import State


def end_reason(state: State, end: End) -> str | None:
    """Return why the run is over now, `reached` or `timeout`, or None.

    It is over when every `Reach` is met at the same tick, or when the time-out has passed. An agent that is not here
    has reached nothing.
    """
    if end.reach and all(_reached(state, reach.agent, reach.place, reach.within) for reach in end.reach):
        return "reached"
    if end.timeout is not None and state.time >= end.timeout.seconds - 1e-9:
        return "timeout"
    return None


def check_end(end: End, floor: Map) -> None:
    """Check that the map has every place that an end condition names.

    Raises:
        RequestRefusedError: `no-place`, with the places of the map.
    """
    for reach in end.reach:
        place_named(floor, reach.place)


def _reached(state: State, agent: str, place: str, within: float) -> bool:
    i = state.body_set.index.get(agent)
    if i is None:
        return False
    target = place_named(state.setup.floor, place)
    dx = float(state.numbers[rows.X, i]) - target.x
    dy = float(state.numbers[rows.Y, i]) - target.y
    return dx * dx + dy * dy <= within * within
