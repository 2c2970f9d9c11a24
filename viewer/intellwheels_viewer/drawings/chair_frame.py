"""The main dimensions of a wheelchair, from its parts, its track and its wheels. Pure."""

from __future__ import annotations

from dataclasses import dataclass

from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.body_look import Extent, extent


@dataclass(frozen=True)
class Frame:
    """The main dimensions of a chair, in metres in the body frame.

    Attributes:
        hull: The box around its parts.
        rear, front: Of the seat.
        wide: The seat's width.
        seat: Height of the cushion's upper face.
        wheel: Radius of the drive wheels.
        side: y of the middle of the left drive wheel.
    """

    hull: Extent
    rear: float
    front: float
    wide: float
    seat: float
    wheel: float
    side: float

    @property
    def tyre(self) -> float:
        """The thickness of a drive wheel."""
        return 0.3 * self.wheel if self.wheel < 0.2 else 0.05

    @property
    def back(self) -> float:
        """The height of the back's upper edge."""
        return self.seat + 0.66 * (self.hull.top - self.seat)


def frame_of(robot: Robot) -> Frame:
    """Return the dimensions of a chair. Its seat is its highest part that does not touch the floor."""
    parts = parts_of(robot)
    hull = extent(parts)
    raised = [part for part in parts if part.bottom > 0.0]
    wheel = min(robot.wheel_diameter, hull.top) / 2
    side = min(robot.track / 2, hull.left - 0.02)
    if not raised:
        rear, front = hull.rear, hull.rear + 0.68 * hull.length
        return Frame(hull, rear, front, 0.92 * hull.width, 0.4 * hull.top, wheel, side)
    seat = max(raised, key=lambda part: part.top)
    rear, front = seat.x - seat.length / 2, seat.x + seat.length / 2
    return Frame(hull, rear, front, seat.width, max(seat.bottom, 0.3 * hull.top), wheel, side)


def arm_height(frame: Frame) -> float:
    """Return the height of the armrests."""
    return frame.seat + 0.28 * (frame.hull.top - frame.seat)


def arm_ends(frame: Frame) -> tuple[float, float]:
    """Return x of the rear and of the front end of the armrests."""
    return frame.rear + 0.17, frame.rear + 0.17 + 0.70 * (frame.front - frame.rear)


def stick(frame: Frame) -> tuple[float, float]:
    """Return x and y of the joystick, at the inner edge of the front end of the right armrest."""
    return arm_ends(frame)[1] + 0.02, -(frame.wide / 2 - 0.08)
