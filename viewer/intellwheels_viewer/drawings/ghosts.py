"""Bodies that are not there: where one would stand if it were let go, and where a real one says that it is.

A ghost is see-through and casts no shadow. Its outline says what would become of it: in its own colour while nobody
has answered, red when the simulator refused.
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
    """A body that is not there.

    Attributes:
        robot: What it looks like.
        x, y, heading: Where, in metres and radians.
        colour: Of the agent.
        refused: Whether it may not stand there.
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


def reported(seen: Snapshot, colours: palette.Colours) -> dict[str, Ghost]:
    """Return the ghost of each real chair that is seen where it truly is, where it said that it is."""
    return {
        name: Ghost(seen.bodies[name].robot, pose.x, pose.y, pose.heading, colours.rgb(name))
        for name, pose in seen.reported.items()
        if name in seen.bodies
    }


class Ghosts:
    """The ghosts in a scene, by a key each: of all browsers, or of one who drags."""

    def __init__(self, scene: viser.SceneApi, name: str = "/ghosts") -> None:
        self._scene, self._name = scene, name
        self._made: dict[str, tuple[Shape, viser.MeshHandle, viser.MeshHandle]] = {}

    def show(self, ghosts: Mapping[str, Ghost]) -> None:
        """Show these and no others; a key whose robot looks as before keeps its nodes."""
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
