"""Walks to its goals among others, by the social force model: drawn by where it wants to be, kept off by what is near.

    points   "x y x y": goals one after the other, in metres
    via, to  places of the map; the goals are points, then via in their order, then to
    speed    metres a second it likes to walk (default 1.34)
    within   metres from a goal that count as there (default 0.4)
    loop     true: begin again with the first goal after the last (default: false)

    dv/dt = (v0 e - v) / tau + sum of f,  f = (V / s) exp(-b / s), away from the thing

with e the way to the goal, and b the half axis of the ellipse round where the thing is and where it will be in a step
of `STEP` seconds: who comes nearer is felt from afar, who walks along hardly. What is behind is felt by a share. To
round what comes straight on the force has a part beside the way too, to the right when there is nothing to choose.

Forces alone do not slow a crowd down as people do. So nobody walks faster than lets the gap ahead last for `HEADWAY`,
nor, at ease, than (gap + `EASE_GAP`) / `EASE`; with these a corridor has the flow of Weidmann's at 0.5 to 2 people a
square metre.

It perceives by a ring of proximity cones: a thing is where the ring is nearer than on either side, and how fast it
comes is how fast its distance shrinks beyond the own walk.

Sources: D. Helbing, P. Molnar, Social force model for pedestrian dynamics, Phys. Rev. E 51, 1995 (v0, tau, V, s, the
step, the angle of sight). A. Johansson, D. Helbing, P. Shukla, Specification of the social force pedestrian model by
evolutionary adjustment to video tracking data, Adv. Complex Systems 10, 2007 (the share behind). A. Tordeux,
M. Chraibi, A. Seyfried, Collision-free speed model for pedestrian dynamics, Traffic and Granular Flow '15, 2016
(speed from the gap). U. Weidmann, Transporttechnik der Fussgaenger, ETH Zurich, 1993.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import msgspec

from intellwheels_agents.chair import Odometry, powers, wrapped
from intellwheels_agents.footprint import Footprint, Moving
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path import Point
from intellwheels_agents.surroundings import distance, outline
from intellwheels_schemas.messages import Actions, Goal, Measures, Proximity, Robot

CONES = 48
"""Cones all round. With half as many, people beside each other seem to stand in each other's way."""
RING_STEP = math.tau / CONES
SIGHT = 5.0
"""Metres it looks."""
EYE = 0.4
"""Metres over the floor it looks at: legs, footrests, bumpers."""
LIKED = 1.34
"""Metres a second, v0."""
RELAXATION = 0.5
"""Seconds, tau."""
POTENTIAL = 2.1
"""Square metres per square second, V."""
REACH = 0.3
"""Metres, s."""
STEP = 1.5
"""Seconds of somebody else's walk that are reckoned with."""
HALF_DEPTH = 0.2
"""Metres from the surface of a person to its middle."""
BEHIND = 0.1
"""Share by which what is out of sight is felt."""
SIGHT_ANGLE = math.radians(100.0)
"""What lies further than this off the way is out of sight."""
TO_THE_RIGHT = math.radians(5.0)
"""What is no further than this to the right is straight ahead."""
TRACKING = 0.3
"""Seconds over which the motion of a thing is smoothed."""
SAME = 0.3
"""Metres by which a thing may seem to move in a cycle."""
HEADWAY = 0.25
"""Seconds the gap ahead lasts at least."""
EASE_GAP = 0.7
"""Metres by which somebody who walks in front may be nearer: he walks on meanwhile. Fitted, as the next."""
EASE = 1.2
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
DODGE = 1.0
"""Seconds before somebody runs into it at which it gets out of the way."""
ARM = 1.5
"""Metres within which it looks at where it steps."""
STILL = 0.05
"""Metres a second that are not worth a step."""
FASTEST = 1.3
"""Most, in shares of the speed it likes."""


def equip(robot: Robot, _options: Options) -> Robot:
    """Return the robot with the ring of cones in place of its own proximity sensors."""
    width = 360.0 / CONES
    ring = tuple(
        Proximity(
            id=f"ring-{i}",
            x=0.0,
            y=0.0,
            z=EYE,
            direction_deg=math.remainder(i * width, 360.0),
            cone_deg=width,
            max_range=SIGHT,
        )
        for i in range(CONES)
    )
    return msgspec.structs.replace(robot, proximity=ring)


class Thing(NamedTuple):
    """Somebody or something near, in the map's frame.

    Attributes:
        x, y: Its nearest point.
        metres: To that point.
        bearing: Of that point.
        velocity_x, velocity_y: Of that point, m/s.
    """

    x: float
    y: float
    metres: float
    bearing: float
    velocity_x: float = 0.0
    velocity_y: float = 0.0

    def off(self, other: Thing) -> float:
        """Return how far the nearest point moved, m; a point on the next cone moved by nothing."""
        turned = max(abs(wrapped(self.bearing - other.bearing)) - RING_STEP, 0.0)
        return abs(self.metres - other.metres) + self.metres * turned


class Mind:
    """Walks."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        if not robot.encoders or len(robot.proximity) < CONES:
            raise OptionError("mind person: expected a robot with encoders and the ring of cones, got one without")
        self._robot = robot
        self._speed = options.number("speed", LIKED, STILL, 5.0)
        self._within = options.number("within", 0.4, 0.01, 10.0)
        self._loop = options.flag("loop")
        self._goals = context.way()
        self._next = 0
        self._pose = Odometry(robot, context.position)
        self._velocity = (0.0, 0.0)
        self._things: list[Thing] = []
        self._period = context.parameters.period
        self._ring = {sensor.id: (i, sensor) for i, sensor in enumerate(robot.proximity)}
        self._bearings = [math.radians(sensor.direction_deg) for sensor in robot.proximity]
        self._ranges = [math.inf] * len(self._bearings)
        body = outline(robot)
        self._side = body.side
        self._footprint = Footprint(body)
        self._extents = [_extent(body.front, body.side, bearing) for bearing in self._bearings]

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that follow the force."""
        pose = self._pose
        was_x, was_y = pose.x, pose.y
        pose.update(measures.sensors)
        self._look(measures)
        speed = math.dist((was_x, was_y), (pose.x, pose.y)) / self._period
        self._notice()
        goal = self._goal()
        wanted_x = wanted_y = 0.0
        if goal is not None:
            share = self._speed / max(math.dist(goal, (pose.x, pose.y)), 1e-9)
            wanted_x, wanted_y = share * (goal[0] - pose.x), share * (goal[1] - pose.y)
        push_x, push_y = self._push(wanted_x, wanted_y, speed)
        x, y = self._velocity
        share = self._period / RELAXATION
        x += share * (wanted_x - x) + self._period * push_x
        y += share * (wanted_y - y) + self._period * push_y
        fast = math.hypot(x, y) / (FASTEST * max(self._speed, LIKED))
        if fast > 1.0:
            x, y = x / fast, y / fast
        self._velocity = (x, y)
        left, right = self._walk(x, y)
        if goal is None:
            return Actions(left_motor=left, right_motor=right, mode="arrived")
        return Actions(left_motor=left, right_motor=right, mode="walking", goal=Goal(x=goal[0], y=goal[1]))

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

    def _look(self, measures: Measures) -> None:
        if measures.sensors is None:
            return
        for reading in measures.sensors.proximity:
            entry = self._ring.get(reading.id)
            if entry is not None:
                i, sensor = entry
                metres = distance(reading, sensor)
                if metres is not None:
                    self._ranges[i] = metres

    def _notice(self) -> None:
        """Find the things in the ring, and how they move."""
        ranges, count, pose = self._ranges, len(self._ranges), self._pose
        known, self._things = self._things, []
        for i, metres in enumerate(ranges):
            before, after = ranges[i - 1], ranges[(i + 1) % count]
            # Of two cones that see one thing at their common edge the first is it.
            if not (metres < before and metres <= after) or metres > SIGHT:
                continue
            bearing = wrapped(pose.heading + self._bearings[i] + (math.pi / count if metres == after else 0.0))
            x, y = pose.x + metres * math.cos(bearing), pose.y + metres * math.sin(bearing)
            thing = Thing(x, y, metres, bearing)
            last = min(known, key=thing.off, default=None)
            if last is not None and thing.off(last) < SAME:
                share = self._period / TRACKING
                vx, vy = last.velocity_x, last.velocity_y
                vx += (x - last.x) / TRACKING - share * vx
                vy += (y - last.y) / TRACKING - share * vy
                thing = thing._replace(velocity_x=vx, velocity_y=vy)
            self._things.append(thing)

    def _push(self, wanted_x: float, wanted_y: float, speed: float) -> tuple[float, float]:
        """Return the sum of the forces of what is near, m/s2, in the map's frame."""
        walks = wanted_x != 0.0 or wanted_y != 0.0
        heading = self._pose.heading
        way = math.atan2(wanted_y, wanted_x) if walks else heading
        own_x, own_y = speed * math.cos(heading), speed * math.sin(heading)
        push_x = push_y = 0.0
        for thing in self._things:
            off = wrapped(thing.bearing - way)
            force, away_x, away_y = repulsion(thing, own_x, own_y)
            if walks and abs(off) > SIGHT_ANGLE:
                force *= BEHIND
            to_x, to_y = math.cos(thing.bearing), math.sin(thing.bearing)
            closing = (self._velocity[0] - thing.velocity_x) * to_x + (self._velocity[1] - thing.velocity_y) * to_y
            if walks and closing > 0.0 and abs(off) < math.pi / 2.0:
                # Round it, on the side it is not: the right for what is straight ahead. The ellipse's own side
                # changes with what is seen of the thing, and would lead to and fro.
                away_x, away_y = -to_x, -to_y
                beside = way + math.copysign(math.pi / 2.0, -off - TO_THE_RIGHT)
                aside = force * math.cos(off) * min(closing / self._speed, 1.0)
                push_x += aside * math.cos(beside)
                push_y += aside * math.sin(beside)
            push_x += force * away_x
            push_y += force * away_y
        return push_x, push_y

    def _gap(self) -> float:
        """Return metres to what it would walk into, infinite if there is nothing."""
        gap = math.inf
        for bearing, metres, extent in zip(self._bearings, self._ranges, self._extents, strict=True):
            if abs(bearing) < math.pi / 2.0 and metres * abs(math.sin(bearing)) < self._side:
                gap = min(gap, (metres - extent) * math.cos(bearing))
        return max(gap, 0.0)

    def _walk(self, x: float, y: float) -> tuple[float, float]:
        """Return the powers that turn to a velocity and walk at it as far as there is room."""
        speed, heading = math.hypot(x, y), self._pose.heading
        forward = turn_rate = 0.0
        if speed >= STILL:
            off = wrapped(math.atan2(y, x) - heading)
            turn_rate = min(max(TURNING * off, -TURN_RATE), TURN_RATE)
            gap = self._gap()
            forward = min(speed * max(math.cos(off), 0.0), gap / HEADWAY, (gap + EASE_GAP) / EASE)
        near = self._near()
        if self._footprint.free_of_moving(near, 0.0, 0.0, DODGE, MARGIN) < DODGE:
            return powers(self._robot, *self._dodge(near, forward, turn_rate))
        still = [(x, y) for x, y, _, _ in near]
        # As it would, or straight on, or on the spot, or back to where there is room to turn.
        for ahead, turn in ((forward, turn_rate), (forward, 0.0), (0.0, turn_rate), (-BACKWARD, 0.0)):
            share = self._footprint.free(still, ahead, turn, AHEAD, MARGIN) / AHEAD
            if share > 0.5:
                return powers(self._robot, ahead * share, turn * share)
        return 0.0, 0.0

    def _near(self) -> list[Moving]:
        """Return what is near as points in its own frame, each with the velocity of its thing."""
        c, s = math.cos(self._pose.heading), math.sin(self._pose.heading)
        found: list[Moving] = []
        for bearing, metres in zip(self._bearings, self._ranges, strict=True):
            if metres > ARM:
                continue
            in_map = bearing + self._pose.heading
            thing = min(self._things, key=lambda thing: abs(wrapped(thing.bearing - in_map)), default=None)
            vx, vy = (0.0, 0.0) if thing is None else (thing.velocity_x, thing.velocity_y)
            found.append((metres * math.cos(bearing), metres * math.sin(bearing), c * vx + s * vy, c * vy - s * vx))
        return found

    def _dodge(self, near: list[Moving], forward: float, turn_rate: float) -> tuple[float, float]:
        """Return the speed and turn rate that keep longest out of the way of who runs into it."""
        best, longest = (forward, turn_rate), -1.0
        hurry = FASTEST * self._speed
        for ahead, turn in (
            (forward, turn_rate), (hurry, 0.0), (-BACKWARD, 0.0), (hurry / 2.0, 2.0), (hurry / 2.0, -2.0),
            (-BACKWARD, 2.0), (-BACKWARD, -2.0), (0.0, 0.0),
        ):  # fmt: skip
            time = self._footprint.free_of_moving(near, ahead, turn, DODGE, MARGIN)
            if time > longest:
                best, longest = (ahead, turn), time
        return best


def _extent(front: float, side: float, bearing: float) -> float:
    """Return metres from the middle of a box to its edge in a direction."""
    c, s = abs(math.cos(bearing)), abs(math.sin(bearing))
    return min(front / c if c > 1e-9 else math.inf, side / s if s > 1e-9 else math.inf)


def repulsion(thing: Thing, own_x: float, own_y: float) -> tuple[float, float, float]:
    """Return the force of a thing, m/s2, and the unit vector of its direction."""
    middle = thing.metres + HALF_DEPTH
    x, y = -middle * math.cos(thing.bearing), -middle * math.sin(thing.bearing)
    step_x, step_y = STEP * (thing.velocity_x - own_x), STEP * (thing.velocity_y - own_y)
    later_x, later_y = x - step_x, y - step_y
    later = max(math.hypot(later_x, later_y), 1e-6)
    half_axis = math.sqrt(max((middle + later) ** 2 - step_x**2 - step_y**2, 0.0)) / 2.0
    force = POTENTIAL / REACH * math.exp(-half_axis / REACH)
    # The normal of the ellipse halves the angle to its two foci.
    away_x, away_y = x / middle + later_x / later, y / middle + later_y / later
    length = math.hypot(away_x, away_y)
    if length < 0.05:
        # On the way of the thing: to the right, seen by it.
        step = max(math.hypot(step_x, step_y), 1e-6)
        return force, step_y / step, -step_x / step
    return force, away_x / length, away_y / length
