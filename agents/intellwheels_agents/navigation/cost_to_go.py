"""What it costs to drive to the goal from every pose of the lattice, found from the goal outwards, a piece at a time.

A cost is metres of free driving. A move costs its length, more where the clearance is small, in reverse, and on the
left side of a passage; a turn in place costs its angle. All poses whose costs fall into one band of `BAND` m are
expanded together. No move is cheaper than a band, so every pose is expanded once, with its final cost: Dijkstra's
method with Dial's buckets. A call of `expand` does a bounded amount of work and no clock is read, so the result does
not depend on the machine.

Source: R. B. Dial, Algorithm 360: shortest-path forest with topological ordering, Comm. ACM 12 (1969) 632.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from intellwheels_agents.navigation.array_angles import Floats, wrapped_all
from intellwheels_agents.navigation.footprint_clearance import Frame
from intellwheels_agents.navigation.lattice import ANGLES, COSINES, COUNT, GAPS, LENGTHS, SINES, STEPS

BAND: Final = 0.08
"""Width of a band of costs, m; no move is cheaper."""
TURN_COST: Final = 0.35
"""Cost of a turn in place, m per rad: a quarter turn is worth 0.55 m of way."""
REVERSE: Final = 2.5
"""How much more a move in reverse costs."""
TIGHT: Final = ((0.0, 20.0), (0.05, 4.0), (0.1, 1.8), (0.16, 1.2), (0.25, 1.0))
"""Factors of the cost by clearance: from so many metres on, so much."""
LEFT_SIDE: Final = 0.6
"""What the left side of a passage adds to the factor; its middle adds half, a lane on the right nothing."""
PASSAGE: Final = 2.3
"""How far to each side a passage is measured, m: in a wider one there are no sides to keep to."""
EDGE: Final = 4
"""Cells to the end of the longest move."""
_TURNS: Final = np.maximum(GAPS * TURN_COST, BAND).astype(np.float32)
UNKNOWN_STEP: Final = 1.0
"""How much more than its neighbours a pose counts as to which no way is known, m."""

Costs = npt.NDArray[np.float32]


class Weights:
    """The costs of the moves of one body on one map.

    Attributes:
        frame: The grid.
        clearance: The clearances of the body, m, by heading, row and column, as all arrays here.
        move: Cost of the move ahead from each pose, infinite where it is blocked.
        turn: Cost of the turn to the next heading from each pose.
    """

    def __init__(self, frame: Frame, clearance: Costs) -> None:
        """Take the clearances of the body."""
        self.frame = frame
        self.clearance = clearance
        self._factor = np.full(clearance.shape, np.inf, dtype=np.float32)
        self._side = _left_side(frame, clearance)
        self.move = np.full_like(self._factor, np.inf)
        self.turn = np.full_like(self._factor, np.inf)
        self.refresh((EDGE, frame.rows - EDGE), (EDGE, frame.columns - EDGE))

    def copied(self) -> Weights:
        """Return weights that can be changed without changing these."""
        other = Weights.__new__(Weights)
        other.frame, other._side = self.frame, self._side
        other.clearance, other._factor = self.clearance.copy(), self._factor.copy()
        other.move, other.turn = self.move.copy(), self.turn.copy()
        return other

    def refresh(self, rows: tuple[int, int], columns: tuple[int, int]) -> None:
        """Compute the costs again in a range of rows and columns, after the clearances there have changed."""
        (south, north), (west, east) = rows, columns
        clear, factor = self.clearance[:, south:north, west:east], self._factor[:, south:north, west:east]
        factor[...] = np.inf
        for least, share in TIGHT:
            factor[clear >= least] = share
        # A move into the range begins up to four cells outside.
        south, north = max(EDGE, south - EDGE), min(self.frame.rows - EDGE, north + EDGE)
        west, east = max(EDGE, west - EDGE), min(self.frame.columns - EDGE, east + EDGE)
        around = (slice(None), slice(south - EDGE, north + EDGE), slice(west - EDGE, east + EDGE))
        sided = self._factor[around] + self._side[around]
        for k, (i, j) in enumerate(STEPS):
            worst = np.maximum(_shifted(sided[k], 0, 0), _shifted(sided[k], i, j))
            parts = max(abs(i), abs(j))
            for n in range(1, parts):
                # A point of the move lies between two cells at most: the freer of them counts.
                one = _shifted(sided[k], (i * n) // parts, (j * n) // parts)
                other = _shifted(sided[k], -((-i * n) // parts), -((-j * n) // parts))
                np.maximum(worst, np.minimum(one, other), out=worst)
            self.move[k, south:north, west:east] = worst * np.float32(LENGTHS[k] * self.frame.cell)
        factors = self._factor[:, south:north, west:east]
        both = np.maximum(factors, np.roll(factors, -1, axis=0))
        self.turn[:, south:north, west:east] = both * _TURNS[:, None, None]


def _shifted(layer: Costs, i: int, j: int) -> Costs:
    """Return the cells that are (i, j) from those inside the edge."""
    rows, columns = layer.shape
    return layer[EDGE + j : rows - EDGE + j, EDGE + i : columns - EDGE + i]


def _left_side(frame: Frame, clearance: npt.NDArray[np.float32]) -> Costs:
    """Return what the left side of a passage adds to the factor of each pose."""
    solid = (clearance < 0.0).all(axis=0)
    reach = int(PASSAGE / frame.cell)
    extra = np.zeros(clearance.shape, dtype=np.float32)
    edge = reach + 1
    padded = np.pad(solid, edge, constant_values=True)
    for k in range(COUNT):
        room = []
        for side in (1.0, -1.0):
            free = np.ones(solid.shape, dtype=bool)
            count = np.zeros(solid.shape, dtype=np.float32)
            for n in range(1, reach + 1):
                di, dj = round(-side * SINES[k] * n), round(side * COSINES[k] * n)
                free &= ~padded[edge + dj : edge + dj + frame.rows, edge + di : edge + di + frame.columns]
                count += free
            room.append(count)
        left, right = room
        bounded = (left < reach) & (right < reach)
        share = np.clip(0.5 + (right - left) / np.maximum(left + right, 1.0), 0.0, 1.0)
        extra[k] = np.where(bounded, LEFT_SIDE * share, 0.0).astype(np.float32)
    return extra


def distances(frame: Frame, points: Sequence[tuple[float, float]]) -> Floats:
    """Return the distance of each cell to the nearest of some points, m; infinite without any."""
    x = frame.x + frame.cell * np.arange(frame.columns)[None, :]
    y = frame.y + frame.cell * np.arange(frame.rows)[:, None]
    square = np.full((frame.rows, frame.columns), np.inf)
    for px, py in points:
        np.minimum(square, (x - px) * (x - px) + (y - py) * (y - py), out=square)
    return np.asarray(np.sqrt(square), dtype=np.float64)


class CostToGo:
    """The costs to one goal, as far as they are found.

    Attributes:
        costs: Cost of each pose by heading, row and column; infinite where no way is known.
        done: Whether every pose that has a way has its cost.
    """

    def __init__(self, weights: Weights, ends: npt.NDArray[np.bool_], costs: Floats | None = None) -> None:
        """Start at the poses that are `True` in `ends`, with their costs, m (default 0)."""
        self._weights = weights
        frame = weights.frame
        self.costs: Costs = np.full((COUNT, frame.rows, frame.columns), np.inf, dtype=np.float32)
        self._flat = self.costs.reshape(-1)
        layer = frame.rows * frame.columns
        self._offsets = np.array([j * frame.columns + i for i, j in STEPS])
        self._layer = layer
        self._size = COUNT * layer
        self._move, self._turn = weights.move.reshape(-1), weights.turn.reshape(-1)
        self._closed = np.zeros(self._size, dtype=bool)
        self._bands: dict[int, list[npt.NDArray[np.int64]]] = {}
        self._band = 0
        self.done = False
        index = np.flatnonzero(ends)
        first = np.zeros(index.size) if costs is None else np.broadcast_to(costs, ends.shape).reshape(-1)[index]
        self._flat[index] = first
        self._store(index, first)

    @classmethod
    def to_point(cls, weights: Weights, goal: tuple[float, float], within: float) -> CostToGo:
        """Return the costs to the poses with any heading whose centre is within `within` m of a point."""
        frame = weights.frame
        off = distances(frame, [goal])
        free = weights.clearance >= 0.0
        ends = free & (off <= within)[None]
        if not ends.any():
            # The body does not fit there: the nearest places where it does.
            least = np.where(free, off[None], np.inf).min()
            ends = free & (off <= least + frame.cell)[None]
        return cls(weights, ends, off)

    @property
    def reached(self) -> float:
        """All poses that cost less than this have their cost, m."""
        return float("inf") if self.done else self._band * BAND

    def expand(self, states: int) -> None:
        """Find the costs of about so many more poses."""
        spent = 0
        while spent < states and not self.done:
            if not self._bands:
                self.done = True
                return
            while self._band not in self._bands:
                self._band += 1
            index = np.concatenate(self._bands.pop(self._band))
            spent += self._relax(index) + 100
            self._band += 1

    def _relax(self, index: npt.NDArray[np.int64]) -> int:
        index = index[~self._closed[index]]
        self._closed[index] = True
        # The same pose may have been stored twice: once closed, it counts once.
        index = np.unique(index)
        if not index.size:
            return 0
        costs, layer = self._flat[index], self._layer
        heading = index // layer
        step = self._offsets[heading]
        back = index - step
        self._improve(back, costs + self._move[back])
        ahead = index + step
        self._improve(ahead, costs + np.float32(REVERSE) * self._move[index])
        before = np.where(heading == 0, index + (self._size - layer), index - layer)
        self._improve(before, costs + self._turn[before])
        after = np.where(heading == COUNT - 1, index - (self._size - layer), index + layer)
        self._improve(after, costs + self._turn[index])
        return int(index.size)

    def _improve(self, index: npt.NDArray[np.int64], costs: Costs) -> None:
        better = costs < self._flat[index]
        if better.any():
            index, costs = index[better], costs[better]
            self._flat[index] = costs
            self._store(index, costs)

    def _store(self, index: npt.NDArray[np.int64], costs: npt.NDArray[np.floating]) -> None:
        band = np.maximum((costs / BAND).astype(np.int64), self._band + 1 if self._band else 0)
        order = np.argsort(band, kind="stable")
        index, band = index[order], band[order]
        cuts = np.flatnonzero(band[1:] != band[:-1]) + 1
        starts = [0, *cuts.tolist()]
        for start, stop in zip(starts, [*starts[1:], band.size], strict=True):
            self._bands.setdefault(int(band[start]), []).append(index[start:stop])

    def at(self, x: Floats, y: Floats, heading: Floats) -> Floats:
        """Return the costs of poses between those of the lattice; infinite where no way is known."""
        frame = self._weights.frame
        column, row = (x - frame.x) / frame.cell, (y - frame.y) / frame.cell
        i = np.clip(np.floor(column).astype(np.int64), 0, frame.columns - 2)
        j = np.clip(np.floor(row).astype(np.int64), 0, frame.rows - 2)
        turned = heading - math.tau * np.floor(heading / math.tau)
        k = np.maximum(np.searchsorted(ANGLES, turned, side="right") - 1, 0)
        share_x, share_y = np.clip(column - i, 0.0, 1.0), np.clip(row - j, 0.0, 1.0)
        share_k = np.clip((turned - ANGLES[k]) / GAPS[k], 0.0, 1.0)
        base = j * frame.columns + i
        first, second = k * self._layer + base, ((k + 1) % COUNT) * self._layer + base
        shifts = (0, 1, frame.columns, frame.columns + 1)
        corners = np.stack([self._flat[start + shift] for start in (first, second) for shift in shifts]).astype(
            np.float64
        )
        least = corners.min(axis=0)
        corners = np.minimum(corners, least + UNKNOWN_STEP)
        finite = least < np.inf
        corners[:, ~finite] = 0.0
        low = corners[:4] * (1.0 - share_k) + corners[4:] * share_k
        south = low[0] * (1.0 - share_x) + low[1] * share_x
        north = low[2] * (1.0 - share_x) + low[3] * share_x
        return np.where(finite, south * (1.0 - share_y) + north * share_y, np.inf)

    def at_pose(self, pose: tuple[float, float, float]) -> float:
        """Return the cost of one pose."""
        return float(self.at(*(np.array([value]) for value in pose))[0])

    def way(self, x: float, y: float, heading: float, length: float) -> list[tuple[float, float]]:
        """Return the next points of the way from a pose, the nearest cell first, until it is so long, m."""
        frame = self._weights.frame
        k = int(np.argmin(np.abs(wrapped_all(ANGLES - heading))))
        i, j = round((x - frame.x) / frame.cell), round((y - frame.y) / frame.cell)
        if not (EDGE <= i < frame.columns - EDGE and EDGE <= j < frame.rows - EDGE):
            return []
        index = (k * frame.rows + j) * frame.columns + i
        found = [(x, y)]
        driven = 0.0
        for _ in range(400):
            if driven >= length or not np.isfinite(self._flat[index]):
                break
            following = self._next(index)
            if following is None:
                break
            if following % self._layer != index % self._layer:
                driven += float(LENGTHS[index // self._layer]) * frame.cell
                row, column = divmod(following % self._layer, frame.columns)
                found.append((frame.x + frame.cell * column, frame.y + frame.cell * row))
            index = following
        return found

    def _next(self, index: int) -> int | None:
        """Return the pose after a pose on its cheapest way."""
        k = index // self._layer
        step = int(self._offsets[k])
        before = index - self._layer if k else index + self._size - self._layer
        after = index + self._layer if k < COUNT - 1 else index - self._size + self._layer
        moves = (
            (index + step, float(self._move[index])), (index - step, REVERSE * float(self._move[index - step])),
            (after, float(self._turn[index])), (before, float(self._turn[before])),
        )  # fmt: skip
        best, least = None, float(self._flat[index])
        for target, cost in moves:
            # A pose that is not finished yet has no cost: it cannot be on the way.
            total = float(self._flat[target]) + cost
            if total < least + 1e-3 and float(self._flat[target]) < float(self._flat[index]):
                best, least = target, total
        return best
