"""Trails: the paths of the agents over the last 20 s of simulated time, fading into the floor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt
import viser

from intellwheels_viewer import palette
from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.solids import Array
from intellwheels_viewer.snapshot import TRAIL, Sample

STEP: Final = 0.08
"""Minimum distance between two corners, in metres."""
JUMP: Final = 0.6
"""Metres between two samples that mean that the body was moved by hand; its trail starts again."""

_STEP_SQUARED: Final = STEP**2
_JUMP_SQUARED: Final = JUMP**2
_NOWHERE: Final[Array] = np.zeros((0, 3), np.float32)


class Trail:
    """The trail of one agent, extended by the new samples of its history."""

    def __init__(self) -> None:
        self._corners: Array = _NOWHERE
        self._last: Sample | None = None

    def corners(self, history: Sequence[Sample], now: float) -> Array:
        """Return the corners (N, 3) of the trail as x, y and time, oldest first. The last one is the newest sample.

        Args:
            history: Samples, oldest first: those of the last call and newer ones, or those of another run.
            now: The simulated time, in seconds.
        """
        new: list[Sample] = []
        for sample in reversed(history):
            if sample is self._last:
                break
            new.append(sample)
        else:
            self._corners, self._last = _NOWHERE, None
        self._take(new[::-1])
        if self._last is None:
            return _NOWHERE
        first = int(np.searchsorted(self._corners[:, 2], now - TRAIL))
        if first:
            self._corners = self._corners[first:]
        last = self._last
        kept = self._corners[self._corners[:, 2] <= now]
        if last.time > now or last.time < now - TRAIL:
            return kept
        if len(kept) and kept[-1, 2] == np.float32(last.time):
            return kept
        return np.concatenate([kept, np.array([(last.x, last.y, last.time)], np.float32)])

    def _take(self, samples: Sequence[Sample]) -> None:
        added: list[tuple[float, float, float]] = []
        before, kept = self._last, self._corners
        x, y = (float(kept[-1, 0]), float(kept[-1, 1])) if len(kept) else (math.inf, math.inf)
        for sample in samples:
            if before is not None and (sample.x - before.x) ** 2 + (sample.y - before.y) ** 2 > _JUMP_SQUARED:
                kept, added = _NOWHERE, []
                x = y = math.inf
            before = sample
            if (sample.x - x) ** 2 + (sample.y - y) ** 2 >= _STEP_SQUARED:
                x, y = sample.x, sample.y
                added.append((x, y, sample.time))
        self._last = before
        self._corners = np.concatenate([kept, np.array(added, np.float32).reshape(-1, 3)]) if added else kept


def segments(corners: Sequence[Array], now: float, colours: Sequence[palette.RGB]) -> tuple[Array, Array]:
    """Return the segments of the trails (N, 2, 3) in metres and the colours of their ends (N, 2, 3) in sRGB bytes.

    Args:
        corners: The corners of each agent, (N, 3) x, y and time.
        now: The simulated time, in seconds.
        colours: The colour of each agent.
    """
    rows = np.concatenate([_NOWHERE, *corners])
    owner = np.repeat(np.arange(len(corners)), [len(each) for each in corners])
    own = np.array(colours, np.float32).reshape(-1, 3)[owner]
    tints = _faded(own, (now - rows[:, 2]).astype(np.float32))
    rows[:, 2] = floor_heights.TRAIL
    joined = owner[1:] == owner[:-1]
    return _paired(rows, joined), _paired(tints, joined)


def _paired(rows: Array, joined: npt.NDArray[np.bool_]) -> Array:
    """Return each row with the next one where both belong to one trail, (N, 2, 3)."""
    return np.stack([rows[:-1][joined], rows[1:][joined]], axis=1)


def _faded(own: Array, ages: Array) -> Array:
    """Return colours faded by the ages of their corners, (N, 3)."""
    shares = 0.25 + 0.7 * np.clip(ages / TRAIL, 0.0, 1.0)[:, None]
    faded: Array = np.round(own + (np.array(palette.FLOOR, np.float32) - own) * shares)
    return faded


class Trails:
    """The trails in a scene, as one node. A segment takes 36 bytes."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._lines: viser.LineSegmentsHandle | None = None
        self._trails: dict[str, Trail] = {}

    def show(self, histories: Mapping[str, Sequence[Sample]], now: float, colours: palette.Colours) -> None:
        """Show the trails of some agents.

        Args:
            histories: Their samples by agent, oldest first.
            now: The simulated time, in seconds.
            colours: The colours of the agents.
        """
        for name in self._trails.keys() - histories.keys():
            del self._trails[name]
        corners = [self._trails.setdefault(name, Trail()).corners(each, now) for name, each in histories.items()]
        points, tints = segments(corners, now, [colours.rgb(name) for name in histories])
        colors = palette.light_bytes(tints)
        if self._lines is not None:
            self._lines.visible = bool(len(points))
            if len(points):
                self._lines.points, self._lines.colors = points, colors
        elif len(points):
            self._lines = self._scene.add_line_segments("/trails/lines", points, colors, thickness=0.03)
