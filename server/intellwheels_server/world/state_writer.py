"""Writes the true state of all bodies as JSON, straight from the arrays, without making an entity of each.

The bytes are those that the codec writes of `observations.entities`, with what the service adds.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from intellwheels_schemas.codec import encode
from intellwheels_schemas.messages import Entity
from intellwheels_schemas.shapes import shape_of
from intellwheels_server.world.kernels import state_text as kernel
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.measures_text import STATES, Bytes
from intellwheels_server.world.observations import SAY_SHOWN
from intellwheels_server.world.state import BodyStatus, State

WRITTEN: Final = frozenset(
    {
        "name", "x", "y", "heading", "speed", "turn_rate", "left_output", "right_output", "collision", "contact",
        "contacts", "state", "mode", "goal", "say", "command_age", "travelled", "turned",
    }
)  # fmt: skip
"""The fields of `Entity` that are written here. As long as there is another one, nothing is."""

_KNOWS_ALL: Final = WRITTEN.issuperset(Entity.__struct_fields__)
_BARE: Final = Entity(name="a", x=0.0, y=0.0, heading=0.0)


class WrittenState(NamedTuple):
    """All bodies as bytes.

    Attributes:
        data: The entities in the order of their names, with a comma behind each.
        ends: The end of each entity in `data`, behind a 0.
    """

    data: bytes
    ends: list[int]


class StateWriter:
    """Writes states. What it prepares for a set of names is kept until another one comes."""

    def __init__(self) -> None:
        self._names: tuple[str, ...] | None = None
        self._text, self._fragments = _fragments()
        self._name_text: Bytes = np.empty(0, np.uint8)
        self._name_ends: Ints = np.zeros(1, np.int64)
        self._none: Ints = np.zeros(1, np.int64)
        self._words: dict[str, tuple[BodyStatus, bool, bytes]] = {}

    def write(self, state: State, ages: Mapping[str, float], paths: Floats) -> WrittenState | None:
        """Return all bodies, or None if there is a number or a field that cannot be written here.

        Args:
            state: The world.
            ages: The mean age of the commands of agents, s; 0 for others.
            paths: float64[2, n], the length of the path of each body, m, and the angle that it turned, rad; NaN where
                they are not known.
        """
        if not _KNOWS_ALL:
            return None
        names = state.names
        if names is not self._names:
            self._take_names(names)
        more, more_ends = self._all_words(state)
        old = np.zeros(len(names))
        for name, age in ages.items():
            if (at := state.body_set.index.get(name)) is not None:
                old[at] = age
        per_body = len(self._text) + kernel.NUMBER_BYTES
        out = np.empty(len(names) * per_body + len(self._name_text) + len(more), np.uint8)
        ends = np.empty(len(names) + 1, np.int64)
        done = kernel.write_entities(
            self._name_text,
            self._name_ends,
            self._text,
            self._fragments,
            np.frombuffer(more, np.uint8),
            more_ends,
            old,
            paths,
            state.body_set.motors,
            state.flags,
            state.numbers,
            out,
            ends,
        )
        return WrittenState(out[: ends[-1]].tobytes(), ends.tolist()) if done else None

    def _take_names(self, names: tuple[str, ...]) -> None:
        self._names = names
        self._name_text = np.frombuffer("".join(names).encode(), np.uint8)
        self._name_ends = np.cumsum([0, *(len(name) for name in names)], dtype=np.int64)
        self._none = np.zeros(len(names) + 1, np.int64)
        here = set(names)
        self._words = {name: words for name, words in self._words.items() if name in here}

    def _all_words(self, state: State) -> tuple[bytes, Ints]:
        """Return what bodies say of themselves, and where it ends for each."""
        if not state.statuses:
            return b"", self._none
        sizes = np.zeros(len(state.names) + 1, np.int64)
        index, latest = state.body_set.index, state.tick - SAY_SHOWN / state.setup.period
        found = {}
        for name, status in state.statuses.items():
            at = index.get(name)
            if at is not None and (words := self._words_of(name, status, latest)):
                sizes[at + 1] = len(words)
                found[at] = words
        return b"".join(found[at] for at in sorted(found)), np.cumsum(sizes)

    def _words_of(self, name: str, status: BodyStatus, latest: float) -> bytes:
        says = status.say is not None and status.say_tick >= latest
        known = self._words.get(name)
        if known is not None and known[0] is status and known[1] is says:
            return known[2]
        told = Entity(
            name="a", x=0.0, y=0.0, heading=0.0, mode=status.mode, goal=status.goal, say=status.say if says else None
        )
        words = encode(told)[len(encode(_BARE)) - 1 : -1]
        self._words[name] = status, says, words
        return words


def _fragments() -> tuple[Bytes, Ints]:
    """Return the fixed bytes, and the fragments in them in the order of `kernels.state_text`."""
    wires = {member.name: member.wire for member in shape_of(Entity).members}
    texts = [f'{{"{wires["name"]}":"', f'","{wires["x"]}":']
    texts += [f',"{wires[name]}":' for name in ("y", "heading", "speed", "turn_rate", "left_output", "right_output")]
    texts += [f',"{wires["collision"]}":true', f',"{wires["contact"]}":true']
    texts += [f',"{wires[name]}":' for name in ("contacts", "command_age", "travelled", "turned")]
    texts.append("},")
    bare = len(encode(_BARE)) - 1
    texts += [encode(Entity(name="a", x=0.0, y=0.0, heading=0.0, state=state))[bare:-1].decode() for state in STATES]
    ends = np.cumsum([0, *(len(text) for text in texts)])
    places = np.stack([ends[:-1], ends[1:]], axis=1).astype(np.int64)
    return np.frombuffer("".join(texts).encode(), np.uint8), np.ascontiguousarray(places)
