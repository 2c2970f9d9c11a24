"""The state of the world, split into messages of at most 48 kB. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import msgspec

from intellwheels_schemas.messages import Entity, WorldState
from intellwheels_server.world.state_writer import WrittenState

PART_BYTES: Final = 48_000
"""Size of a part as JSON: messages above 60 kB delay a healthy reader a hundredfold."""

_HEADER_BYTES: Final = 200
"""More than a message takes besides its entities."""

_encode = msgspec.json.Encoder().encode


def split_state(
    run: str, tick: int, time: float, entities: Sequence[Entity], limit: int = PART_BYTES
) -> list[WorldState]:
    """Return at least one part, with the entities in order; each part is within the limit as JSON."""
    chunks = _chunks(entities, limit)
    return [
        WorldState(run=run, tick=tick, time=time, part=part, parts=len(chunks), entity=tuple(chunk))
        for part, chunk in enumerate(chunks)
    ]


def split_written(run: str, tick: int, time: float, written: WrittenState, limit: int = PART_BYTES) -> list[bytes]:
    """Return at least one part as bytes, with the entities in order; each part is within the limit."""
    ends = written.ends
    cuts, begin = [0], 0
    for at in range(1, len(ends)):
        if ends[at] - begin > limit - _HEADER_BYTES and at - 1 > cuts[-1]:
            cuts.append(at - 1)
            begin = ends[at - 1]
    cuts.append(len(ends) - 1)
    found = []
    for part, (first, last) in enumerate(pairwise(cuts)):
        empty = _encode(WorldState(run=run, tick=tick, time=time, part=part, parts=len(cuts) - 1))
        entities = written.data[ends[first] : ends[last] - 1]
        found.append(b"".join((empty[:-1], b',"Entity":[', entities, b"]}")) if entities else empty)
    return found


def _chunks(entities: Sequence[Entity], limit: int) -> list[Sequence[Entity]]:
    size = len(_encode(entities)) + _HEADER_BYTES
    if size <= limit or len(entities) < 2:
        return [entities]
    pieces = size // limit + 1
    step = -(-len(entities) // pieces)
    if step == len(entities):
        step = len(entities) // 2
    found: list[Sequence[Entity]] = []
    for first in range(0, len(entities), step):
        found += _chunks(entities[first : first + step], limit)
    return found
