"""A small chart for each proximity sensor: its range over the last seconds, on the same scale for all. Pure.

Eight lines in one chart cannot be told apart; eight charts of one line each, one above the other, can.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from intellwheels_viewer.snapshot import HISTORY, Sample

WIDTH: Final = 84
HEIGHT: Final = 18
"""Size of a chart in px."""
STEP: Final = 0.5
"""Simulated seconds between two points of a line: 1.4 px."""


def sparkline(samples: Sequence[Sample], index: int, top: float) -> str:
    """Return the chart of one sensor as SVG; empty with fewer than two samples.

    Args:
        samples: What is known of the last `HISTORY` seconds, oldest first.
        index: The index of the sensor in a sample's ranges.
        top: The range at the upper edge, in metres. While the sensor sees nothing, there is no line.
    """
    pieces: list[list[str]] = [[]]
    for sample in _thinned(samples):
        value = sample.ranges[index] if index < len(sample.ranges) else None
        if value is None:
            pieces.append([])
            continue
        x = WIDTH * (1.0 + (sample.time - samples[-1].time) / HISTORY)
        y = HEIGHT - 1.0 - (HEIGHT - 2.0) * min(max(value / top, 0.0), 1.0)
        pieces[-1].append(f"{x:.0f} {y:.0f}")
    if len(samples) < 2:
        return ""
    lines = "".join(f"M{'L'.join(piece)}" for piece in pieces if len(piece) > 1)
    return (
        f'<svg class="iw-spark" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" aria-hidden="true">'
        f'<path d="M0 {HEIGHT - 0.5}H{WIDTH}" stroke="currentColor" stroke-opacity=".3"/>'
        f'<path d="{lines}" fill="none" stroke="currentColor" stroke-width="1.5"/></svg>'
    )


def _thinned(samples: Sequence[Sample]) -> list[Sample]:
    """Return the first sample of each step and the newest one."""
    kept: list[Sample] = []
    for sample in samples:
        if not kept or int(sample.time / STEP) != int(kept[-1].time / STEP):
            kept.append(sample)
    if kept and kept[-1] is not samples[-1]:
        kept.append(samples[-1])
    return kept
