"""The footprint of a robot on the plan: the rectangle around its parts, at its pose."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

from intellwheels_schemas.messages import Robot

Point: TypeAlias = tuple[float, float]


class Footprint(NamedTuple):
    """A rectangle in the body's frame, in metres: x forward, y left, the centre of movement at (0, 0)."""

    rear: float
    right: float
    front: float
    left: float


def footprint(robot: Robot) -> Footprint:
    """Return the rectangle around all parts of a robot, whatever their heights."""
    if robot.part:
        return Footprint(
            min(part.x - part.length / 2 for part in robot.part),
            min(part.y - part.width / 2 for part in robot.part),
            max(part.x + part.length / 2 for part in robot.part),
            max(part.y + part.width / 2 for part in robot.part),
        )
    # A body has parts, or a length and a width. Only a mind has neither, and it has no footprint.
    length, width = robot.length or 0.5, robot.width or 0.5
    rear = (0.5 if robot.center is None else robot.center) * length
    return Footprint(-rear, -width / 2, length - rear, width / 2)


def placed(points: tuple[Point, ...], x: float, y: float, heading: float) -> list[Point]:
    """Return points of the body's frame in the world frame."""
    cos, sin = math.cos(heading), math.sin(heading)
    return [(x + px * cos - py * sin, y + px * sin + py * cos) for px, py in points]


def outline(shape: Footprint, x: float, y: float, heading: float) -> list[Point]:
    """Return the four corners of a footprint in the world frame, anticlockwise from the rear right."""
    corners = (
        (shape.rear, shape.right), (shape.front, shape.right), (shape.front, shape.left), (shape.rear, shape.left),
    )  # fmt: skip
    return placed(corners, x, y, heading)
