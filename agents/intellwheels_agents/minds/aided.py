"""Drives as its user wants, slowed and stopped before it would touch what its proximity sensors saw.

    speed    metres a second that full forward gives (default 0.8)
    turn     radians a second that full turn gives (default 1.0)
    words    share of full that a word alone asks for: forward, back, left, right, stop (default 0.5)
    margin   metres kept around the chair, a quarter of it to the sides (default 0.05)
    ahead    seconds over which the footprint is projected (default 1.0)

It never does what was not wanted: forward and turn are each slowed, to nothing if need be, and neither is turned
round. What leads away from things is always free. A stop keeps room ahead and behind to turn in place by, but no more
than lets a user come to 0.104 m of a thing: a chair whose corners are far beyond its front (mid-wheel, front-wheel)
turns a little there, and goes back first for the rest. A long back beside a wall cannot turn
away from it in place either.
Where no sensor looks (a robot without sensors behind, things above or below their height, what stands between two cones
from the start) it is as blind as `joystick`. Two cones that are added ahead tell a doorway from a wall.
Before a narrow doorway that is approached from the side it may stop at what two cones left undecided.
"""

from __future__ import annotations

import itertools
import math
from typing import Final

import msgspec

from intellwheels_agents.differential_drive import Odometry, powers
from intellwheels_agents.mind import Context
from intellwheels_agents.motion_projection import MotionProjection, Wheels
from intellwheels_agents.obstacle_memory import ObstacleMemory
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.range_scan import outline
from intellwheels_agents.user_input import wanted
from intellwheels_schemas.messages import Actions, Measures, Robot, Sensors

SHARES: Final = (1.0, 0.7, 0.45, 0.3, 0.2, 0.12, 0.06, 0.0)
"""Shares of the wish that are tried."""
CREEPS: Final = (0.024, 0.012, 0.005)
"""Metres a second that are tried as well, for the last centimetres before a thing."""
APPROACH: Final = 0.085
"""Metres ahead and behind where a user who goes on is stopped at the latest; an arc tells of a thing as up to 0.02 m
nearer than it is, and he is to get as near as 0.104 m."""
CELL: Final = 0.02
"""Metres of the raster of what was seen. With points 0.03 m apart a corner can come to 0.0125 m of all of them and
not lie between two."""
ASIDE: Final = 0.26
"""Metres from the middle to the two cones that `equip` adds: from a metre and a half before a doorway of 0.81 m they
see through it, and so tell that nothing stands in it where the cones of a chair's middle and corners do not look."""
ALONE: Final = 0.1
"""What less of the wish is worth to keep its curve: a tie goes to equal shares."""
DOUBT: Final = 0.05
"""Metres a second by which encoders may differ from the motors' model, which has no quantisation, before they count."""


def equip(robot: Robot, options: Options) -> Robot:  # noqa: ARG001 - as `Equip` has it
    """Return the robot with user input declared, and two narrow cones that look ahead where it has any that looks."""
    ahead = next((one for one in robot.proximity if one.mount == "body" and one.direction_deg == 0.0), None)
    if ahead is None:
        return msgspec.structs.replace(robot, user_input=("drive", "words"))
    aside = min(ASIDE, outline(robot).side)
    # A little outward: they stand in their order among the others.
    more = tuple(
        msgspec.structs.replace(ahead, id=f"aid-{name}", y=sign * aside, direction_deg=sign * 0.5, cone_deg=10.0)
        for name, sign in (("left", 1.0), ("right", -1.0))
    )
    return msgspec.structs.replace(robot, user_input=("drive", "words"), proximity=(*robot.proximity, *more))


class Mind:
    """Gives as much of what its user wants as there is room for.

    Attributes:
        pose: Where it believes it is.
        seen: What may stand around it.
    """

    def __init__(self, context: Context, by_itself: bool = False) -> None:
        """Take the robot and its options.

        Args:
            context: Of the agent.
            by_itself: Whether a mind drives and no user: the whole margin is then kept on all sides, and always the
                room to turn in place, however long the chair.

        Raises:
            OptionError: The robot has no encoders, or an option is wrong.
        """
        options, robot = context.options, context.robot
        if not robot.encoders:
            raise OptionError("mind aided: expected a robot with encoders, got one without")
        self._robot = robot
        self._speed = options.number("speed", 0.8, 0.0, 5.0)
        self._turn = options.number("turn", 1.0, 0.0, 5.0)
        self._words = options.number("words", 0.5, 0.0, 1.0)
        self._margin = options.number("margin", 0.05, 0.01, 1.0)
        self._ahead = options.number("ahead", 1.0, 0.2, 5.0)
        self.pose = Odometry(robot, context.position, compass_share=0.0)
        self.seen = ObstacleMemory(robot) if by_itself else ObstacleMemory(robot, CELL)
        self._footprint = MotionProjection(
            outline(robot), robot.track, robot.acceleration_curve, context.parameters.period
        )
        body = self._footprint.outline
        # Who turns in place comes near on purpose.
        self._beside, self._turning = (
            (self._margin, self._margin / 2.0) if by_itself else (self._margin / 4.0, self._margin / 4.0)
        )
        self._creeps = () if by_itself else CREEPS
        more = self._margin - self._beside
        # The room a corner needs to swing by.
        swings = [math.hypot(end, body.side) - end + more for end in (body.front, body.back)]
        most = math.inf if by_itself else max(more, APPROACH - self._beside)
        self._front_swing, self._back_swing = (min(swing, most) for swing in swings)
        self._wheels = Wheels(0.0, 0.0)
        self._told = Wheels(0.0, 0.0)
        self._counts: tuple[int, int] | None = None

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for as much as there is room for."""
        self.perceive(measures)
        forward, turn = wanted(measures.user_input, self._words)
        return self.drive(forward * self._speed, turn * self._turn, "aided")

    def perceive(self, measures: Measures) -> None:
        """Take what is perceived at a tick, for another that decides what is wanted."""
        self.pose.update(measures.sensors)
        self.seen.update(measures, self.pose)
        self._measure_wheels(measures.sensors)

    def drive(self, speed: float, rate: float, mode: str) -> Actions:
        """Return the powers for as much of a speed, m/s, and a turn rate, rad/s, as there is room for."""
        self._told = self._allowed(speed, rate)
        top = self._robot.top_speed or 1.0
        return Actions(left_motor=self._told.left / top, right_motor=self._told.right / top, mode=mode)

    def _measure_wheels(self, sensors: Sensors | None) -> None:
        """Set the wheels' speeds: what the motors' model says, unless the encoders say something else."""
        self._wheels = self._wheels.lagged(self._told, self._footprint.inertia)
        if sensors is None or not sensors.encoders:
            return
        counts = sensors.encoders[0].left, sensors.encoders[0].right
        if self._counts is not None:
            robot = self._robot
            metres = math.pi * robot.wheel_diameter / robot.encoder_ticks / self._footprint.period
            seen = Wheels((counts[0] - self._counts[0]) * metres, (counts[1] - self._counts[1]) * metres)
            if max(abs(seen.left - self._wheels.left), abs(seen.right - self._wheels.right)) > DOUBT:
                self._wheels = seen
        self._counts = counts

    def _allowed(self, speed: float, rate: float) -> Wheels:
        """Return the wheels' speeds for the most of a wish that is free."""
        footprint, now, still = self._footprint, self._wheels, Wheels(0.0, 0.0)
        # No share of the wish moves the body by more than the whole and its rolling out together.
        ways = (footprint.poses(now, wheels, self._ahead) for wheels in (self._wheels_of(speed, rate), still))
        longest = sum(way[-1][3] for way in ways)
        points = self.seen.points
        # Who drives keeps room to turn by; who turns in place uses it.
        ahead = self._front_swing if speed > 0.0 else self._back_swing
        turning = footprint.watched(points, self._turning, 0.0, longest)
        driving = footprint.watched(points, self._beside, ahead, longest) if speed else turning
        for forward, turn in _shares(abs(speed), abs(rate), self._creeps):
            wheels = self._wheels_of(speed * forward, rate * turn)
            way = footprint.poses(now, wheels, self._ahead)
            watched, swing = (driving, ahead) if speed * forward else (turning, 0.0)
            if footprint.is_free(way, watched, swing):
                return wheels
        return still

    def _wheels_of(self, speed: float, rate: float) -> Wheels:
        left, right = powers(self._robot, speed, rate)
        return Wheels(left * self._robot.top_speed, right * self._robot.top_speed)


def _shares(speed: float, rate: float, creeps: tuple[float, ...]) -> list[tuple[float, float]]:
    """Return shares of forward and turn to try, the most of the wish first; none when nothing is wished."""
    whole = speed + rate
    pairs = list(itertools.product(SHARES if speed else (0.0,), SHARES if rate else (0.0,)))
    if speed:
        pairs += ((share, share if rate else 0.0) for share in (creep / speed for creep in creeps) if share < 1.0)
    return sorted(
        (pair for pair in pairs if any(pair)),
        key=lambda pair: ALONE * abs(pair[0] - pair[1]) - (pair[0] * speed + pair[1] * rate) / whole,
    )
