"""Walks to its goals among others, by the social force model: drawn by a goal, kept off by what is near.

    points   "x y x y": goals one after the other, in metres
    via, to  places of the map; the goals are points, then via in their order, then to
    speed    metres a second it likes to walk (default 1.34)
    within   metres from a goal that count as there (default 0.4)
    loop     true: begin again with the first goal after the last (default: false)
    with     agents it walks with, by what they say ("at X Y", in metres); it says where it is itself

Forces alone do not slow a crowd down as people do. So nobody walks faster than lets the gap ahead last for `HEADWAY`,
nor, at ease, than (gap + `EASE_GAP`) / `EASE`; with these a crowd in a corridor is about as fast as Weidmann's at 0.5
to 2 people a square metre. Who would be run into within `DODGE` gets out of the way. Who has not come on for `STUCK`
goes where there is room.

It perceives by a ring of proximity cones, its own encoders and compass, and what it hears.

Sources: social_force.py. A. Tordeux, M. Chraibi, A. Seyfried, Collision-free speed model for pedestrian dynamics,
Traffic and Granular Flow '15, 2016 (speed from the gap). U. Weidmann, Transporttechnik der Fussgaenger, ETH Zurich,
1993. The rest is chosen here.
"""

from __future__ import annotations

import math

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.footprint import Footprint, Moving
from intellwheels_agents.mind import Context
from intellwheels_agents.minds.follow import point_in
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_ring import CONES, RangeRing, with_ring
from intellwheels_agents.range_scan import outline
from intellwheels_agents.social_force import LIKED, attraction, drive, repulsion
from intellwheels_schemas.messages import Actions, Goal, Measures, Robot

HEADWAY = 0.25
"""Seconds the gap ahead lasts at least."""
EASE_GAP = 0.3
"""Metres by which somebody who walks in front may be nearer: he walks on meanwhile. Fitted, as the next."""
EASE = 0.85
"""Seconds."""
TURNING = 6.0
"""Radians a second for each radian it must turn."""
TURN_RATE = 3.5
"""Radians a second at most: half a turn in a second."""
AHEAD = 0.3
"""Seconds it looks where a turn leads a shoulder."""
MARGIN = 0.03
"""Metres kept to everything."""
BACKWARD = 0.6
"""Metres a second, stepping back."""
DODGE = 0.6
"""Seconds before somebody runs into it at which it gets out of the way. With 1 s a dense crowd dodges all the time."""
ARM = 1.5
"""Metres within which it looks at where it steps."""
STILL = 0.05
"""Metres a second that are not worth a step."""
FASTEST = 1.3
"""Most, in shares of the speed it likes."""
STUCK = 1.0
"""Seconds without a step after which it looks for another way round, and takes it for as long."""
ROOM = 0.6
"""Metres of room that make a way."""
WORD = 0.5
"""Seconds between two says of who walks with others."""
SILENCE = 3.0
"""Seconds after which a companion who says nothing is gone."""


def equip(robot: Robot, _options: Options) -> Robot:
    """Return the robot with the ring of cones in place of its own proximity sensors."""
    return with_ring(robot)


class Mind:
    """Walks."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        if not robot.encoders or len(robot.proximity) != CONES:
            raise OptionError("mind person: expected a robot with encoders and the ring of cones, got one without")
        self._robot = robot
        self._speed = options.number("speed", LIKED, STILL, 5.0)
        self._within = options.number("within", 0.4, 0.01, 10.0)
        self._loop = options.flag("loop")
        self._with = options.words("with")
        self._goals = context.way()
        self._next = 0
        self._pose = Odometry(robot, context.position)
        self._velocity = (0.0, 0.0)
        self._period = context.parameters.period
        self._ring = RangeRing(robot, self._period)
        self._footprint = Footprint(outline(robot))
        self._heard: dict[str, tuple[float, Point]] = {}
        self._spoke = -math.inf
        self._stuck = 0.0
        hurry = FASTEST * self._speed
        self._ways_out = (
            (hurry, 0.0), (-BACKWARD, 0.0), (hurry / 2.0, 2.0), (hurry / 2.0, -2.0),
            (-BACKWARD, 2.0), (-BACKWARD, -2.0), (0.0, 0.0),
        )  # fmt: skip

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that follow the force."""
        pose = self._pose
        was_x, was_y = pose.x, pose.y
        pose.update(measures.sensors)
        self._ring.update(measures.sensors, pose)
        speed = math.dist((was_x, was_y), (pose.x, pose.y)) / self._period
        goal = self._goal()
        self._velocity = self._accelerated(self._wanted(goal), speed, self._company(measures))
        self._note_progress(speed, walks=goal is not None)
        left, right = self._walk(*self._velocity)
        return Actions(
            left_motor=left,
            right_motor=right,
            mode="arrived" if goal is None else "walking",
            goal=None if goal is None else Goal(x=goal[0], y=goal[1]),
            say=self._word(measures.time),
        )

    def _goal(self) -> Point | None:
        """Return the goal it walks to, None at the last."""
        while self._next < len(self._goals):
            goal = self._goals[self._next]
            if math.dist(goal, (self._pose.x, self._pose.y)) > self._within:
                return goal
            self._next += 1
            if self._loop and self._next == len(self._goals):
                self._next = 0
                return self._goals[0] if len(self._goals) > 1 else None
        return None

    def _wanted(self, goal: Point | None) -> Point:
        """Return the velocity it likes best, m/s."""
        if goal is None:
            return 0.0, 0.0
        share = self._speed / max(math.dist(goal, (self._pose.x, self._pose.y)), 1e-9)
        return share * (goal[0] - self._pose.x), share * (goal[1] - self._pose.y)

    def _company(self, measures: Measures) -> list[Point]:
        """Return where those are whom it walks with, as they said."""
        for words in measures.message:
            point = point_in(words.text) if words.sender in self._with else None
            if point is not None:
                self._heard[words.sender] = (measures.time, point)
        return [point for time, point in self._heard.values() if measures.time - time < SILENCE]

    def _word(self, time: float) -> str | None:
        """Return where it is, for those it walks with, when it is time to say so."""
        if not self._with or time - self._spoke < WORD:
            return None
        self._spoke = time
        return f"at {self._pose.x:.2f} {self._pose.y:.2f}"

    def _accelerated(self, wanted: Point, speed: float, company: list[Point]) -> Point:
        """Return the velocity after a cycle under all forces, m/s."""
        pose, velocity = self._pose, self._velocity
        moves = speed * math.cos(pose.heading), speed * math.sin(pose.heading)
        forces = (
            drive(wanted, velocity),
            repulsion(self._ring.things, wanted, velocity, moves, pose.heading),
            attraction((pose.x, pose.y), company) if wanted != (0.0, 0.0) else (0.0, 0.0),
        )
        x = velocity[0] + self._period * sum(force[0] for force in forces)
        y = velocity[1] + self._period * sum(force[1] for force in forces)
        fast = max(math.hypot(x, y) / (FASTEST * max(self._speed, LIKED)), 1.0)
        return x / fast, y / fast

    def _note_progress(self, speed: float, *, walks: bool) -> None:
        """Count how long it has not come on; beyond `STUCK`, how long it takes another way."""
        if self._stuck < STUCK and (speed >= STILL or not walks):
            self._stuck = 0.0
        else:
            self._stuck = (self._stuck + self._period) % (2.0 * STUCK)

    def _walk(self, x: float, y: float) -> tuple[float, float]:
        """Return the powers that turn to a velocity and walk at it as far as there is room."""
        speed, heading = math.hypot(x, y), self._pose.heading
        forward = turn_rate = 0.0
        if speed >= STILL:
            off = wrapped(math.atan2(y, x) - heading)
            if self._stuck >= STUCK:
                off, speed = self._ring.way_out(off, ROOM), max(speed, BACKWARD)
            turn_rate = min(max(TURNING * off, -TURN_RATE), TURN_RATE)
            gap = self._ring.gap()
            forward = min(speed * max(math.cos(off), 0.0), gap / HEADWAY, (gap + EASE_GAP) / EASE)
        near = self._ring.near(ARM, heading)
        if self._footprint.free_of_moving(near, 0.0, 0.0, DODGE, MARGIN) < DODGE:
            return powers(self._robot, *self._dodge(near, forward, turn_rate))
        still = [(x, y) for x, y, _, _ in near]
        # As it would, or straight on, or on the spot, or back to where there is room to turn.
        for ahead, turn in ((forward, turn_rate), (forward, 0.0), (0.0, turn_rate), (-BACKWARD, 0.0)):
            share = self._footprint.free(still, ahead, turn, AHEAD, MARGIN) / AHEAD
            if share > 0.5:
                return powers(self._robot, ahead * share, turn * share)
        return 0.0, 0.0

    def _dodge(self, near: list[Moving], forward: float, turn_rate: float) -> tuple[float, float]:
        """Return the speed and turn rate that keep longest out of the way of who runs into it."""
        best, longest = (forward, turn_rate), -1.0
        for ahead, turn in ((forward, turn_rate), *self._ways_out):
            time = self._footprint.free_of_moving(near, ahead, turn, DODGE, MARGIN)
            if time > longest:
                best, longest = (ahead, turn), time
            if longest >= DODGE:
                break
        return best
