"""Which agents hear a message: it depends on distance, on walls and doors between, and on chance."""

from __future__ import annotations

import math
from typing import Final

from numba import njit

from intellwheels_schemas.messages import Heard
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.line_of_sight import in_sight
from intellwheels_server.world.kernels.noise import noise_key, uniform
from intellwheels_server.world.kernels.spatial_query import place_boxes
from intellwheels_server.world.state import State, Utterance

SAY_STREAM: Final = "@say"
"""The noise stream of missed messages. No sensor can have this id, as none starts with `@`."""

VOICE_HEIGHT: Final = 1.2
"""Height of the mouth of a seated person, m: lower walls and doors do not stop speech."""


@njit(cache=True, error_model="numpy")
def _carries(
    numbers: Floats,
    parts: Floats,
    part_start: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    doors: Ints,
    x: float,
    y: float,
    listener: int,
) -> bool:
    """Return whether no wall and no door is between a point and a body, at the height of a voice."""
    boxes, _ = place_boxes(numbers, parts, part_start)
    return in_sight(
        x, y, VOICE_HEIGHT, numbers[rows.X, listener], numbers[rows.Y, listener], boxes, part_start, doors,
        pieces, links, edges, cells, frame,
    )  # fmt: skip


def heard_by(state: State, agent: str) -> tuple[Heard, ...]:
    """Return what an agent hears at this tick, in the order in which it was said.

    An operator is heard everywhere, and never missed. The distance is measured to where the speaker was when it spoke.
    What a listener misses follows from seed, speaker, tick and listener. Other agents have no influence.

    Raises:
        KeyError: There is no such body.
    """
    i = state.body_set.index[agent]
    found = []
    for utterance in state.heard:
        if utterance.sender == agent or (utterance.to is not None and utterance.to != agent):
            continue
        distance = 0.0
        if utterance.at is not None:
            dx = float(state.numbers[rows.X, i]) - utterance.at[0]
            dy = float(state.numbers[rows.Y, i]) - utterance.at[1]
            distance = math.sqrt(dx * dx + dy * dy)
            if distance > state.setup.say_range or _missed(state, utterance, i) or _blocked(state, utterance, i):
                continue
        found.append(
            Heard(
                sender=utterance.sender,
                tick=utterance.tick,
                seq=utterance.seq,
                distance=round(distance, 6),
                text=utterance.text,
            )
        )
    return tuple(found)


def _missed(state: State, utterance: Utterance, listener: int) -> bool:
    """Return whether a listener misses a message by chance."""
    if state.setup.say_loss <= 0.0:
        return False
    key0, key1 = noise_key(state.setup.seed, utterance.sender, SAY_STREAM)
    listener_key = state.body_set.models[state.names[listener]].key
    return bool(uniform(key0, key1, utterance.tick, listener_key) < state.setup.say_loss)


def _blocked(state: State, utterance: Utterance, listener: int) -> bool:
    """Return whether a wall or a door stops a message. The speaker and the listener themselves never do."""
    if not state.setup.say_walls or utterance.at is None:
        return False
    doors = state.body_set.doors.copy()
    doors[listener] = 0
    speaker = state.body_set.index.get(utterance.sender)
    if speaker is not None:
        doors[speaker] = 0
    bodies = state.body_set.bodies
    carries = _carries(
        state.numbers, bodies.parts, bodies.part_start, *state.walls, doors, utterance.at[0], utterance.at[1], listener
    )
    return not carries
