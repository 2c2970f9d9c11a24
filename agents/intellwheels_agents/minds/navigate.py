"""Drives to places on the map, around what is in the way, and touches nothing.

    points   "x y x y": points to drive to, in the coordinates of the map's site, m
    via, to  places of the map; the chair drives through points, then via in their order, then to; without any of the
             three options it waits for a goal
    speed    highest speed, m/s (default 0.8)
    within   distance from the goal that counts as arrived, m (default 0.15)
    truth    true: use the true pose from a truth sensor, which the simulation must allow (default false)
    lidar    true: add two laser scanners at opposite corners to a robot without any; false: only its own sensors
             (default true)
    map      path of a map file, instead of the simulator's map

It plans with the exact footprint of the robot at every heading, including the height of each of its parts. At every
tick it considers only commands after which it can still stop before anything its sensors see, and takes the one with
the lowest cost. The folder `agents/intellwheels_agents/navigation` has the methods, with sources. The pose comes from
odometry and a particle filter that matches scans, or cones of proximity sensors, with the map. A goal of the user, in
the viewer or by `UserInput.Goal`, and the messages "go PLACE" and "go X Y" replace the goals.

Where it makes no progress, it says "open" to a closed doorway, leaves room for the leaf, and announces its path ("way
X Y X Y ...", in metres). A chair with this mind that stands on an announced path gives way (it drives off the path and
waits) in two cases: it has already arrived; or it makes no progress, and its name comes after the sender's in
alphabetical order. The mind plans around what is not on the map, and backs out of where it is stuck. Sensors and
commands may be late. If its braking distance would be longer than its sensors can see, it drives more slowly and
reports the mode `slow`. It needs numpy: the extra `navigate`. It cannot see what is above or below its sensors and not
on the map.
"""

from __future__ import annotations

import msgspec

from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.range_scan import outline
from intellwheels_agents.user_input import takes_goals
from intellwheels_maps import floor
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.messages import Actions, Lidar, Measures, Robot, Truth

HEIGHT = 0.3
"""Height of the added scanners, m: legs, footrests, beds and doors are there."""
RANGE = 8.0
"""Range of the added scanners, m."""


def equip(robot: Robot, options: Options) -> Robot:
    """Return the robot with goals as user input and, as the options say, with scanners and a truth sensor."""
    robot = takes_goals(robot, options)
    if options.flag("truth") and not robot.truth:
        robot = msgspec.structs.replace(robot, truth=(Truth(id="truth"),))
    if options.flag("lidar", True) and not robot.lidar:
        body = outline(robot)
        scanners = tuple(
            Lidar(
                id=f"scan-{name}", x=x, y=y, z=HEIGHT, direction_deg=direction, fov_deg=270.0, rays=271, max_range=RANGE
            )
            for name, x, y, direction in (
                ("front", body.front, body.side, 45.0), ("back", -body.back, -body.side, -135.0),
            )
        )  # fmt: skip
        robot = msgspec.structs.replace(robot, lidar=scanners)
    return robot


class Mind:
    """Drives to its goals."""

    def __init__(self, context: Context) -> None:
        """Read the options and prepare the map.

        Raises:
            OptionError: numpy is missing, or an option is wrong.
        """
        lacking = missing_extra("navigate")
        if lacking is not None:
            raise OptionError(f"mind navigate: {lacking}")
        from intellwheels_agents.navigation.navigator import Navigator  # noqa: PLC0415 - an optional dependency

        options, robot = context.options, context.robot
        options.flag("lidar", True)
        if options.flag("truth") and not robot.truth:
            raise OptionError("option truth: expected false for a robot without a truth sensor, got true")
        if not options.flag("truth") and not (robot.encoders or robot.odometry):
            raise OptionError("option truth: expected true for a robot without encoders and odometry, got false")
        file = options.text("map")
        document = floor(file) if file else context.map
        self._navigator = Navigator(
            context,
            document,
            options.number("speed", 0.8, 0.05, 5.0),
            options.number("within", 0.15, 0.01, 10.0),
            options.flag("truth"),
            context.route(),
        )

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that drive on."""
        return self._navigator.decide(measures)
