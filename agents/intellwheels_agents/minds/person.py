"""A pedestrian who walks to goals among others, by the social force model.

    points   "x y x y": goals in their order, in the coordinates of the map's site, m
    via, to  places of the map; the goals are points, then via in their order, then to; without any of the three
             options it stands still
    speed    preferred walking speed, m/s (default 1.34)
    within   distance from a goal that counts as arrived, m (default 0.4)
    loop     true: start again with the first goal after the last (default false)
    with     agents to walk with as a group; they hear each other's positions ("at X Y", in metres)
    likes    agents that attract it by the positions that they say; after its goals it follows the nearest one
    fears    agents that repel it by the positions that they say: it keeps off, even from its goal
    lead     true: say its position, for agents that follow, like or fear it (default false)

Forces alone do not slow a crowd down as real people do. So the speed is also limited by the gap ahead: to gap /
0.25 s, and to (gap + 0.3 m) / 0.85 s. With these limits a crowd in a corridor is about as fast as Weidmann's at 0.5 to
2 people a square metre. If somebody would run into the pedestrian within 0.6 s, it gets out of the way. If it has not
moved for 1 s, it walks where the way is free.

The map tells it where doorways are. On its way to a doorway, and in it, whoever is nearer goes first and the others
keep a gap (`agents/intellwheels_agents/doorway_queue.py`). If a wall is in the straight way to its goal, it walks
through a doorway that it sees.

It perceives with a ring of proximity cones, encoders, a compass, and messages. What it feels for others is described
in `agents/intellwheels_agents/feelings.py`.

Sources: those of the forces are in `agents/intellwheels_agents/social_force.py`. A. Tordeux, M. Chraibi, A. Seyfried,
Collision-free speed model for pedestrian dynamics, Traffic and Granular Flow '15, 2016 (speed from the gap).
U. Weidmann, Transporttechnik der Fussgaenger, ETH Zurich, 1993. All other numbers are our own choice.
"""

from __future__ import annotations

import math

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.doorway_queue import PASSED, ZONE, DoorStep, DoorwayQueue, aim
from intellwheels_agents.doorways import WIDEST, Doorway, doorways, way_through
from intellwheels_agents.feelings import felt, nearest, pull, push
from intellwheels_agents.footprint import Footprint, MovingPoint
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.portable_math import atan2, cos, dist, hypot, sincos
from intellwheels_agents.position_message import position_in, position_message
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_ring import CONES, RangeRing, with_ring
from intellwheels_agents.range_scan import outline
from intellwheels_agents.social_force import PREFERRED_SPEED, attraction, drive, repulsion
from intellwheels_schemas.messages import Actions, Goal, Measures, Robot

TIME_GAP = 0.25
"""Shortest time in which the gap ahead may be used up, s."""
FOLLOWING_GAP = 0.3
"""Added to the gap ahead, m, because a person in front walks on meanwhile. Fitted, like `FOLLOWING_TIME`."""
FOLLOWING_TIME = 0.85
"""Time in which a comfortable walker uses up the gap ahead, s."""
TURN_GAIN = 6.0
"""Turn rate for each radian of heading error, 1/s."""
TURN_RATE = 3.5
"""Highest turn rate, rad/s: half a turn in a second."""
LOOK_AHEAD = 0.3
"""How far a motion of the footprint is checked, s: a turn moves the shoulders."""
MARGIN = 0.03
"""Clearance kept to everything, m."""
BACKWARD = 0.6
"""Speed of stepping back, m/s."""
DODGE_TIME = 0.6
"""Time to a collision at which it gets out of the way, s. With 1 s, a dense crowd dodges all the time."""
STEP_RANGE = 1.5
"""Range within which it checks where it steps, m."""
STANDING = 0.05
"""Speed below which it stands, m/s."""
FASTEST = 1.3
"""Highest speed, as a multiple of the preferred speed."""
STUCK_TIME = 1.0
"""Time without progress after which it takes a way out, and for how long, s."""
WAY_OUT = 0.6
"""Free distance that makes a way out, m."""
SAY_PERIOD = 0.5
"""Time between two messages of a walker in a group, s."""
LOOK_PERIOD = 0.5
"""Time between two looks for a doorway on the way, s."""
MAKE_ROOM = -0.4, 0.0
"""Speed, m/s, and turn rate of a step back that makes room at a doorway."""
SMALL_TURN = 0.3
"""Turn rate below which a turn in place is no motion, rad/s."""
SILENCE = 3.0
"""Time after which somebody who says no position is ignored, s."""


def equip(robot: Robot, _options: Options) -> Robot:
    """Return the robot with the ring of cones instead of its own proximity sensors."""
    return with_ring(robot)


class Mind:
    """Walks to its goals."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        if not robot.encoders or len(robot.proximity) != CONES:
            raise OptionError("mind person: expected a robot with encoders and the ring of cones, got one without")
        self._robot = robot
        self._speed = options.number("speed", PREFERRED_SPEED, STANDING, 5.0)
        self._within = options.number("within", 0.4, 0.01, 10.0)
        self._loop = options.flag("loop")
        self._companions = options.words("with")
        self._likes, self._fears = options.words("likes"), options.words("fears")
        for name in self._fears:
            if name in self._likes:
                raise OptionError(f"option fears: expected agents that it does not like, got {name!r}")
        self._leads = options.flag("lead")
        self._goals = context.route()
        self._next = 0
        self._pose = Odometry(robot, context.position)
        self._velocity = (0.0, 0.0)
        self._period = context.parameters.period
        self._ring = RangeRing(robot, self._period)
        self._footprint = Footprint(outline(robot))
        self._heard: dict[str, tuple[float, Point]] = {}
        self._said_at = -math.inf
        self._stuck = 0.0
        self._doors, self._walls = doorways(context.map) if self._goals or self._likes else ((), ())
        self._door: Doorway | None = None
        self._looked: tuple[float, Point | None] = (-math.inf, None)
        self._queue = DoorwayQueue(outline(robot), context.agent)
        fastest = FASTEST * self._speed
        self._dodges = (
            (fastest, 0.0), (-BACKWARD, 0.0), (fastest / 2.0, 2.0), (fastest / 2.0, -2.0),
            (-BACKWARD, 2.0), (-BACKWARD, -2.0), (0.0, 0.0),
        )  # fmt: skip

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that follow the social force."""
        pose = self._pose
        old_x, old_y = pose.x, pose.y
        pose.update(measures.sensors)
        self._ring.update(measures.sensors, pose)
        speed = dist((old_x, old_y), (pose.x, pose.y)) / self._period
        self._listen(measures)
        group, liked, feared = (
            self._known(names, measures.time) for names in (self._companions, self._likes, self._fears)
        )
        goal, here = self._goal(), (pose.x, pose.y)
        walks = goal is not None
        if goal is None:
            goal = nearest(here, liked)
        eager = 0.0 if goal is None else 1.0 if walks else pull(here, goal)
        self._look_for_door(goal, measures.time)
        afraid = any(push(here, other) for other in feared)
        step = None if afraid or eager == 0.0 else self._door_step(speed)
        if step is None:
            wanted = self._wanted(self._target(goal))
            if eager < 1.0:
                wanted = eager * wanted[0], eager * wanted[1]
            if afraid or (walks and liked):
                wanted = felt(here, wanted, self._speed, liked if walks else (), feared)
            self._velocity = self._accelerated(wanted, speed, group)
        else:
            s, c = sincos(pose.heading)
            self._velocity = speed * c, speed * s
        self._count_stuck(speed, walks=eager > 0.0 and not afraid, waits=step is not None and step.yields)
        forward, turn_rate = self._towards(*self._velocity) if step is None else self._through(step, eager)
        left, right = self._walk(forward, turn_rate, back=step is not None and step.back)
        return Actions(
            left_motor=left,
            right_motor=right,
            mode="walking" if walks else "arrived" if goal is None else "following",
            goal=None if goal is None else Goal(x=goal[0], y=goal[1]),
            say=self._say(measures.time),
        )

    def _goal(self) -> Point | None:
        """Return the present goal, or None after the last."""
        while self._next < len(self._goals):
            goal = self._goals[self._next]
            if dist(goal, (self._pose.x, self._pose.y)) > self._within:
                return goal
            self._next += 1
            if self._loop and self._next == len(self._goals):
                self._next = 0
                return self._goals[0] if len(self._goals) > 1 else None
        return None

    def _look_for_door(self, goal: Point | None, time: float) -> None:
        """Look from time to time for a doorway on the way to the goal; keep one until it is passed."""
        here = (self._pose.x, self._pose.y)
        if self._looked[1] != goal or (self._door is not None and self._door.local(*here)[0] > PASSED):
            self._door, self._looked = None, (-math.inf, goal)
        if self._doors and goal is not None and time - self._looked[0] >= LOOK_PERIOD:
            self._looked = time, goal
            kept = self._door if self._at_door() else None
            self._door = way_through(self._doors, self._walls, here, goal) or kept

    def _at_door(self) -> bool:
        """Return whether it is so near a narrow doorway on its way that the order there holds."""
        door = self._door
        if door is None or door.width > WIDEST:
            return False
        return dist((self._pose.x, self._pose.y), (door.x, door.y)) < ZONE

    def _door_step(self, speed: float) -> DoorStep | None:
        """Return the step before or in a doorway, or None where there is none near."""
        if self._door is None or not self._at_door():
            return None
        return self._queue.step(self._door, self._pose, self._ring, self._speed, speed, self._period)

    def _target(self, goal: Point | None) -> Point | None:
        """Return the point to walk to: the goal, or a point at the doorway that leads to it."""
        door = self._door
        if goal is None or door is None:
            return goal
        return door.on_map(*aim(door, *door.local(self._pose.x, self._pose.y)))

    def _wanted(self, goal: Point | None) -> Point:
        """Return the preferred velocity, m/s."""
        if goal is None:
            return 0.0, 0.0
        share = self._speed / max(dist(goal, (self._pose.x, self._pose.y)), 1e-9)
        return share * (goal[0] - self._pose.x), share * (goal[1] - self._pose.y)

    def _listen(self, measures: Measures) -> None:
        """Note where others say that they are."""
        for message in measures.message:
            names = (self._companions, self._likes, self._fears)
            point = position_in(message.text) if any(message.sender in each for each in names) else None
            if point is not None:
                self._heard[message.sender] = (measures.time, point)

    def _known(self, names: tuple[str, ...], time: float) -> list[Point]:
        """Return the positions of some agents, as they last said them, m."""
        heard = (self._heard.get(name, (-math.inf, (0.0, 0.0))) for name in dict.fromkeys(names))
        return [point for at, point in heard if time - at < SILENCE]

    def _say(self, time: float) -> str | None:
        """Return the message with its position for the others, if one is due."""
        if not (self._companions or self._leads) or time - self._said_at < SAY_PERIOD:
            return None
        self._said_at = time
        return position_message(self._pose.x, self._pose.y, 2)

    def _accelerated(self, wanted: Point, speed: float, group: list[Point]) -> Point:
        """Return the velocity after a tick under all forces, m/s."""
        pose, velocity = self._pose, self._velocity
        s, c = sincos(pose.heading)
        actual = speed * c, speed * s
        forces = (
            drive(wanted, velocity),
            repulsion(self._ring.objects, wanted, velocity, actual, pose.heading),
            attraction((pose.x, pose.y), group) if wanted != (0.0, 0.0) else (0.0, 0.0),
        )
        x = velocity[0] + self._period * math.fsum(force[0] for force in forces)
        y = velocity[1] + self._period * math.fsum(force[1] for force in forces)
        excess = max(hypot(x, y) / (FASTEST * max(self._speed, PREFERRED_SPEED)), 1.0)
        return x / excess, y / excess

    def _count_stuck(self, speed: float, *, walks: bool, waits: bool) -> None:
        """Count how long it has made no progress; beyond `STUCK_TIME`, for how long it takes a way out."""
        if self._stuck < STUCK_TIME and speed < STANDING and waits:
            self._stuck = min(self._stuck + self._period, 0.9 * STUCK_TIME)
        elif self._stuck < STUCK_TIME and (speed >= STANDING or not walks):
            self._stuck = 0.0
        else:
            self._stuck = (self._stuck + self._period) % (2.0 * STUCK_TIME)

    def _towards(self, x: float, y: float) -> tuple[float, float]:
        """Return the speed (m/s) and turn rate (rad/s) that walk with a velocity (m/s) as far as the way is free."""
        speed = hypot(x, y)
        if speed < STANDING:
            return 0.0, 0.0
        off = wrapped(atan2(y, x) - self._pose.heading)
        if self._stuck >= STUCK_TIME:
            off, speed = self._ring.way_out(off, WAY_OUT), max(speed, BACKWARD)
        gap = self._ring.gap()
        return min(speed * max(cos(off), 0.0), gap / TIME_GAP, (gap + FOLLOWING_GAP) / FOLLOWING_TIME), turn_to(off)

    def _through(self, step: DoorStep, eager: float) -> tuple[float, float]:
        """Return the speed (m/s) and turn rate (rad/s) of a step at a doorway, at a share of the preferred speed."""
        off = self._ring.way_out(step.off, WAY_OUT) if self._stuck >= STUCK_TIME else step.off
        return min(eager * self._speed * max(cos(off), 0.0), step.limit), turn_to(off)

    def _walk(self, forward: float, turn_rate: float, *, back: bool) -> tuple[float, float]:
        """Return the powers for a speed (m/s) and turn rate (rad/s), or for what is possible instead."""
        heading = self._pose.heading
        near = self._ring.near(STEP_RANGE, heading)
        free = self._footprint.free_of_moving
        if free(near, 0.0, 0.0, DODGE_TIME, MARGIN, DODGE_TIME) < DODGE_TIME:
            return powers(self._robot, *self._dodge(near, forward, turn_rate))
        standing = [(x, y, 0.0, 0.0) for x, y, _, _ in near]
        # As wanted, or straight on, or a turn in place, or back to where it can turn.
        ways = ((forward, turn_rate), (forward, 0.0), (0.0, turn_rate), (-BACKWARD, 0.0))
        for ahead, turn in (MAKE_ROOM, *ways) if back else ways:
            if self._door is not None and ahead == 0.0 and abs(turn) < SMALL_TURN:
                continue
            share = free(standing, ahead, turn, LOOK_AHEAD, MARGIN, 0.5 * LOOK_AHEAD) / LOOK_AHEAD
            if share > 0.5:
                return powers(self._robot, ahead * share, turn * share)
        return 0.0, 0.0

    def _dodge(self, near: list[MovingPoint], forward: float, turn_rate: float) -> tuple[float, float]:
        """Return the speed (m/s) and turn rate (rad/s) that avoid a collision for the longest time."""
        best, longest = (forward, turn_rate), -1.0
        for ahead, turn in ((forward, turn_rate), *self._dodges):
            time = self._footprint.free_of_moving(near, ahead, turn, DODGE_TIME, MARGIN, longest)
            if time > longest:
                best, longest = (ahead, turn), time
            if longest >= DODGE_TIME:
                break
        return best


def turn_to(off: float) -> float:
    """Return the turn rate (rad/s) towards a heading that is `off` rad from the present one."""
    return min(max(TURN_GAIN * off, -TURN_RATE), TURN_RATE)
