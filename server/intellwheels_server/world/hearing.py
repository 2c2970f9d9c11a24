"""Who hears what is said: by distance, by what stands between, by chance."""

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
"""The noise stream of what a speaker's listeners miss; no sensor's id can begin so."""

VOICE_HEIGHT: Final = 1.2
"""Height of a seated person's mouth, m: what ends below it keeps no voice."""


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
    """Return whether no wall and no door is between a place and a body, at the height of a voice."""
    boxes, _ = place_boxes(numbers, parts, part_start)
    return in_sight(
        x, y, VOICE_HEIGHT, numbers[rows.X, listener], numbers[rows.Y, listener], boxes, part_start, doors,
        pieces, links, edges, cells, frame,
    )  # fmt: skip


def heard_by(state: State, agent: str) -> tuple[Heard, ...]:
    """Return what an agent hears at this tick, in the order it was said.

    An operator is heard everywhere and never missed. The distance is that to where the speaker was when it spoke. What
    a listener misses follows from seed, speaker, tick and listener, so it does not depend on who else is there.

    Raises:
        KeyError: No such body is here.
    """
    i = state.body_set.index[agent]
    found = []
    for words in state.heard:
        if words.sender == agent or (words.to is not None and words.to != agent):
            continue
        distance = 0.0
        if words.at is not None:
            dx = float(state.numbers[rows.X, i]) - words.at[0]
            dy = float(state.numbers[rows.Y, i]) - words.at[1]
            distance = math.sqrt(dx * dx + dy * dy)
            if distance > state.setup.say_range or _missed(state, words, i) or _kept(state, words, i):
                continue
        found.append(Heard(sender=words.sender, tick=words.tick, seq=words.seq, distance=distance, text=words.text))
    return tuple(found)


def _missed(state: State, words: Utterance, listener: int) -> bool:
    """Return whether a listener misses the words by chance."""
    if state.setup.say_loss <= 0.0:
        return False
    key0, key1 = noise_key(state.setup.seed, words.sender, SAY_STREAM)
    draw = state.body_set.figures[state.names[listener]].key
    return bool(uniform(key0, key1, words.tick, draw) < state.setup.say_loss)


def _kept(state: State, words: Utterance, listener: int) -> bool:
    """Return whether a wall or a door keeps the words from a listener; speaker and listener are in nobody's way."""
    if not state.setup.say_walls or words.at is None:
        return False
    doors = state.body_set.doors.copy()
    doors[listener] = 0
    speaker = state.body_set.index.get(words.sender)
    if speaker is not None:
        doors[speaker] = 0
    bodies = state.body_set.bodies
    carries = _carries(
        state.numbers, bodies.parts, bodies.part_start, *state.walls, doors, words.at[0], words.at[1], listener
    )
    return not carries
