"""Goals: a target on the floor in the agent's colour, and a short arrow beside the agent that points to it.

No line joins the two: an agent publishes where it wants to go and not on which path, and a straight line would lead
through walls.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import viser

from intellwheels_schemas.messages import Entity
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.body_documents import BodyDocument
from intellwheels_viewer.drawings.body_look import Extent
from intellwheels_viewer.drawings.instance_batch import InstanceBatch, quaternions
from intellwheels_viewer.drawings.solids import Array, Solid, band, join, sheet

GAP: Final = 0.12
"""Metres between a body and its arrow."""
LENGTH: Final = 0.9
"""Length of the arrow, in metres. It is not shown where it would reach the target."""
_RINGS: Final = 0.28


def target() -> Solid:
    """Return the mark of a goal: two rings around a point."""
    z = floor_heights.GOAL
    return join([band(0.24, _RINGS, z, sides=36), band(0.13, 0.16, z, sides=28), band(0.0, 0.05, z, sides=16)])


def arrow() -> Solid:
    """Return the mark of a goal's heading: an arrow outside the rings, towards x."""
    return sheet([(0.32, -0.08), (0.46, 0.0), (0.32, 0.08)], floor_heights.GOAL)


def pointer() -> Solid:
    """Return the arrow beside an agent: three chevrons along x from the origin on, each smaller than the one before."""
    marks = []
    for x, half, thick in ((0.0, 0.2, 0.12), (0.32, 0.15, 0.09), (0.6, 0.1, 0.06)):
        for side in (1.0, -1.0):
            tip = x + 0.9 * half
            corners = [(x, side * half), (x + thick, side * half), (tip + thick, 0.0), (tip, 0.0)]
            marks.append(sheet(corners, floor_heights.GOAL))
    return join(marks)


def edge(hull: Extent, course: float) -> float:
    """Return how far it is from the centre of movement to the edge of a footprint, in metres.

    Args:
        hull: The box around the body; a centre outside it counts as being at its edge.
        course: Where to, from the body's heading, in radians.
    """
    cos, sin = math.cos(course), math.sin(course)
    along = max(hull.front, 0.0) if cos > 0.0 else max(-hull.rear, 0.0)
    across = max(hull.left, 0.0) if sin > 0.0 else max(-hull.right, 0.0)
    return min(along / max(abs(cos), 1e-9), across / max(abs(sin), 1e-9))


def pointers(
    entities: Sequence[Entity], documents: Mapping[str, BodyDocument]
) -> tuple[list[Entity], Array, list[float]]:
    """Return the agents that have an arrow, where it begins (N, 3), in metres, and its course in the map."""
    shown, places, courses = [], [], []
    for entity in entities:
        document = documents.get(entity.name)
        if entity.goal is None or document is None:
            continue
        dx, dy = entity.goal.x - entity.x, entity.goal.y - entity.y
        course = math.atan2(dy, dx)
        begin = edge(document.hull, course - entity.heading) + GAP
        if math.hypot(dx, dy) >= begin + LENGTH + _RINGS:
            shown.append(entity)
            places.append((entity.x + begin * math.cos(course), entity.y + begin * math.sin(course), 0.0))
            courses.append(course)
    return shown, np.array(places, np.float32).reshape(-1, 3), courses


class Goals:
    """The goals in a scene."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._targets = InstanceBatch(scene, "/goals/targets", target())
        self._arrows = InstanceBatch(scene, "/goals/headings", arrow())
        self._pointers = InstanceBatch(scene, "/goals/pointers", pointer())

    def show(self, entities: Sequence[Entity], documents: Mapping[str, BodyDocument], colours: palette.Colours) -> None:
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
        shown, places, courses = pointers(entities, documents)
        self._pointers.show(places, quaternions(courses), [colours.rgb(entity.name) for entity in shown])
