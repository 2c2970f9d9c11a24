"""Drives along a road and gives way to anybody who is on it or about to step onto it.

    points   "x y x y": corners of the path after the start, in the coordinates of the map's site, m
    via, to  places of the map; the path goes through points, then via in their order, then to; at least one of the
             three options is required
    speed    speed on the free road, m/s (default 5.0)
    clear    distance beside the car within which somebody counts as on the road, m (default 1.5)
    within   distance from the end that counts as arrived, m (default 0.5)

The car accelerates and brakes by the Intelligent Driver Model:

    dv/dt = a (1 - (v / v0)^4 - (s' / s)^2),  s' = s0 + v T + v u / (2 sqrt(a b))

Here v is the speed, v0 the option `speed`, s the distance to the nearest obstacle ahead, and u the speed at which the
car approaches it. The acceleration a is 1.5 m/s2, the comfortable braking b 2.0 m/s2, the gap at a standstill s0 2.0 m,
and the time gap T 1.5 s. The car never brakes harder than 6 m/s2. The obstacle is assumed to stand still (u = v), since
people cross the road and do not move along it. The car looks with a fan of proximity cones that turns with it, so it
takes bends slowly.

Source: M. Treiber, A. Hennecke, D. Helbing, Congested traffic states in empirical observations and microscopic
simulations, Phys. Rev. E 62, 2000.
"""

from __future__ import annotations

import math

import msgspec

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.portable_math import atan2, dist, sin, sincos
from intellwheels_agents.pure_pursuit import path_of
from intellwheels_agents.range_scan import SENSOR_HEIGHT, distance, outline
from intellwheels_schemas.messages import Actions, Goal, Measures, Proximity, Robot

CONES = 25
CONE_DEG = 3.0
"""Angle of a cone, degrees: narrow, so that a wall along the road does not seem to be on it."""
RANGE = 40.0
"""Range of the cones, m."""
ACCELERATION = 1.5
"""a, m/s2."""
COMFORTABLE_BRAKING = 2.0
"""b, m/s2."""
HARDEST_BRAKING = 6.0
"""Limit of the deceleration, m/s2."""
STANDSTILL_GAP = 2.0
"""s0, m."""
TIME_HEADWAY = 1.5
"""T, s."""
LATERAL_ACCELERATION = 1.5
"""Limit of the lateral acceleration in a bend, m/s2."""
TURNING_RADIUS = 4.5
"""Smallest turning radius, m."""


def equip(robot: Robot, _options: Options) -> Robot:
    """Return the robot with the fan of cones instead of its own proximity sensors."""
    front = outline(robot).front
    fan = tuple(
        Proximity(
            id=f"fan-{i}",
            x=front,
            y=0.0,
            z=SENSOR_HEIGHT,
            direction_deg=(i - CONES // 2) * CONE_DEG,
            cone_deg=CONE_DEG,
            max_range=RANGE,
        )
        for i in range(CONES)
    )
    return msgspec.structs.replace(robot, proximity=fan)


class Mind:
    """Drives along its path."""

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
        self._fan = {sensor.id: (sensor, *sincos(math.radians(sensor.direction_deg))) for sensor in robot.proximity}
        self._speed = 0.0

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that follow the path and stop before anybody who is on it."""
        pose, path = self._pose, self._path
        pose.update(measures.sensors)
        if path is not None:
            path.update(pose.x, pose.y)
        if path is None or path.remaining <= self._within:
            self._speed = 0.0
            return Actions(left_motor=0.0, right_motor=0.0, mode="arrived")
        x, y = path.ahead(max(3.0, self._speed))
        bearing = wrapped(atan2(y - pose.y, x - pose.x) - pose.heading)
        curvature = 2.0 * sin(bearing) / max(dist((x, y), (pose.x, pose.y)), 1e-3)
        curvature = min(max(curvature, -1.0 / TURNING_RADIUS), 1.0 / TURNING_RADIUS)
        gap = self._gap(measures)
        speed = self._speed + self._period * self._acceleration(gap)
        bend = math.sqrt(LATERAL_ACCELERATION / max(abs(curvature), 1e-6))
        self._speed = max(0.0, min(speed, bend, math.sqrt(2.0 * COMFORTABLE_BRAKING * path.remaining)))
        left, right = powers(self._robot, self._speed, self._speed * curvature)
        goal = Goal(x=path.end[0], y=path.end[1])
        mode = "driving" if self._speed > 0.0 else "waiting"
        return Actions(left_motor=left, right_motor=right, mode=mode, goal=goal)

    def _acceleration(self, gap: float) -> float:
        """Return dv/dt in m/s2 for a gap to the obstacle ahead in m."""
        v = self._speed
        wanted = STANDSTILL_GAP + v * TIME_HEADWAY + v * v / (2.0 * math.sqrt(ACCELERATION * COMFORTABLE_BRAKING))
        near, free = wanted / max(gap, 1e-3), v / self._free_speed
        return max(ACCELERATION * (1.0 - free * free * free * free - near * near), -HARDEST_BRAKING)

    def _gap(self, measures: Measures) -> float:
        """Return the distance to the nearest obstacle on the road ahead, m; infinite if there is none."""
        gap = math.inf
        for reading in measures.sensors.proximity if measures.sensors else ():
            entry = self._fan.get(reading.id)
            metres = None if entry is None else distance(reading, entry[0])
            if entry is None or metres is None or math.isinf(metres):
                continue
            sensor, s, c = entry
            across = sensor.y + metres * s
            if abs(across) < self._half_width:
                gap = min(gap, metres * c)
        return gap
