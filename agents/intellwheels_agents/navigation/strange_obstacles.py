"""Plans around things that are not on the map and stand in the way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from intellwheels_agents.navigation.cost_to_go import Weights
from intellwheels_agents.navigation.exact_angles import Floats
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
        first_row, last_row = (int((value - frame.y) / frame.cell) for value in (low[1], high[1]))
        first_column, last_column = (int((value - frame.x) / frame.cell) for value in (low[0], high[0]))
        copy.refresh(
            (max(0, first_row), min(frame.rows, last_row + 2)), (max(0, first_column), min(frame.columns, last_column + 2))
        )
    yield copy
