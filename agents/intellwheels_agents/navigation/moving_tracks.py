"""What moves around a body: groups of sensed points that are not on the map, followed from tick to tick.

A group is points that are connected over less than `GAP`. Its place is the middle of its extent; its velocity comes
from an alpha-beta filter. A group that is new, or hardly moves, counts as standing.

Source: the alpha-beta filter is the steady state of a Kalman filter for constant velocity: Y. Bar-Shalom, X. R. Li,
T. Kirubarajan, Estimation with applications to tracking and navigation, Wiley 2001, section 6.5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.portable_math import hypot

GAP: Final = 0.25
"""Size of the cells that connect points to groups, m."""
SAME: Final = 0.5
"""Farthest that a group may be from where it was expected, m."""
ALPHA: Final = 0.4
"""Share of a difference in place that is taken over in a tick of 50 ms."""
TIME: Final = 0.4
"""Time constant of a velocity, s."""
MOVES: Final = 0.1
"""Speed from which a group counts as moving, m/s."""
OLD: Final = 0.3
"""Time for which a group must be seen before its velocity counts, s."""
MAY_START: Final = 0.25
"""How much faster than it moves now a group may come nearer, m/s."""
STANDS: Final = 1.5
"""Time after which something at one place counts as standing, s."""
PLACE: Final = 0.1
"""Size of a place, m: a group that is seen from another side has another middle, but its faces stay where they are."""
GONE: Final = 0.3
"""Time without a point after which a place is empty, s."""
STAYS: Final = 0.08
"""The same for what stands, m/s."""
FASTEST: Final = 2.0
"""Highest speed that is believed, m/s."""


@dataclass
class Track:
    """One group: its place (m), velocity (m/s), and for how long it has been followed (s)."""

    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0
    age: float = 0.0

    @property
    def speed(self) -> float:
        """Return its speed, m/s; 0 if it counts as standing."""
        speed = hypot(self.vx, self.vy)
        return speed if self.age >= OLD and speed >= MOVES else 0.0


class MovingTracks:
    """The groups around a body.

    Attributes:
        tracks: The groups of the last update.
    """

    def __init__(self, period: float) -> None:
        """Take the time between two updates, s."""
        self._period = period
        self._time = 0.0
        self._places: dict[tuple[int, int], tuple[float, float]] = {}
        self.tracks: list[Track] = []

    def update(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the velocities of points that are not on the map, and how much faster than that each may come nearer.

        Args:
            points: The points in the map, m.

        Returns:
            Rows vx, vy, and a speed for each point, m/s.
        """
        velocities, growth = np.zeros((points.shape[0], 2)), np.full(points.shape[0], MAY_START)
        known, self.tracks = self.tracks, []
        for members in groups(points):
            part = points[members]
            low, high = part.min(axis=0), part.max(axis=0)
            track = self._followed(float(low[0] + high[0]) / 2.0, float(low[1] + high[1]) / 2.0, known)
            self.tracks.append(track)
            if track.speed:
                velocities[members] = track.vx, track.vy
        for index, age in enumerate(self._ages(points)):
            if age >= STANDS:
                # Something has been at that very place for a while. Of what passes, only the front is ever new.
                velocities[index] = 0.0
                growth[index] = STAYS
        return velocities, growth

    def _ages(self, points: Floats) -> list[float]:
        """Return for how long something has been in the cell of each point, s."""
        now = self._time = self._time + self._period
        cells = [(i, j) for i, j in np.floor(points[:, :2] / PLACE).astype(np.int64).tolist()]
        first = {}
        for cell in cells:
            since, last = self._places.get(cell, (now, now))
            first[cell] = since if now - last <= GONE else now
        self._places.update((cell, (since, now)) for cell, since in first.items())
        if len(self._places) > 2000:
            self._places = {cell: place for cell, place in self._places.items() if now - place[1] <= GONE}
        return [now - first[cell] for cell in cells]

    def _followed(self, x: float, y: float, known: list[Track]) -> Track:
        period = self._period
        best, nearest = None, SAME
        for track in known:
            dx, dy = x - track.x - track.vx * period, y - track.y - track.vy * period
            off = hypot(dx, dy)
            if off < nearest:
                best, nearest = track, off
        if best is None:
            return Track(x, y)
        known.remove(best)
        expected_x, expected_y = best.x + best.vx * period, best.y + best.vy * period
        share = min(period / TIME, 1.0)
        vx = best.vx + share * (x - expected_x) / max(period, 1e-6) * ALPHA
        vy = best.vy + share * (y - expected_y) / max(period, 1e-6) * ALPHA
        excess = max(hypot(vx, vy) / FASTEST, 1.0)
        return Track(
            expected_x + ALPHA * (x - expected_x), expected_y + ALPHA * (y - expected_y), vx / excess, vy / excess,
            best.age + period,
        )  # fmt: skip


def groups(points: Floats) -> list[list[int]]:
    """Return the indices of the points of each group, in the order of their first points."""
    cells: dict[tuple[int, int], list[int]] = {}
    for index, (i, j) in enumerate(np.floor(points[:, :2] / GAP).astype(np.int64).tolist()):
        cells.setdefault((i, j), []).append(index)
    found = []
    while cells:
        waiting = [next(iter(cells))]
        members = cells.pop(waiting[0])
        while waiting:
            i, j = waiting.pop()
            for near in ((i + di, j + dj) for di in (-1, 0, 1) for dj in (-1, 0, 1)):
                if near in cells:
                    members += cells.pop(near)
                    waiting.append(near)
        found.append(sorted(members))
    return found
