"""Where the agents have been: lines of the last 20 s of simulated time, fading into the floor."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import viser

from intellwheels_viewer import palette
from intellwheels_viewer.drawings import layers
from intellwheels_viewer.drawings.solids import Array
from intellwheels_viewer.seen import Sample

LENGTH: Final = 20.0
"""Seconds of simulated time that a trail goes back."""
STEP: Final = 0.08
"""Metres between its corners at least."""
JUMP: Final = 0.6
"""Metres between two samples that no body goes: it was put there, and the trail begins anew."""


def trail(history: Sequence[Sample], now: float) -> list[tuple[float, float, float]]:
    """Return the corners (x, y, age in seconds) of a trail, oldest first; its end is the newest sample."""
    corners: list[tuple[float, float, float]] = []
    before: Sample | None = None
    for sample in history:
        age = now - sample.time
        if not 0.0 <= age <= LENGTH:
            continue
        if before is not None and math.hypot(sample.x - before.x, sample.y - before.y) > JUMP:
            corners.clear()
        before = sample
        last = sample is history[-1]
        if corners and not last and math.hypot(sample.x - corners[-1][0], sample.y - corners[-1][1]) < STEP:
            continue
        corners.append((sample.x, sample.y, age))
    return corners


def segments(histories: Mapping[str, Sequence[Sample]], now: float, colours: palette.Colours) -> tuple[Array, Array]:
    """Return the trails' stretches (N, 2, 3) in metres and the colours of their ends (N, 2, 3) in sRGB bytes."""
    points: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = []
    tints: list[tuple[palette.RGB, palette.RGB]] = []
    for name, history in histories.items():
        rgb = colours.rgb(name)
        corners = trail(history, now)
        for (ax, ay, age_a), (bx, by, age_b) in itertools.pairwise(corners):
            points.append(((ax, ay, layers.TRAIL), (bx, by, layers.TRAIL)))
            tints.append((_faded(rgb, age_a), _faded(rgb, age_b)))
    return np.array(points, np.float32).reshape(-1, 2, 3), np.array(tints, np.float32).reshape(-1, 2, 3)


def _faded(rgb: palette.RGB, age: float) -> palette.RGB:
    share = 0.25 + 0.7 * min(age / LENGTH, 1.0)
    red, green, blue = (round(c + (f - c) * share) for c, f in zip(rgb, palette.FLOOR, strict=True))
    return red, green, blue


class Trails:
    """The trails in a scene: one node. Four times a second is enough; a stretch is 36 bytes."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._lines: viser.LineSegmentsHandle | None = None

    def show(self, histories: Mapping[str, Sequence[Sample]], now: float, colours: palette.Colours) -> None:
        """Show the trails of some agents.

        Args:
            histories: Their samples, oldest first.
            now: The simulated time, in seconds.
            colours: Whose colour is which.
        """
        points, tints = segments(histories, now, colours)
        colors = palette.light_bytes(tints)
        if self._lines is not None:
            self._lines.visible = bool(len(points))
            if len(points):
                self._lines.points, self._lines.colors = points, colors
        elif len(points):
            self._lines = self._scene.add_line_segments("/trails/lines", points, colors, thickness=0.03)
