"""Chooses the look of a body by its kind. The look of a kind is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final, TypeAlias

from intellwheels_schemas.messages import Part, Robot
from intellwheels_schemas.rules import has_motors, parts_of
from intellwheels_viewer.drawings.body_look import BodyLook
from intellwheels_viewer.drawings.car_look import car
from intellwheels_viewer.drawings.chair_look import chair
from intellwheels_viewer.drawings.door_look import door
from intellwheels_viewer.drawings.person_look import person
from intellwheels_viewer.drawings.plain_look import plain
from intellwheels_viewer.drawings.table_look import table
from intellwheels_viewer.drivers import Reality, reality_of

Shape: TypeAlias = tuple[str, tuple[Part, ...], float, float, bool, bool, Reality, bool, bool]
"""The properties that decide a look: kind, parts, track, wheel diameter, has motors, is anchored, how real it is, is
one of a crowd, is occupied."""

_KINDS: Final[Mapping[str, Callable[[Robot, bool, float | None, bool], BodyLook]]] = {
    "wheelchair": lambda robot, crowd, _, occupied: chair(robot, crowd=crowd, occupied=occupied),
    "door": lambda robot, _, cut, __: door(robot, cut=cut),
    "table": lambda robot, *_: table(robot),
    "person": lambda robot, crowd, *_: person(robot, crowd=crowd),
    "car": lambda robot, *_: car(robot),
}


def shape_of(robot: Robot, *, crowd: bool = False, occupied: bool = False) -> Shape:
    """Return a key that is equal for bodies that differ only in their colour."""
    wheels = (robot.track, robot.wheel_diameter) if robot.kind == "wheelchair" else (0.0, 0.0)
    reality = reality_of(robot)
    return (robot.kind, parts_of(robot), *wheels, has_motors(robot), robot.anchored, reality, crowd, occupied)


def model_of(robot: Robot, *, crowd: bool = False, cut: float | None = None, occupied: bool = False) -> BodyLook:
    """Return the look of a body.

    Args:
        robot: The document of the body.
        crowd: Whether it is one of many and should have few triangles.
        cut: The height above which doors are not drawn.
        occupied: Whether somebody sits in it, if it is a chair.
    """
    look = _KINDS.get(robot.kind)
    return plain(robot) if look is None or not parts_of(robot) else look(robot, crowd, cut, occupied)
