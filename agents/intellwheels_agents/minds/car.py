"""Drives along a road and gives way to who is on it, or is about to be.

    points   "x y x y": corners of the way after the start, in metres
    via, to  places of the map; the way goes points, then via in their order, then to
    speed    metres a second on the free road (default 5.0)
    clear    metres beside it within which somebody is on the road (default 1.5)
    within   metres from the end that count as there (default 0.5)

    dv/dt = a (1 - (v / v0)^4 - (s' / s)^2),  s' = s0 + v T + v dv / (2 sqrt(a b))

the Intelligent Driver Model with s metres to what is ahead, which it reckons to stand still (dv = v): who crosses a
road does not drive along it. It looks by a fan of proximity cones, which turns with it, so it takes bends slowly.

Source: M. Treiber, A. Hennecke, D. Helbing, Congested traffic states in empirical observations and microscopic
simulations, Phys. Rev. E 62, 2000.
"""

from __future__ import annotations

import math

import msgspec

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.pure_pursuit import path_of
from intellwheels_agents.range_scan import distance, outline
from intellwheels_schemas.messages import Actions, Goal, Measures, Proximity, Robot

CONES = 25
CONE_DEG = 3.0
"""Narrow, so that a wall along the road is not on it."""
SIGHT = 40.0
"""Metres it looks."""
EYE = 0.4
"""Metres over the road it looks at."""
ACCELERATION = 1.5
"""Metres a second squared, a."""
COMFORT = 2.0
"""Metres a second squared at which it likes to brake, b."""
HARDEST = 6.0
"""Metres a second squared at most, braking."""
STANDOFF = 2.0
"""Metres, s0."""
HEADWAY = 1.5
"""Seconds, T."""
BEND = 1.5
"""Metres a second squared to the side, in a bend."""
TIGHTEST = 4.5
"""Metres: the least radius."""


def equip(robot: Robot, _options: Options) -> Robot:
    """Return the robot with the fan of cones in place of its own proximity sensors."""
    front = outline(robot).front
    fan = tuple(
        Proximity(
            id=f"fan-{i}",
            x=front,
            y=0.0,
            z=EYE,
            direction_deg=(i - CONES // 2) * CONE_DEG,
            cone_deg=CONE_DEG,
            max_range=SIGHT,
        )
        for i in range(CONES)
    )
    return msgspec.structs.replace(robot, proximity=fan)


class Mind:
    """Drives its way."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        if not robot.encoders:
            raise OptionError("mind car: expected a robot with encoders, got one without")
        self._robot = robot
        self._free_speed = options.number("speed", 5.0, 0.1, 50.0)
        self._half_width = outline(robot).side + options.number("clear", 1.5, 0.0, 10.0)
        self._within = options.number("within", 0.5, 0.01, 10.0)
        self._path = path_of(context)
        self._pose = Odometry(robot, context.position)
        self._period = context.parameters.period
        self._fan = {sensor.id: (sensor, math.radians(sensor.direction_deg)) for sensor in robot.proximity}
        self._speed = 0.0

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that keep to the way and stop before who is on it."""
        pose, path = self._pose, self._path
        pose.update(measures.sensors)
        if path is not None:
            path.update(pose.x, pose.y)
        if path is None or path.left <= self._within:
            self._speed = 0.0
            return Actions(left_motor=0.0, right_motor=0.0, mode="arrived")
        x, y = path.ahead(max(3.0, self._speed))
        bearing = wrapped(math.atan2(y - pose.y, x - pose.x) - pose.heading)
        curvature = 2.0 * math.sin(bearing) / max(math.dist((x, y), (pose.x, pose.y)), 1e-3)
        curvature = min(max(curvature, -1.0 / TIGHTEST), 1.0 / TIGHTEST)
        gap = self._gap(measures)
        speed = self._speed + self._period * self._acceleration(gap)
        bend = math.sqrt(BEND / max(abs(curvature), 1e-6))
        self._speed = max(0.0, min(speed, bend, math.sqrt(2.0 * COMFORT * path.left)))
        left, right = powers(self._robot, self._speed, self._speed * curvature)
        goal = Goal(x=path.end[0], y=path.end[1])
        mode = "driving" if self._speed > 0.0 else "waiting"
        return Actions(left_motor=left, right_motor=right, mode=mode, goal=goal)

    def _acceleration(self, gap: float) -> float:
        """Return dv/dt, m/s2, for `gap` metres to what is ahead."""
        v = self._speed
        wanted = STANDOFF + v * HEADWAY + v * v / (2.0 * math.sqrt(ACCELERATION * COMFORT))
        near = (wanted / max(gap, 1e-3)) ** 2
        return max(ACCELERATION * (1.0 - (v / self._free_speed) ** 4 - near), -HARDEST)

    def _gap(self, measures: Measures) -> float:
        """Return metres to the nearest that is on the road ahead, infinite if there is nothing."""
        gap = math.inf
        for reading in measures.sensors.proximity if measures.sensors else ():
            entry = self._fan.get(reading.id)
            metres = None if entry is None else distance(reading, entry[0])
            if entry is None or metres is None or math.isinf(metres):
                continue
            across = entry[0].y + metres * math.sin(entry[1])
            if abs(across) < self._half_width:
                gap = min(gap, metres * math.cos(entry[1]))
        return gap
