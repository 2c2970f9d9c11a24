"""The state of the world, cut into messages of at most 48 kB. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import msgspec

from intellwheels_schemas.messages import Entity, WorldState

PART_BYTES: Final = 48_000
"""One message stays under 60 kB: above it a healthy reader's wait grows a hundredfold."""

_encode = msgspec.json.Encoder().encode


def cut(run: str, tick: int, time: float, entities: Sequence[Entity], limit: int = PART_BYTES) -> list[WorldState]:
    """Return the parts, at least one, with the entities in order, each within the limit as JSON."""
    chunks = _chunks(entities, limit)
    return [
        WorldState(run=run, tick=tick, time=time, part=part, parts=len(chunks), entity=tuple(chunk))
        for part, chunk in enumerate(chunks)
    ]


def _chunks(entities: Sequence[Entity], limit: int) -> list[Sequence[Entity]]:
    # The message around the entities takes less than this.
    size = len(_encode(entities)) + 200
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
