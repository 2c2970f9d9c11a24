"""What drivers see of themselves: hands, cuffs and shoes. The joystick leans with the motion that is commanded.

The chair and the rest of the person are those of the shared scene.
"""

from __future__ import annotations

import math
from typing import Final

import viser

from intellwheels_schemas.messages import Entity, Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.chair_frame import Frame, arm_height, frame_of, stick
from intellwheels_viewer.drawings.furniture import Painted
from intellwheels_viewer.drawings.glb import glb, painted
from intellwheels_viewer.drawings.own_body import PIVOT, grip, rest_of

LEAN: Final = math.radians(14.0)
"""Angle of the joystick at full power."""


def lean(left: float, right: float) -> tuple[float, float, float, float]:
    """Return the rotation w, x, y, z of a joystick whose motors have these outputs.

    It leans forward by the mean of both outputs, and to the left by half of what the right one has more.
    """
    ahead = LEAN * max(-1.0, min(1.0, (left + right) / 2))
    aside = LEAN * max(-1.0, min(1.0, (right - left) / 2))
    angle = math.hypot(ahead, aside)
    if angle < 1e-9:
        return 1.0, 0.0, 0.0, 0.0
    share = math.sin(angle / 2) / angle
    # Forward is about the axis to the left, and to the left is about the axis to the rear.
    return math.cos(angle / 2), -aside * share, ahead * share, 0.0


class Cockpit:
    """The driver's hands and shoes in the scene of one browser. They are made once for each size of chair.

    Args:
        scene: That of the browser.
        name: The parent of the nodes.
    """

    def __init__(self, scene: viser.SceneApi, name: str = "/cockpit") -> None:
        self._scene, self._name = scene, name
        self._chair: viser.FrameHandle | None = None
        self._grip: viser.GlbHandle | None = None
        self._frame: Frame | None = None

    def show(self, robot: Robot | None, entity: Entity | None) -> None:
        """Show what the driver of a chair sees; nothing without a body, or if it is no chair."""
        if robot is None or entity is None or robot.kind != "wheelchair" or not parts_of(robot):
            if self._chair is not None:
                self._chair.visible = False
            return
        if self._chair is None or self._grip is None:
            self._chair = self._scene.add_frame(self._name, show_axes=False)
            self._grip = self._add("grip", grip())
        frame = frame_of(robot)
        if frame != self._frame:
            self._frame = frame
            self._add("rest", rest_of(frame))
        self._chair.visible = True
        self._chair.position = (entity.x, entity.y, 0.0)
        self._chair.wxyz = (math.cos(entity.heading / 2), 0.0, 0.0, math.sin(entity.heading / 2))
        self._grip.position = (*stick(frame), arm_height(frame) + PIVOT)
        self._grip.wxyz = lean(entity.left_output, entity.right_output)

    def _add(self, name: str, solids: Painted) -> viser.GlbHandle:
        made = glb([painted(solids)])
        return self._scene.add_glb(f"{self._name}/{name}", made, cast_shadow=False, receive_shadow=False)
