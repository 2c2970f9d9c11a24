"""Where a driver looks: ahead and down to the knees, unless the mouse turns the head, which comes back by itself.

Pure; time is passed in.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from intellwheels_schemas.messages import Entity, Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.chair_frame import frame_of

Vector = npt.NDArray[np.float64]

EYES: Final = 1.2
"""Eye height of a person in a chair, in metres."""
EYE_RANGE: Final = (0.8, 1.7)
FIELD: Final = 90.0
"""The vertical field of view, in degrees: with it the own knees and the ceiling are seen."""
FIELD_RANGE: Final = (40.0, 100.0)
DOWN: Final = math.radians(21.0)
"""How far below the horizon a driver looks."""
REACH: Final = 0.1
"""Metres from the eye to the point about which the page turns the view: so near that a turn moves the head only."""
HELD: Final = 1.2
"""Seconds for which a turned head stays after the mouse has rested."""
_BACK: Final = 0.35
"""Seconds in which a head that comes back loses most of its turn (all but 1/e)."""
_FREE: Final = math.radians(0.2)


class Eye(NamedTuple):
    """The eye of a user.

    Attributes:
        ahead: Metres ahead of the centre of movement.
        height: Metres above the floor.
        fov: Vertical field of view, in radians.
    """

    ahead: float = 0.05
    height: float = EYES
    fov: float = math.radians(FIELD)


def eye_of(robot: Robot, height: float = EYES, field: float = FIELD) -> Eye:
    """Return the eye of who sits or stands in a body.

    Args:
        robot: The body. In a chair the eye is over the seat; else over the middle of the footprint.
        height: Metres above the floor.
        field: Vertical field of view, in degrees.
    """
    parts = parts_of(robot)
    if robot.kind == "wheelchair" and parts:
        ahead = frame_of(robot).rear + 0.32
    else:
        ahead = (min(p.x - p.length / 2 for p in parts) + max(p.x + p.length / 2 for p in parts)) / 2 if parts else 0.05
    return Eye(ahead, height, math.radians(field))


def line_of_sight(heading: float, yaw: float, pitch: float) -> Vector:
    """Return the unit vector of a look, of a head that is turned by yaw to the left and by pitch upwards."""
    turn, tilt = heading + yaw, min(max(pitch - DOWN, -1.4), 1.4)
    return np.array([math.cos(tilt) * math.cos(turn), math.cos(tilt) * math.sin(turn), math.sin(tilt)])


class HeadTurn:
    """The turn of one user's head."""

    def __init__(self) -> None:
        self.yaw = self.pitch = 0.0
        self._at = self._moved = -math.inf

    @property
    def is_turned(self) -> bool:
        """Whether the head is not straight."""
        return math.hypot(self.yaw, self.pitch) > _FREE

    def turn_to(self, look: Vector, heading: float, now: float) -> None:
        """Take a look that the mouse has made.

        Args:
            look: Along the line of sight, of any length.
            heading: Of the body, in radians.
            now: In seconds.
        """
        flat = math.hypot(look[0], look[1])
        if flat < 1e-9:
            return
        self.yaw = math.remainder(math.atan2(look[1], look[0]) - heading, math.tau)
        self.pitch = math.atan2(look[2], flat) + DOWN
        self._at = self._moved = now

    def come_back(self, now: float) -> None:
        """Let the head come back, once the mouse has rested for `HELD` seconds."""
        passed, self._moved = now - max(self._moved, self._at + HELD), now
        if now < self._at + HELD or not self.is_turned:
            return
        share = math.exp(-max(passed, 0.0) / _BACK)
        self.yaw, self.pitch = self.yaw * share, self.pitch * share
        if not self.is_turned:
            self.yaw = self.pitch = 0.0

    def straighten(self) -> None:
        """Look ahead at once."""
        self.yaw = self.pitch = 0.0


def position_of(entity: Entity, eye: Eye) -> Vector:
    """Return where the eye is, in metres."""
    cos, sin = math.cos(entity.heading), math.sin(entity.heading)
    return np.array([entity.x + eye.ahead * cos, entity.y + eye.ahead * sin, eye.height])
