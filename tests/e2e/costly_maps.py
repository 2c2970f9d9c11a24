"""Maps that are costly to load: combs, spirals, nested rings, crowds of small things. Each is made from a number."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

Ring = list[tuple[float, float]]

MOST_CORNERS = 10_000
CLOSE = 0.05
"""Share of their distances at which the doorways and pillars of `crowded` stand."""


def comb(corners: int, chance: random.Random) -> Ring:
    """A bar with deep teeth of different heights."""
    top = [(k * 0.1, chance.uniform(3.0, 5.0) if k % 2 else 0.3) for k in range(corners - 2)]
    return [*top, (top[-1][0], 0.0), (0.0, 0.0)][::-1]


def spiral(corners: int, _chance: random.Random) -> Ring:
    """A long arm of constant width."""
    angles = [k * 0.1 for k in range(corners // 2)]
    outer = [((1.5 + 0.05 * t) * math.cos(t), (1.5 + 0.05 * t) * math.sin(t)) for t in angles]
    inner = [((1.4 + 0.05 * t) * math.cos(t), (1.4 + 0.05 * t) * math.sin(t)) for t in angles]
    return outer + inner[::-1]


def star(corners: int, chance: random.Random) -> Ring:
    """A star of random rays."""
    turns = [math.tau * k / corners for k in range(corners)]
    return [(r * math.cos(t), r * math.sin(t)) for t in turns for r in [chance.uniform(100.0, 900.0)]]


def circle(corners: int, _chance: random.Random) -> Ring:
    """A convex ring."""
    return [
        (900.0 * math.cos(math.tau * k / corners), 900.0 * math.sin(math.tau * k / corners)) for k in range(corners)
    ]


def knot(corners: int, chance: random.Random) -> Ring:
    """A ring that crosses itself everywhere."""
    return [(chance.uniform(-900.0, 900.0), chance.uniform(-900.0, 900.0)) for _ in range(corners)]


def nested(corners: int, _chance: random.Random) -> list[Ring]:
    """Rings in rings, each a bent bar that is open at one end."""
    rings = []
    for k in range(corners // 100):
        outer, inner = 10.0 + k, 9.5 + k
        angles = [0.1 + 6.0 * i / 49 for i in range(50)]
        arc = [(outer * math.cos(t), outer * math.sin(t)) for t in angles]
        rings.append(arc + [(inner * math.cos(t), inner * math.sin(t)) for t in reversed(angles)])
    return rings


def boxes(corners: int, _chance: random.Random) -> list[Ring]:
    """A crowd of pillars."""
    across = math.isqrt(corners // 4)
    spots = [(2.0 * (k % across), 2.0 * (k // across)) for k in range(corners // 4)]
    return [[(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)] for x, y in spots]


SHAPES: dict[str, Callable[[int, random.Random], Any]] = {
    shape.__name__: shape for shape in (comb, spiral, star, circle, knot, nested, boxes)
}


def load(shape: str, corners: int, number: int = 0) -> dict[str, Any]:
    """Return a `Load`, as plain data, of a map with about so many corners."""
    made = SHAPES[shape](corners, random.Random(number))
    rings = made if isinstance(made[0], list) else [made]
    walls = [{"Corner": [{"X": round(x, 3), "Y": round(y, 3)} for x, y in ring]} for ring in rings]
    return {"Map": {"Format": "iw.v1", "Name": f"{shape}-{number}", "Wall": walls}}


def crowded(things: int) -> dict[str, Any]:
    """Return a `Load` with so many doorways and pillars that no simulator checks all pairs of them in time.

    They are as near to each other as in a drawing whose units were mistaken, so every wall may belong to every doorway.
    """
    found = load("boxes", 4 * things)
    for wall in found["Map"]["Wall"]:
        wall["Corner"] = [
            {axis: round(CLOSE * value, 4) for axis, value in corner.items()} for corner in wall["Corner"]
        ]
    across = math.isqrt(things)
    found["Map"]["Doorway"] = [
        {
            "Name": f"d{k}",
            "X": round(CLOSE * (2.0 * (k % across) + 1.5), 4),
            "Y": round(CLOSE * (2.0 * (k // across) + 0.5), 4),
            "HeadingDeg": 90.0,
            "Width": CLOSE,
        }
        for k in range(things)
    ]
    return found
