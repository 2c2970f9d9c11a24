"""Plans around things that are not on the map and stand in the way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.navigation.cost_to_go import Weights
from intellwheels_agents.navigation.footprint_clearance import Box, Solid, mark, reach_of
from intellwheels_agents.navigation.scan_points import thinned

SPACING: Final = 0.12
"""Distance between the points that are entered, m."""
AT_ONCE: Final = 10
"""Points that are entered in a tick."""


def entered(weights: Weights, boxes: list[Box], points: Floats) -> Iterator[Weights | None]:
    """Enter points (m, in the map) into a copy of the costs, a few at a time; the last item is the copy."""
    copy = weights.copied()
    frame = copy.frame
    yield None
    chosen = thinned(points, SPACING)
    bottom, top = min(box.bottom for box in boxes), max(box.top for box in boxes)
    for start in range(0, chosen.shape[0], AT_ONCE):
        for x, y in chosen[start : start + AT_ONCE].tolist():
            mark(copy.clearance, frame, Solid(((x, y),), bottom, top), boxes)
        yield None
    if chosen.shape[0]:
        reach = reach_of(boxes)
        low, high = chosen.min(axis=0) - reach, chosen.max(axis=0) + reach
        copy.refresh(
            _cells(low[1] - frame.y, high[1] - frame.y, frame.cell, frame.rows),
            _cells(low[0] - frame.x, high[0] - frame.x, frame.cell, frame.columns),
        )
    yield copy


def _cells(low: float, high: float, cell: float, count: int) -> tuple[int, int]:
    return max(0, int(low / cell)), min(count, int(high / cell) + 2)
