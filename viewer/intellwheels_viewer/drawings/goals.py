"""Goals: a target on the floor in the agent's colour, and a dashed line from the agent to it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import viser

from intellwheels_schemas.messages import Entity
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.instance_batch import InstanceBatch, quaternions
from intellwheels_viewer.drawings.solids import Array, Solid, band, join, sheet

_DASH: Final = 0.25
_LONGEST: Final = 200
"""Maximum number of dashes in a line; beyond 50 m the dashes get longer."""


def target() -> Solid:
    """Return the mark of a goal: two rings around a point."""
    z = floor_heights.GOAL
    return join([band(0.24, 0.28, z, sides=36), band(0.13, 0.16, z, sides=28), band(0.0, 0.05, z, sides=16)])


def arrow() -> Solid:
    """Return the mark of a goal's heading: an arrow outside the rings, towards x."""
    return sheet([(0.32, -0.08), (0.46, 0.0), (0.32, 0.08)], floor_heights.GOAL)


def dashes(entities: Sequence[Entity], colours: palette.Colours) -> tuple[Array, Array]:
    """Return the dashes (N, 2, 3) from the agents to their goals, in metres, and their colours (N, 2, 3)."""
    points: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = []
    tints: list[tuple[palette.RGB, palette.RGB]] = []
    for entity in entities:
        if entity.goal is None:
            continue
        dx, dy = entity.goal.x - entity.x, entity.goal.y - entity.y
        distance = math.hypot(dx, dy)
        count = min(int(distance / _DASH), _LONGEST)
        for dash in range(count):
            a, b = dash / count, (dash + 0.45) / count
            points.append(
                (
                    (entity.x + a * dx, entity.y + a * dy, floor_heights.GOAL),
                    (entity.x + b * dx, entity.y + b * dy, floor_heights.GOAL),
                )
            )
            tints.append((colours.rgb(entity.name), colours.rgb(entity.name)))
    return np.array(points, np.float32).reshape(-1, 2, 3), np.array(tints, np.float32).reshape(-1, 2, 3)


class Goals:
    """The goals in a scene."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._targets = InstanceBatch(scene, "/goals/targets", target())
        self._arrows = InstanceBatch(scene, "/goals/headings", arrow())
        self._lines: viser.LineSegmentsHandle | None = None

    def show(self, entities: Sequence[Entity], colours: palette.Colours) -> None:
        """Show the goals of the agents that have one."""
        aims = [(entity.name, entity.goal) for entity in entities if entity.goal is not None]
        headed = [(name, goal, goal.heading) for name, goal in aims if goal.heading is not None]
        self._targets.show(
            [(goal.x, goal.y, 0.0) for _, goal in aims],
            quaternions([0.0 for _ in aims]),
            [colours.rgb(name) for name, _ in aims],
        )
        self._arrows.show(
            [(goal.x, goal.y, 0.0) for _, goal, _ in headed],
            quaternions([heading for _, _, heading in headed]),
            [colours.rgb(name) for name, _, _ in headed],
        )
        points, tints = dashes(entities, colours)
        colors = palette.light_bytes(tints)
        if self._lines is not None:
            self._lines.visible = bool(len(points))
            if len(points):
                self._lines.points, self._lines.colors = points, colors
        elif len(points):
            self._lines = self._scene.add_line_segments("/goals/lines", points, colors, thickness=0.025)
