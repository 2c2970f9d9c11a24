"""The legs of walking people. They swing with the path that the body has gone, so they stand still when it does."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
import viser

from intellwheels_schemas.messages import Entity
from intellwheels_viewer.drawings.body_look import Leg
from intellwheels_viewer.drawings.instance_batch import InstanceBatch
from intellwheels_viewer.drawings.solids import Array

STRIDE: Final = 1.3
"""Metres of two steps of an adult at a comfortable pace (Perry and Burnfield, Gait Analysis, 2010, rounded)."""
SWING: Final = math.radians(20.0)
"""Largest angle of a leg from the vertical, at `BRISK` or faster."""
BRISK: Final = 1.2
"""Speed at which the steps are full, in metres per second."""


def swing(gone: float, speed: float) -> float:
    """Return the angle of the left leg, forward positive, in radians; the right one has the opposite.

    Args:
        gone: Path since the start, in metres.
        speed: In metres per second.
    """
    return SWING * min(1.0, abs(speed) / BRISK) * math.sin(math.tau * gone / STRIDE)


def poses(leg: Leg, walkers: Sequence[Entity], gone: Sequence[float]) -> tuple[Array, Array]:
    """Return the places (2 N, 3) of the hips and the turns (2 N, 4) of the legs, the left ones first."""
    if not walkers:
        return np.zeros((0, 3), np.float32), np.zeros((0, 4), np.float32)
    at = np.array([(each.x, each.y, each.heading) for each in walkers], np.float64)
    angle = np.array([swing(path, each.speed) for path, each in zip(gone, walkers, strict=True)])
    cos, sin = np.cos(at[:, 2]), np.sin(at[:, 2])
    places, turns = [], []
    for (hx, hy, hz), sign in zip(leg.hips, (1.0, -1.0), strict=True):
        places.append(np.column_stack([at[:, 0] + cos * hx - sin * hy, at[:, 1] + sin * hx + cos * hy, 0.0 * cos + hz]))
        # About the vertical by the heading, then about the axis to the left by minus the angle.
        zc, zs = np.cos(at[:, 2] / 2), np.sin(at[:, 2] / 2)
        yc, ys = np.cos(sign * angle / 2), -np.sin(sign * angle / 2)
        turns.append(np.column_stack([zc * yc, -zs * ys, zc * ys, zs * yc]))
    return np.concatenate(places).astype(np.float32), np.concatenate(turns).astype(np.float32)


class WalkingLegs:
    """The legs of all people of one look.

    Args:
        scene: The shared scene, or that of one browser.
        name: The node.
        leg: One leg.
        made: Called when the node is made.
    """

    def __init__(self, scene: viser.SceneApi, name: str, leg: Leg, made: Callable[[InstanceBatch], None]) -> None:
        self._leg = leg
        self._batch = InstanceBatch(scene, name, leg.solid, shadow=True, made=made)
        self._gone: dict[str, tuple[float, float, float]] = {}

    def show(self, walkers: Sequence[Entity]) -> None:
        """Show the legs of these people."""
        paths = [self._path(each) for each in walkers]
        self._gone = {each.name: (path, each.x, each.y) for path, each in zip(paths, walkers, strict=True)}
        places, turns = poses(self._leg, walkers, paths)
        names = tuple(each.name for each in walkers)
        self._batch.show(places, turns, np.tile(np.array(self._leg.rgb), (len(places), 1)), names=names + names)

    def _path(self, each: Entity) -> float:
        """Return the path that somebody has gone; in a playback, which has none, what was seen of it."""
        if each.travelled is not None:
            return each.travelled
        path, x, y = self._gone.get(each.name, (0.0, each.x, each.y))
        return path + math.hypot(each.x - x, each.y - y)
