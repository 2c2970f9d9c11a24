"""What a body sweeps until it stands again, and whether that stays clear of the points around it.

A command is allowed if the body can still stop afterwards: one tick of the command, `SPARE` for messages that are late,
and then the run-out of the wheels. This is passive safety: whoever keeps to it stands before anything can touch it.
To each point a motion may use up `SHARE` of the present clearance at most. That is less than half, so two bodies that
both keep to it do not meet either, though none of them knows what the other wants.

Sources:
    Fox, Burgard, Thrun (1997), The dynamic window approach to collision avoidance, IEEE Robotics and Automation
    Magazine 4(1): admissible velocities.
    Macek, Vasquez, Fraichard, Siegwart (2009), Towards safe vehicle navigation in dynamic urban scenarios, Automatika
    50: passive safety.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from intellwheels_agents.differential_drive import powers
from intellwheels_agents.portable_math import hypot, sincos
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_scan import outline
from intellwheels_agents.wheel_motors import STILL, TOLERANCE, Motors, Wheels
from intellwheels_schemas.messages import EncodersReading, Robot

MARGIN: Final = 0.06
"""Clearance that a motion keeps, m. Points stand up to 0.03 m apart on what they stand for; the rest is chosen."""
SPARE: Final = 0.05
"""Time for which a command may hold longer than a tick, s."""
STEP: Final = 0.03
"""Metres that the farthest corner moves between two checks: half the margin."""
SHARE: Final = 0.4
"""Share of the present clearance to a point that a motion may use up."""
NEAR_SHARE: Final = 0.1
"""The same below the margin, so that a body can still drive along a wall."""


class StoppingSweep:
    """Judges the motions of one body.

    Attributes:
        radius: Distance from the centre of movement to the farthest corner, m.
    """

    def __init__(self, robot: Robot, period: float) -> None:
        """Take a robot with motors, and the period of the simulation, s."""
        body = outline(robot)
        self._robot = robot
        self._front, self._back, self._side = body.front, body.back, body.side
        self.radius = hypot(max(body.front, body.back), body.side)
        self._period = period
        self._motors = Motors.of(robot, period)
        self._wheels = self._wanted = STILL
        self._counts: tuple[int, int] | None = None
        self._watched: list[tuple[float, float, float, float]] = []

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point, m, is inside the body."""
        return -self._back < x < self._front and abs(y) < self._side

    def clearance(self, x: float, y: float) -> float:
        """Return the distance from the body to a point in m, negative inside."""
        dx, dy = max(x - self._front, -self._back - x), abs(y) - self._side
        return hypot(dx, dy) if dx > 0.0 and dy > 0.0 else max(dx, dy)

    def measure(self, encoders: EncodersReading | None) -> None:
        """Estimate the wheel speeds after a tick: from the motor model, unless the encoders clearly differ."""
        self._wheels, _ = self._motors.cycle(self._wheels, self._wanted)
        if encoders is None:
            return
        counts = encoders.left, encoders.right
        if self._counts is not None:
            speed = math.pi * self._robot.wheel_diameter / self._robot.encoder_ticks / self._period
            measured = Wheels((counts[0] - self._counts[0]) * speed, (counts[1] - self._counts[1]) * speed)
            if max(abs(measured.left - self._wheels.left), abs(measured.right - self._wheels.right)) > TOLERANCE:
                self._wheels = measured
        self._counts = counts

    def watch(self, points: Iterable[Point], margin: float = MARGIN) -> None:
        """Take the points that motions must stay clear of, in the body's present frame, and the margin, m."""
        watched = []
        for x, y in points:
            clearance = self.clearance(x, y)
            if clearance > margin:
                least = max(margin, (1.0 - SHARE) * clearance)
            else:
                least = clearance - NEAR_SHARE * max(clearance, 0.0)
            watched.append((clearance - least, x, y, least))
        self._watched = sorted(watched)

    def is_free(self, speed: float, turn_rate: float) -> bool:
        """Return whether the body can obey for a tick, and then stop, and stay clear of all points.

        Args:
            speed: Forward, m/s.
            turn_rate: Anticlockwise, rad/s.
        """
        wanted = self._speeds(speed, turn_rate)
        now, (first, _) = self._wheels, self._motors.cycle(self._wheels, wanted)
        run_out = self._motors.run_out
        x = y = heading = moved = 0.0
        # The tick, the spare time at the new speeds, and the run-out: three arcs.
        arcs = [
            ((now.left + first.left) / 2.0 * self._period, (now.right + first.right) / 2.0 * self._period),
            (first.left * SPARE, first.right * SPARE),
            (run_out(first.left), run_out(first.right)),
        ]
        for left, right in arcs:
            travel, turn = (left + right) / 2.0, (right - left) / self._robot.track
            reach = abs(travel) + abs(turn) * self.radius
            pieces = math.ceil(reach / STEP)
            for _ in range(pieces):
                s, c = sincos(heading + turn / pieces / 2.0)
                x, y, heading = x + travel / pieces * c, y + travel / pieces * s, heading + turn / pieces
                moved += reach / pieces
                if not self._clear_at(x, y, heading, moved):
                    return False
        return True

    def needed(self, speed: float) -> float:
        """Return the clearance ahead that a speed, m/s, needs at most, m."""
        return ((self._period + SPARE) * speed + self._motors.run_out(speed)) / SHARE + MARGIN

    def drive(self, speed: float, turn_rate: float) -> tuple[float, float]:
        """Return the powers for a motion, and remember it as the command in force."""
        self._wanted = self._speeds(speed, turn_rate)
        return powers(self._robot, speed, turn_rate)

    def _speeds(self, speed: float, turn_rate: float) -> Wheels:
        left, right = powers(self._robot, speed, turn_rate)
        return Wheels(left * self._robot.top_speed, right * self._robot.top_speed)

    def _clear_at(self, px: float, py: float, heading: float, moved: float) -> bool:
        s, c = sincos(heading)
        front, back, side = self._front, self._back, self._side
        for slack, x, y, least in self._watched:
            if slack > moved:
                return True
            dx, dy = x - px, y - py
            along, across = c * dx + s * dy, abs(c * dy - s * dx) - side
            along = max(along - front, -back - along)
            near = math.sqrt(along * along + across * across) if along > 0.0 < across else max(along, across)
            if near < least:
                return False
        return True
