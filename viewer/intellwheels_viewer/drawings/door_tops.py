"""The upper part of door leaves, which the shared scene cuts at half height, for browsers with full walls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import viser

from intellwheels_schemas.agent_colours import FIXTURES
from intellwheels_schemas.messages import Body, Entity, Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from intellwheels_viewer.drawings.furniture import Painted
from intellwheels_viewer.drawings.glb import painted
from intellwheels_viewer.drawings.instance_batch import InstanceBatch, quaternions
from intellwheels_viewer.drawings.looks import Shape, shape_of
from intellwheels_viewer.drawings.solids import Solid, box, join
from intellwheels_viewer.palette import RGB

PANE: Final[RGB] = (176, 208, 226)
_STILE: Final = 0.14
"""Width of the frame around the pane, in metres."""
_RAIL: Final = 0.03
"""How far the rail reaches above and below the cut, in metres: over the edge that a cut leaf has."""
_PROUD: Final = 0.003


def top(robot: Robot) -> Painted:
    """Return what a leaf has above the cut: a board with a pane, and a rail over the edge of the part below."""
    boards, panes = [], []
    for part in parts_of(robot):
        if part.top <= HALF_HEIGHT:
            continue
        x0, x1 = part.x - part.length / 2, part.x + part.length / 2
        y0, y1 = part.y - part.width / 2, part.y + part.width / 2
        boards.append(box(x0, x1, y0, y1, max(part.bottom, HALF_HEIGHT), part.top))
        if part.bottom < HALF_HEIGHT:
            low, high = max(part.bottom, HALF_HEIGHT - _RAIL), min(part.top, HALF_HEIGHT + _RAIL)
            boards.append(box(x0 - _PROUD, x1 + _PROUD, y0 - _PROUD, y1 + _PROUD, low, high))
        if x1 - x0 > 3 * _STILE and part.top > HALF_HEIGHT + 0.5:
            low, high = HALF_HEIGHT + 0.12, part.top - 0.18
            panes.append(box(x0 + _STILE, x1 - _STILE, y0 - 0.004, y1 + 0.004, low, high))
    return {FIXTURES["door"]: join(boards), PANE: join(panes)}


class DoorTops:
    """The upper parts of all leaves in the scene of one browser.

    Args:
        scene: That of the browser.
        name: The parent of the nodes.
    """

    def __init__(self, scene: viser.SceneApi, name: str = "/door-tops") -> None:
        self._scene, self._name = scene, name
        self._batches: dict[Shape, InstanceBatch] = {}

    def show(self, bodies: Mapping[str, Body], entities: Sequence[Entity]) -> None:
        """Show the upper parts of these leaves and no others."""
        groups: dict[Shape, list[Entity]] = {}
        for entity in entities:
            body = bodies.get(entity.name)
            if body is not None and body.robot.kind == "door" and parts_of(body.robot):
                shape = shape_of(body.robot)
                groups.setdefault(shape, []).append(entity)
                if shape not in self._batches:
                    made = painted({rgb: each for rgb, each in top(body.robot).items() if len(each.faces)})
                    surface = made if len(made.solid.faces) else Solid()
                    self._batches[shape] = InstanceBatch(self._scene, f"{self._name}/{len(self._batches)}", surface)
        for shape, batch in self._batches.items():
            group = groups.get(shape, [])
            places = np.array([(each.x, each.y, 0.0) for each in group], np.float32).reshape(-1, 3)
            turns = quaternions([each.heading for each in group])
            batch.show(places, turns, np.full((len(group), 3), 255), names=tuple(each.name for each in group))
