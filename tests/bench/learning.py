"""What a step of a learning environment costs, on one core."""

from __future__ import annotations

import numpy as np

from intellwheels_gym import ChairEnv, ChairsEnv, chair_vector
from tests.bench.rows import Row
from tests.bench.tick import best

STILL = np.zeros(2, dtype=np.float32)
"""Nobody moves, so that no episode ends."""
WORLDS = 8


def bench(*, steps: int = 20, rounds: int = 40) -> list[Row]:
    """Return the rows: the quickest of many short rounds of so many steps."""
    chair = ChairEnv("door", ends=[])
    chair.reset(seed=1)
    worlds = chair_vector("door", WORLDS, ends=[])
    worlds.reset(seed=1)
    together = np.zeros((WORLDS, 2), dtype=np.float32)
    chairs = ChairsEnv("figure6", ends=[])
    chairs.reset(seed=1)
    everybody = dict.fromkeys(chairs.agents, STILL)
    few = max(1, steps // WORLDS)
    one, many, three = "door, one chair and a door", f"door, {WORLDS} worlds", "figure6, three chairs of five bodies"
    return [
        Row("learning", one, "step", best(lambda: chair.step(STILL), steps, rounds) * 1e6, "µs"),
        Row("learning", one, "reset", best(chair.reset, 1, rounds) * 1e6, "µs"),
        Row("learning", many, "step", best(lambda: worlds.step(together), few, rounds) * 1e6 / WORLDS, "µs/world"),
        Row("learning", three, "step", best(lambda: chairs.step(everybody), few, rounds) * 1e6, "µs"),
    ]
