"""The end condition: data, evaluated after every step."""

from __future__ import annotations

from intellwheels_schemas.messages import End, Map
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.placement import place_named
from intellwheels_server.world.state import State


def end_reason(state: State, end: End) -> str | None:
    """Return why the run is over now, in words, or None.

    It is over once every `Reach` is met at the same tick, or at the first tick at or after the time-out. An agent
    that is not here has reached nothing.
    """
    if end.reach and all(_reached(state, reach.agent, reach.place, reach.within) for reach in end.reach):
        return "reached"
    if end.timeout is not None and state.time >= end.timeout.seconds - 1e-9:
        return "timeout"
    return None


def check_end(end: End, floor: Map) -> None:
    """Raise where an end condition names a place that the floor has not.

    Raises:
        RequestRefusedError: `no-place`, with the places there are.
    """
    for reach in end.reach:
        place_named(floor, reach.place)


def _reached(state: State, agent: str, place: str, within: float) -> bool:
    i = state.body_set.index.get(agent)
    if i is None:
        return False
    spot = place_named(state.setup.floor, place)
    dx = float(state.numbers[rows.X, i]) - spot.x
    dy = float(state.numbers[rows.Y, i]) - spot.y
    return dx * dx + dy * dy <= within * within
