"""How far bodies have travelled and turned, summed tick by tick. Pure.

Readers of the published state do not see every tick. The sums here are exact, so they are the same for the same run.
They belong to the service, not to the world: no hash depends on them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from intellwheels_server.world import State
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats


class Travelled(NamedTuple):
    """What a body has travelled.

    Attributes:
        length: Length of the path of its centre of movement, m, rounded to 1e-6.
        turned: Largest angle from the heading that it had at first, rad, in [0, pi], rounded to 1e-6.
    """

    length: float
    turned: float


class TravelledPaths:
    """The paths of all bodies in this run. A body that an operator moves does not travel."""

    def __init__(self) -> None:
        self._names: tuple[str, ...] = ()
        # Rows: the length, the largest angle, the first heading. Columns: the bodies.
        self._sums = np.zeros((3, 0))

    def follow(self, before: State, after: State) -> None:
        """Add a step of the world."""
        if before.names != after.names:
            # No step adds or removes a body, but nothing here depends on that.
            return
        if after.names != self._names:
            self._enter(before)
        old, new, sums = before.numbers, after.numbers, self._sums
        sums[0] += np.hypot(new[rows.X] - old[rows.X], new[rows.Y] - old[rows.Y])
        angle = np.abs(new[rows.HEADING] - sums[2])
        np.maximum(sums[1], np.minimum(angle, math.tau - angle), out=sums[1])

    def all(self) -> dict[str, Travelled]:
        """Return what each body has travelled that was there at a step."""
        lengths, angles, _ = self._sums.round(6).tolist()
        return {name: Travelled(*sums) for name, *sums in zip(self._names, lengths, angles, strict=True)}

    def columns(self, names: tuple[str, ...]) -> Floats:
        """Return float64[2, n]: length and largest angle of each body, not rounded; NaN for one that was at no step."""
        if names == self._names:
            return self._sums[:2]
        found = np.full((2, len(names)), math.nan)
        known = {name: at for at, name in enumerate(self._names)}
        for at, name in enumerate(names):
            if name in known:
                found[:, at] = self._sums[:2, known[name]]
        return found

    def forget(self, agent: str) -> None:
        """Forget a body that is gone."""
        if agent in self._names:
            at = self._names.index(agent)
            self._names = (*self._names[:at], *self._names[at + 1 :])
            self._sums = np.delete(self._sums, at, axis=1)

    def clear(self) -> None:
        """Forget everything, for a new run."""
        self._names, self._sums = (), np.zeros((3, 0))

    def _enter(self, state: State) -> None:
        """Take over the bodies of a state: those that are known keep their sums, the others begin here."""
        known = {name: self._sums[:, at] for at, name in enumerate(self._names)}
        sums = np.zeros((3, len(state.names)))
        sums[2] = state.numbers[rows.HEADING]
        for at, name in enumerate(state.names):
            if name in known:
                sums[:, at] = known[name]
        self._names, self._sums = state.names, sums
