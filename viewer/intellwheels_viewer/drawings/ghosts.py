"""Ghosts: a body that is being dragged or placed, and the pose that a real chair reported.

A ghost is transparent and casts no shadow. Its outline has its own colour, or red if the simulator refused the pose.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import viser

from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.body_look import extent
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from intellwheels_viewer.drawings.footprint_outlines import outline
from intellwheels_viewer.drawings.looks import Shape, model_of, shape_of
from intellwheels_viewer.drawings.solids import Solid

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

OPACITY: Final = 0.4


@dataclass(frozen=True)
class Ghost:
    """A ghost.

    Attributes:
        robot: The body.
        x, y, heading: Its pose, in metres and radians.
        colour: The colour of the agent.
        refused: Whether the simulator refused this pose.
    """

    robot: Robot
    x: float
    y: float
    heading: float
    colour: palette.RGB
    refused: bool = False


def spirit(robot: Robot) -> Solid:
    """Return a body's look as one solid."""
    model = model_of(robot, cut=HALF_HEIGHT)
    return model.paint + model.dark + model.light


def reported(snapshot: Snapshot, colours: palette.Colours) -> dict[str, Ghost]:
    """Return a ghost at the pose that each real chair reported, by agent."""
    return {
        name: Ghost(snapshot.bodies[name].robot, pose.x, pose.y, pose.heading, colours.rgb(name))
        for name, pose in snapshot.reported.items()
        if name in snapshot.bodies
    }


class Ghosts:
    """The ghosts in a scene, by key."""

    def __init__(self, scene: viser.SceneApi, name: str = "/ghosts") -> None:
        self._scene, self._name = scene, name
        self._made: dict[str, tuple[Shape, viser.MeshHandle, viser.MeshHandle]] = {}

    def show(self, ghosts: Mapping[str, Ghost]) -> None:
        """Show these ghosts and no others. A key whose body keeps its look keeps its nodes."""
        for key in self._made.keys() - ghosts.keys():
            for node in self._made[key][1:]:
                node.visible = False
        for key, ghost in ghosts.items():
            body, lines = self._nodes(key, ghost)
            body.color = ghost.colour
            lines.color = palette.CONTACT if ghost.refused else ghost.colour
            for node in (body, lines):
                node.position = (ghost.x, ghost.y, 0.0)
                node.wxyz = (math.cos(ghost.heading / 2), 0.0, 0.0, math.sin(ghost.heading / 2))
                node.visible = True

    def _nodes(self, key: str, ghost: Ghost) -> tuple[viser.MeshHandle, viser.MeshHandle]:
        shape = shape_of(ghost.robot)
        if key not in self._made or self._made[key][0] != shape:
            body, lines = spirit(ghost.robot), outline(extent(parts_of(ghost.robot)))
            self._made[key] = (shape, self._add(f"{key}/body", body, OPACITY), self._add(f"{key}/outline", lines, 0.9))
        return self._made[key][1:]

    def _add(self, name: str, shape: Solid, opacity: float) -> viser.MeshHandle:
        return self._scene.add_mesh_simple(
            f"{self._name}/{name}",
            shape.vertices,
            shape.faces,
            opacity=opacity,
            cast_shadow=False,
            receive_shadow=False,
        )
