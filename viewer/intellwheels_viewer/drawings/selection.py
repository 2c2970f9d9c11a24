"""The ring around the selected body: yellow with dark edges, so that it is visible on every floor."""

from __future__ import annotations

import math
from typing import Final

import viser

from intellwheels_schemas.messages import Entity, Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.body_look import extent
from intellwheels_viewer.drawings.solids import Solid, band

_WIDTH: Final = 0.075
_EDGE: Final[palette.RGB] = (92, 84, 20)


def ring_of(robot: Robot) -> tuple[float, float, float]:
    """Return the centre of a footprint in the body frame and the inner radius of a ring around it, in metres."""
    hull = extent(parts_of(robot))
    x, y = hull.middle
    return x, y, math.hypot(hull.length, hull.width) / 2 + 0.10


def rings(radius: float) -> tuple[Solid, Solid]:
    """Return the yellow ring and the dark one under it."""
    outer = radius + _WIDTH
    return band(radius, outer, floor_heights.RING + 0.002, sides=96), band(
        radius - 0.014, outer + 0.014, floor_heights.RING, sides=96
    )


class Selection:
    """The ring in a scene, shared or of one browser."""

    def __init__(self, scene: viser.SceneApi, name: str = "/selection") -> None:
        self._scene, self._name = scene, name
        self._radius = 0.0
        self._nodes: list[viser.MeshHandle] = []

    def show(self, robot: Robot | None, entity: Entity | None) -> None:
        """Show the ring around a body; hide it without one."""
        if robot is None or entity is None:
            for node in self._nodes:
                node.visible = False
            return
        x, y, radius = ring_of(robot)
        if radius != self._radius:
            self._make(radius)
        cos, sin = math.cos(entity.heading), math.sin(entity.heading)
        for node in self._nodes:
            node.position = (entity.x + x * cos - y * sin, entity.y + x * sin + y * cos, 0.0)
            node.visible = True

    def _make(self, radius: float) -> None:
        yellow, dark = rings(radius)
        self._radius = radius
        self._nodes = [
            self._scene.add_mesh_simple(
                f"{self._name}/{name}",
                shape.vertices,
                shape.faces,
                color=colour,
                cast_shadow=False,
                receive_shadow=False,
            )
            for name, shape, colour in (("ring", yellow, palette.SELECTED), ("edge", dark, _EDGE))
        ]
