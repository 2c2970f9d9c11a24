"""Keeps the true poses of bodies and the true dimensions of their wheels off the network, for a laboratory.

With `--hide-truth` a world represents the building in which real chairs drive. It publishes only what the electronics
of a chair would measure. Even a subscriber to every key learns no pose, no place of a contact, and no difference
between a wheel and its data sheet. All of these can be computed from the input log.
"""

from __future__ import annotations

import msgspec

from intellwheels_schemas.messages import Event, Robot


def nominal(robot: Robot) -> Robot:
    """Return a robot with the wheels and the track of its data sheet."""
    if robot.wheel_ratio == robot.wheel_scale == robot.track_ratio == 1.0:
        return robot
    return msgspec.structs.replace(robot, wheel_ratio=1.0, wheel_scale=1.0, track_ratio=1.0)


def without_positions(event: Event) -> Event:
    """Return an event without the place of the contact and the speed of the bodies."""
    if event.code == "speed":  # the speed of the clock, not of a body
        return event
    return msgspec.structs.replace(event, x=None, y=None, normal_x=None, normal_y=None, speed=None)
