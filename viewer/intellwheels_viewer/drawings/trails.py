"""Where the agents have been: lines of the last 20 s of simulated time, fading into the floor."""

from __future__ import annotations

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

_STEP_SQUARED: Final = STEP**2
_JUMP_SQUARED: Final = JUMP**2


def trail(history: Sequence[Sample], now: float) -> list[tuple[float, float, float]]:
    """Return the corners (x, y, age in seconds) of a trail, oldest first; its end is the newest sample."""
    corners: list[tuple[float, float, float]] = []
    before: Sample | None = None
    newest = history[-1] if history else None
    x = y = 0.0
    for sample in history:
        age = now - sample.time
        if not 0.0 <= age <= LENGTH:
            continue
        if before is not None and (sample.x - before.x) ** 2 + (sample.y - before.y) ** 2 > _JUMP_SQUARED:
            corners.clear()
        before = sample
        if corners and sample is not newest and (sample.x - x) ** 2 + (sample.y - y) ** 2 < _STEP_SQUARED:
            continue
        x, y = sample.x, sample.y
        corners.append((x, y, age))
    return corners


def segments(histories: Mapping[str, Sequence[Sample]], now: float, colours: palette.Colours) -> tuple[Array, Array]:
    """Return the trails' stretches (N, 2, 3) in metres and the colours of their ends (N, 2, 3) in sRGB bytes."""
    points, tints = [np.zeros((0, 2, 3), np.float32)], [np.zeros((0, 2, 3), np.float32)]
    for name, history in histories.items():
        corners = np.array(trail(history, now), np.float32).reshape(-1, 3)
        if len(corners) > 1:
            tints.append(_paired(_faded(colours.rgb(name), corners[:, 2])))
            corners[:, 2] = layers.TRAIL
            points.append(_paired(corners))
    return np.concatenate(points), np.concatenate(tints)


def _paired(rows: Array) -> Array:
    """Return each row with the next, (N - 1, 2, 3)."""
    return np.stack([rows[:-1], rows[1:]], axis=1)


def _faded(rgb: palette.RGB, ages: Array) -> Array:
    """Return a colour at so many ages, (N, 3)."""
    shares = 0.25 + 0.7 * np.minimum(ages / LENGTH, 1.0)[:, None]
    own = np.array(rgb, np.float32)
    faded: Array = np.round(own + (np.array(palette.FLOOR, np.float32) - own) * shares)
    return faded


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
