"""Episodes of contact that begin or end in a step, their counts and their events."""

from __future__ import annotations

import math

import numpy as np

from intellwheels_schemas.messages import Event
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import (
    HIT_BODY,
    HIT_CLOSING,
    HIT_NORMAL_X,
    HIT_NORMAL_Y,
    HIT_OTHER,
    HIT_OTHER_PART,
    HIT_PART,
    HIT_WALL,
    HIT_WHO,
    HIT_X,
    HIT_Y,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.episodes import merge_episodes
from intellwheels_server.world.kernels.tick_kernel import pair_keys
from intellwheels_server.world.state import State

EPISODE_GAP = 0.25
"""Simulated seconds without touch after which an episode ends."""

_ONLY_THE_OTHER = 2


def update_episodes(
    state: State, hits: Ints, hit_numbers: Floats, flags: Ints, first_number: int
) -> tuple[Ints, list[Event]]:
    """Return the episodes after a step, and the events of those that began and ended.

    Args:
        state: The state before the step.
        hits: The pairs that touched, as `tick_all` returns them.
        hit_numbers: Their numbers.
        flags: int64[FLAG_ROWS, n], written: an episode that begins is counted for both bodies.
        first_number: The number of the first event.
    """
    if hits.shape[0] == 0 and state.episodes.shape[0] == 0:
        return state.episodes, []
    period = state.setup.period
    pairs = pair_keys(hits, state.body_set.bodies.marks)
    if len(pairs) > 1:
        pairs = pairs[np.lexsort((hits[:, HIT_WALL], pairs[:, 1], pairs[:, 0]))]
    hold = max(1, math.ceil(EPISODE_GAP / period - 1e-9))
    episodes, began, ended = merge_episodes(state.episodes, pairs, state.tick + 1, hold)
    events: list[Event] = []
    for k in began.tolist():
        body, other = int(hits[k, HIT_BODY]), int(hits[k, HIT_OTHER])
        flags[rows.CONTACTS, body] += 1
        if other >= 0:
            flags[rows.CONTACTS, other] += 1
        events.append(_contact(state, hits[k].tolist(), hit_numbers[k].tolist(), first_number + len(events)))
    for first, second in ended.tolist():
        events.append(_parted(state, first, second, first_number + len(events)))
    return episodes, events


def _contact(state: State, hit: list[int], numbers: list[float], number: int) -> Event:
    """Return the event of the body that ran into the other; if both did, of the first by name."""
    names = state.names
    x, y, speed = numbers[HIT_X], numbers[HIT_Y], numbers[HIT_CLOSING] / state.setup.period
    normal_x, normal_y = numbers[HIT_NORMAL_X], numbers[HIT_NORMAL_Y]
    body, part, other_part = hit[HIT_BODY], hit[HIT_PART], hit[HIT_OTHER_PART]
    if hit[HIT_WALL] >= 0:
        other = "wall"
        other_part = hit[HIT_WALL]
    else:
        second = hit[HIT_OTHER]
        swapped = hit[HIT_WHO] == _ONLY_THE_OTHER or (hit[HIT_WHO] != 1 and names[second] < names[body])
        if swapped:
            body, second, part, other_part = second, body, other_part, part
            normal_x, normal_y = -normal_x, -normal_y
        other = names[second]
    return Event(
        run=state.run,
        tick=state.tick + 1,
        number=number,
        code="contact",
        agent=names[body],
        other=other,
        part=part,
        other_part=other_part,
        x=_inside(x),
        y=_inside(y),
        normal_x=_unit(normal_x),
        normal_y=_unit(normal_y),
        speed=round(min(max(speed, -rows.MOST_SPEED), rows.MOST_SPEED), 6) + 0.0,
    )


def _parted(state: State, first: int, second: int, number: int) -> Event:
    known = state.body_set.by_key
    agent, other = known.get(first), "wall" if second == rows.WALL_KEY else known.get(second)
    if other is not None and other != "wall" and agent is not None and other < agent:
        agent, other = other, agent
    return Event(run=state.run, tick=state.tick + 1, number=number, code="parted", agent=agent, other=other)


def _inside(value: float) -> float:
    """Return a coordinate in the range of a message: a body at the edge of the world may touch beyond it."""
    return round(min(max(value, -rows.WORLD_EDGE), rows.WORLD_EDGE), 6) + 0.0


def _unit(value: float) -> float:
    return min(max(round(value, 6), -1.0), 1.0) + 0.0
