"""Lets a body do as much of what is wanted as the obstacles allow that its proximity sensors saw.

It never does what was not wanted: forward and turn are each reduced, to 0 if necessary, and never reversed. Driving
straight away from an obstacle is always possible. The minds `aided` and `seek` drive with it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.navigation.motion_projection import STANDS, MotionProjection
from intellwheels_agents.navigation.obstacle_memory import CELL as MEMORY_CELL
from intellwheels_agents.navigation.obstacle_memory import REACH, ObstacleMemory
from intellwheels_agents.navigation.point_cells import Floats
from intellwheels_agents.options import OptionError
from intellwheels_agents.portable_math import hypot, sincos
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_scan import outline
from intellwheels_agents.wheel_motors import STILL, CommandLateness, Motors, SafeSpeed, Wheels
from intellwheels_schemas.messages import Actions, Measures

SHARES: Final = (1.0, 0.7, 0.45, 0.3, 0.2, 0.12, 0.06, 0.0)
"""Shares of the user's speed and turn rate that are tried."""
CREEP_SPEEDS: Final = (0.024, 0.012, 0.005)
"""Speeds that are tried as well, m/s, for the last centimetres before an obstacle."""
APPROACH: Final = 0.085
"""Clearance ahead and behind at which a user who drives on is stopped at the latest, m. The user must be able to come
within 0.104 m of an obstacle, and the arc of a reading can be up to 0.02 m nearer than the obstacle."""
CELL: Final = 0.02
"""Cell size of the obstacle memory, m. With points 0.03 m apart, a corner of the chair can come within 0.0125 m of all
of them without passing between two."""
BEHIND: Final = 1.0
"""Distance behind the centre of movement from which points block no strip, m."""
CURVE_WEIGHT: Final = 0.1
"""Penalty for different shares of speed and turn rate, which change the curve; ties go to equal shares."""
SHORTEST_STEP: Final = 0.05
"""Shortest cycle of a projection, s: at shorter periods of the simulation it is as fine as at this one."""


class Pose(NamedTuple):
    """A pose in the map's frame, m and rad, and how far the chair has turned since its start, rad."""

    x: float
    y: float
    heading: float
    turned: float


class CollisionGuard:
    """Drives a body as wanted, as far as the obstacles allow.

    Attributes:
        pose: The estimated pose at which the next command will act.
        points: Where obstacles may be around the chair, in its frame there: an array of shape (n, 2), m.
    """

    def __init__(self, context: Context, mind: str, speed: float, by_itself: bool = False) -> None:
        """Read the options `margin` and `ahead`.

        Args:
            context: The agent's context.
            mind: What the mind is called.
            speed: Its highest speed, m/s.
            by_itself: True if a mind drives instead of a user. Then the full margin is kept on all sides, half of it in
                a turn in place, and always enough room to turn in place, however long the chair is.

        Raises:
            OptionError: The robot has no encoders, or an option is wrong.
        """
        options, robot = context.options, context.robot
        if not robot.encoders:
            raise OptionError(f"mind {mind}: expected a robot with encoders, got one without")
        self._robot = robot
        self._margin = options.number("margin", 0.05, 0.01, 1.0)
        self._ahead = options.number("ahead", 1.0, 0.2, 5.0)
        self._odometry = Odometry(robot, context.position, compass_share=0.0)
        start = context.position
        self.pose = Pose(start.x, start.y, start.heading, 0.0)
        self.points: Floats = np.empty((0, 2))
        period = context.parameters.period
        self._late = CommandLateness(robot, period)
        motors = self._late.motors
        # Of a cycle of the simulation, and of one that is not too short to be projected in time.
        self._ticks = MotionProjection(outline(robot), robot.track, motors)
        self._projection = MotionProjection(outline(robot), robot.track, Motors.of(robot, max(period, SHORTEST_STEP)))
        sees = min((one.max_range for one in robot.proximity if one.mount == "body"), default=math.inf)
        far = speed * max(period, SHORTEST_STEP) + motors.stopping(speed) + self._margin
        sees = min(max(REACH, far), sees)
        self._safe_speed = SafeSpeed(motors, max(speed, robot.top_speed), sees - self._margin)
        self._obstacles = ObstacleMemory(robot, MEMORY_CELL if by_itself else CELL, max(REACH, sees))
        body = self._projection.outline
        # A turn in place may come nearer to obstacles than driving.
        self._driving_margin, self._turning_margin = (
            (self._margin, self._margin / 2.0) if by_itself else (self._margin / 4.0, self._margin / 4.0)
        )
        self._creep_speeds = () if by_itself else CREEP_SPEEDS
        extra = self._margin - self._driving_margin
        # The room that a corner needs beyond the front or the back to swing round.
        swings = [hypot(end, body.side) - end + extra for end in (body.front, body.back)]
        limit = math.inf if by_itself else max(extra, APPROACH - self._driving_margin)
        self._front_swing, self._back_swing = (min(swing, limit) for swing in swings)
        self._start = STILL
        self._tick = 0

    def perceive(self, measures: Measures) -> None:
        """Update with the measures of a tick."""
        self._tick = measures.tick
        self._odometry.update(measures.sensors)
        readings = measures.sensors.encoders if measures.sensors else ()
        self._late.update(measures, readings[0] if readings else None)
        self._odometry.tick = self._late.tick
        self._obstacles.update(measures, self._odometry)
        self._look_from_the_next_command()

    def drive(self, speed: float, rate: float, mode: str) -> Actions:
        """Return the powers for as much of a speed (m/s) and a turn rate (rad/s) as the obstacles allow."""
        # What is seen is as old as the pose by which it is placed. Until a command acts, the chair drives on.
        blind = self._tick - (self._late.tick or 0) + self._late.ticks + 1
        most = self._safe_speed.after(blind * self._ticks.motors.period)
        if abs(speed) > most:
            speed, rate, mode = math.copysign(most, speed), rate * most / abs(speed), "slow"
        commanded = self._allowed(speed, rate)
        self._late.send(self._tick, commanded)
        top = self._robot.top_speed or 1.0
        return Actions(left_motor=commanded.left / top, right_motor=commanded.right / top, mode=mode)

    def free_lengths(self, directions: Sequence[Point], half: float, reach: float, far: float) -> list[float]:
        """Return how far strips from the centre of movement are free of points, in m, at most `reach`.

        Args:
            directions: The sine and cosine of each strip's direction in the body's frame.
            half: Half the width of a strip, m.
            reach: The farthest that matters, m.
            far: Distance beyond which points are left out, m; those more than `BEHIND` behind are left out as well.
        """
        x, y = self.points.T
        near = (x > -BEHIND) & (np.sqrt(x * x + y * y) < far)
        x, y = x[near], y[near]
        s, c = np.array(directions).T[:, :, None]
        along, across = c * x + s * y, np.abs(c * y - s * x)
        lengths: list[float] = np.min(
            np.where((along > 0.0) & (across < half), along, reach), axis=1, initial=reach
        ).tolist()
        return lengths

    def _look_from_the_next_command(self) -> None:
        """Go on from the last measured pose to the one at which the next command acts, by the commands before it."""
        odometry, now = self._odometry, self._late.speeds
        moved = (0.0, 0.0, 0.0, 0.0)
        for command in self._late.pending(self._tick):
            now, moved = self._ticks.driven(now, command, moved)
        self._start = now
        x, y, turn, way = moved
        points = self._obstacles.points
        if way == 0.0:
            self.pose = Pose(odometry.x, odometry.y, odometry.heading, odometry.turned)
            self.points = points
            return
        s, c = sincos(odometry.heading)
        self.pose = Pose(
            odometry.x + c * x - s * y, odometry.y + s * x + c * y, wrapped(odometry.heading + turn),
            odometry.turned + turn,
        )  # fmt: skip
        s, c = sincos(turn)
        dx, dy = points[:, 0] - x, points[:, 1] - y
        self.points = np.column_stack([c * dx + s * dy, c * dy - s * dx])

    def _allowed(self, speed: float, rate: float) -> Wheels:
        """Return the wheel speeds for the largest share of a speed and a turn rate that is free."""
        projection, now, whole = self._projection, self._start, self._wheels_of(speed, rate)
        motors, fastest = projection.motors, max(abs(whole.left), abs(whole.right))
        # No share moves the body farther than the full command for the whole time, its run-out, and that of now.
        farthest = (abs(whole.left + whole.right) / 2.0) + abs(whole.right - whole.left) / projection.track * (
            projection.radius
        )
        still = projection.poses(now, STILL, 0.0)[-1][3]
        longest = farthest * (self._ahead + motors.period + motors.stopping(fastest) / max(fastest, STANDS)) + still
        points = self.points
        # Driving preserves the room for a turn in place; a turn in place uses it.
        swing_ahead = self._front_swing if speed > 0.0 else self._back_swing
        turning = projection.watched(points, self._turning_margin, 0.0, longest)
        driving = projection.watched(points, self._driving_margin, swing_ahead, longest) if speed else turning
        for forward, turn in _shares(abs(speed), abs(rate), self._creep_speeds):
            wheels = self._wheels_of(speed * forward, rate * turn)
            braking = motors.braking_time(max(abs(wheels.left), abs(wheels.right)), STANDS)
            motion = projection.poses(now, wheels, self._ahead - braking)
            watched, swing = (driving, swing_ahead) if speed * forward else (turning, 0.0)
            if projection.is_free(motion, watched, swing):
                return wheels
        return STILL

    def _wheels_of(self, speed: float, rate: float) -> Wheels:
        left, right = powers(self._robot, speed, rate)
        return Wheels(left * self._robot.top_speed, right * self._robot.top_speed)


@lru_cache(maxsize=64)
def _shares(speed: float, rate: float, creep_speeds: tuple[float, ...]) -> tuple[tuple[float, float], ...]:
    """Return the shares of forward and turn to try, the largest first; none if both are 0."""
    whole = speed + rate
    pairs = list(itertools.product(SHARES if speed else (0.0,), SHARES if rate else (0.0,)))
    if speed:
        pairs += ((share, share if rate else 0.0) for share in (creep / speed for creep in creep_speeds) if share < 1.0)
    return tuple(
        sorted(
            (pair for pair in pairs if any(pair)),
            key=lambda pair: CURVE_WEIGHT * abs(pair[0] - pair[1]) - (pair[0] * speed + pair[1] * rate) / whole,
        )
    )
