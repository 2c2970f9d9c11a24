"""Runs scenes in this process and prints their hashes: `python -m tests.agents.scene_hashes crossing:110 figure6:60`.

The first line is a checksum of the C library's functions over a sample. It differs where the library does.
"""

from __future__ import annotations

import hashlib
import math
import random
import sys

from intellwheels_maps import scene
from intellwheels_server.world import digest
from tests.agents.arena import Arena


def library_checksum() -> str:
    """Return a checksum of sines, exponentials and others of the C library."""
    draw = random.Random(1)
    functions = (math.sin, math.cos, math.tan, math.exp)
    values = [function(draw.uniform(-7.0, 7.0)) for function in functions for _ in range(20_000)]
    values += [math.atan2(draw.uniform(-1.0, 1.0), draw.uniform(-1.0, 1.0)) for _ in range(20_000)]
    return hashlib.blake2b(repr(values).encode(), digest_size=8).hexdigest()


def scene_hashes(name: str, ticks: int) -> str:
    """Return a checksum of the hashes of all ticks of a scene."""
    arena, hashes = Arena.of(scene(name)), []
    for _ in range(ticks):
        arena.step()
        hashes.append(digest(arena.state))
    return hashlib.blake2b(" ".join(hashes).encode(), digest_size=8).hexdigest()


if __name__ == "__main__":
    print(library_checksum(), flush=True)
    for word in sys.argv[1:]:
        name, _, ticks = word.partition(":")
        print(name, scene_hashes(name, int(ticks)), flush=True)
