"""Drives as its user wants, but slows down and stops before it touches an obstacle that its proximity sensors saw.

    speed    speed at full forward, m/s (default 0.8)
    turn     turn rate at full turn, rad/s (default 1.0)
    words    deflection for the words forward, back, left and right; stop is always 0 (default 0.5)
    margin   clearance kept ahead and behind, m; a quarter of it to the sides, and in a turn in place (default 0.05)
    ahead    seconds that it looks ahead; more if braking takes longer (default 1.0)

Sensors and commands may be late: each reading is placed where the sensor was when it measured, and the delay of
commands is measured with the encoders. If its braking distance would be longer than its sensors can see, the chair
drives more slowly and reports the mode `slow`. It never does what the user did not ask for: forward and turn are each
reduced, to 0 if necessary, and never reversed. It needs numpy: the extra `navigate`.

Ahead and behind, the clearance is increased so that the corners have room to turn in place. At each end it is at most
0.085 m, `margin` included, or `margin` if that is more. A reading can be up to 0.02 m short. In the tests, with the
default margin, the user can always drive to within 0.104 m of an obstacle. Driving straight away from an obstacle is
always possible; turning away is not. A chair whose corners swing far beyond its front (mid-wheel, front-wheel) must
first back up, and a chair that extends far behind its wheels cannot turn in place beside a wall.

It cannot see what no sensor sees: anything behind a robot without rear sensors, anything above or below the sensors,
and anything that has been between two cones ever since the run began. To a robot with a cone straight ahead, the mind
adds two narrow ones, which tell a doorway from a wall. In front of a narrow doorway approached at an angle it may still
stop, because two cones leave the gap unclear.
"""

from __future__ import annotations

from typing import Final

import msgspec

from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.range_scan import outline
from intellwheels_agents.user_input import takes_drive, wanted
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.messages import Actions, Measures, Robot

CONE_INSET: Final = 0.03
"""Distance of the two added cones from the sides of the body, m. A chair drives straight ahead in a strip as wide as
itself and its margins. From 1.05 m on, these cones and one of 30 degrees at the middle see the whole strip, with 0.02 m
to spare at its sides. Nearer to the middle they would not see its sides; nearer to the sides they would leave a gap
beside the cone at the middle. Points that no cone sees past stay in the way."""


def equip(robot: Robot, options: Options) -> Robot:
    """Return the robot with user input declared and, if it has a cone straight ahead, two more narrow ones."""
    robot = takes_drive(robot, options)
    ahead = next((one for one in robot.proximity if one.mount == "body" and one.direction_deg == 0.0), None)
    if ahead is None:
        return robot
    offset = max(0.0, outline(robot).side - CONE_INSET)
    # Turned slightly outward, so that sorting by direction puts them between the neighbouring cones.
    added = tuple(
        msgspec.structs.replace(ahead, id=f"aid-{name}", y=sign * offset, direction_deg=sign * 0.5, cone_deg=10.0)
        for name, sign in (("left", 1.0), ("right", -1.0))
    )
    return msgspec.structs.replace(robot, proximity=(*robot.proximity, *added))


class Mind:
    """Does as much of what its user wants as the obstacles allow."""

    def __init__(self, context: Context) -> None:
        """Read the options.

        Raises:
            OptionError: numpy is missing, the robot has no encoders, or an option is wrong.
        """
        lacking = missing_extra("navigate")
        if lacking is not None:
            raise OptionError(f"mind aided: {lacking}")
        from intellwheels_agents.navigation.collision_guard import CollisionGuard  # noqa: PLC0415 - an extra

        options = context.options
        self._speed = options.number("speed", 0.8, 0.0, 5.0)
        self._turn = options.number("turn", 1.0, 0.0, 5.0)
        self._words = options.number("words", 0.5, 0.0, 1.0)
        self._guard = CollisionGuard(context, "aided", self._speed)

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for as much of the user's wish as the obstacles allow."""
        self._guard.perceive(measures)
        forward, turn = wanted(measures.user_input, self._words)
        return self._guard.drive(forward * self._speed, turn * self._turn, "aided")
