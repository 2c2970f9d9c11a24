"""What a driver sees of their own hand: it holds the joystick, which leans with the motion that is commanded.

The chair and the rest of the person are those of the shared scene. This hand covers the one that everybody sees.
"""

from __future__ import annotations

import math
from typing import Final

import viser

from intellwheels_schemas.messages import Entity, Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.chair_frame import arm_height, frame_of
from intellwheels_viewer.drawings.furniture import Painted
from intellwheels_viewer.drawings.glb import glb, painted
from intellwheels_viewer.drawings.occupant import SKIN, hand
from intellwheels_viewer.drawings.solids import ball, ellipses, join, taper

LEAN: Final = math.radians(14.0)
"""Angle of the joystick at full power."""
_BASE: Final = 0.03
"""Height of the joystick's pivot above the armrest, in metres."""


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


def grip() -> Painted:
    """Return the joystick with the hand around it, its pivot at the origin."""
    boot = ellipses([(0.0, 0.0, 0.0, 0.034, 0.034), (0.02, 0.0, 0.0, 0.022, 0.022), (0.05, 0.0, 0.0, 0.014, 0.014)], 12)
    z = 0.078
    fist = ellipses(
        [
            (z - 0.05, -0.008, 0.0, 0.034, 0.030),
            (z - 0.03, -0.010, 0.0, 0.054, 0.046),
            (z + 0.005, -0.012, 0.0, 0.060, 0.052),
            (z + 0.035, -0.014, 0.0, 0.050, 0.044),
            (z + 0.05, -0.016, 0.0, 0.022, 0.020),
        ],
        14,
    )
    fingers = [taper((0.045, y, z + 0.018), (0.028, y, z - 0.03), 0.013, 0.012, 8) for y in (-0.03, -0.01, 0.01)]
    thumb = taper((-0.01, 0.045, z + 0.01), (0.045, 0.03, z + 0.022), 0.016, 0.012, 8)
    return {SKIN: join([fist, *fingers, thumb, ball(0.046, 0.03, z + 0.022, 0.012, 6)]), palette.DARK: boot}


class Cockpit:
    """The driver's hand in the scene of one browser.

    Args:
        scene: That of the browser.
        name: The parent of the nodes.
    """

    def __init__(self, scene: viser.SceneApi, name: str = "/cockpit") -> None:
        self._scene, self._name = scene, name
        self._chair: viser.FrameHandle | None = None
        self._grip: viser.GlbHandle | None = None

    def show(self, robot: Robot | None, entity: Entity | None) -> None:
        """Show the hand of the driver of a chair; nothing without a body, or if it is no chair."""
        if robot is None or entity is None or robot.kind != "wheelchair" or not parts_of(robot):
            if self._chair is not None:
                self._chair.visible = False
            return
        if self._chair is None or self._grip is None:
            self._chair = self._scene.add_frame(self._name, show_axes=False)
            self._grip = self._scene.add_glb(
                f"{self._name}/grip", glb([painted(grip())]), cast_shadow=False, receive_shadow=False
            )
        frame = frame_of(robot)
        x, y, _ = hand(frame)
        self._chair.visible = True
        self._chair.position = (entity.x, entity.y, 0.0)
        self._chair.wxyz = (math.cos(entity.heading / 2), 0.0, 0.0, math.sin(entity.heading / 2))
        self._grip.position = (x, y, arm_height(frame) + _BASE)
        self._grip.wxyz = lean(entity.left_output, entity.right_output)
