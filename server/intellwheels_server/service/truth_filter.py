"""What a laboratory keeps for its log: where its bodies truly are, and how their wheels truly are.

A world that plays the building in which real chairs drive (`--hide-truth`) puts on the network what a chair's own
electronics would give, and no more. Whoever listens to everything in it learns no pose, no place of a contact and no
figure by which a wheel differs from its data sheet. All of that is a function of the input log.
"""

from __future__ import annotations

import msgspec

from intellwheels_schemas.messages import Event, Robot


def nominal(robot: Robot) -> Robot:
    """Return a robot as its data sheet has it."""
    if robot.wheel_ratio == robot.wheel_scale == robot.track_ratio == 1.0:
        return robot
    return msgspec.structs.replace(robot, wheel_ratio=1.0, wheel_scale=1.0, track_ratio=1.0)


def placeless(event: Event) -> Event:
    """Return an event without where it was and how fast things were."""
    if event.code == "speed":  # of the clock, not of a body
        return event
    return msgspec.structs.replace(event, x=None, y=None, normal_x=None, normal_y=None, speed=None)
