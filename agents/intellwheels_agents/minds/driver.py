"""A model of a person who drives by joystick and sees the chair, for repeatable runs of manual driving.

    points     "x y x y": corners of the path that the person intends, in the coordinates of the map's site, m
    to         places of the map; the path goes through points, then these; at least one of the two options is required
    speed      intended speed on straight stretches, m/s (default 0.6)
    reaction   delay from seeing to moving the hand, s (default 0.3)
    tremor     standard deviation of the hand tremor, in full deflections (default 0.05)
    tremor_hz  frequency of the tremor, Hz (default 5)
    within     distance from the end that counts as arrived, m (default 0.2)

A person who drives by hand sees the chair and the room, not an odometry estimate. So the model's eyes are a truth
sensor, which the simulation must allow. The person aims at a point ahead on the path; the hand follows after the
reaction time, with tremor on both axes. There is no collision avoidance.

The noise of the tremor comes from the simulation, so it follows from the seed of the run like all noise. The mind adds
a GPS receiver to its robot and uses only its error, with a standard deviation of 1 m on each axis, as the source of
random numbers.

The defaults of the hand are chosen, not measured. The reaction time is in the range of the delays in quasi-linear
models of a person who tracks a target (McRuer and Jex 1967, A review of quasi-linear pilot models, IEEE Transactions on
Human Factors in Electronics 8); the frequency is in the range reported for pathological tremors. A study should set its
own.
"""

from __future__ import annotations

import math
from collections import deque

import msgspec

from intellwheels_agents.differential_drive import Odometry, powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path_follower import PathFollower
from intellwheels_agents.portable_math import cos, dist, power
from intellwheels_agents.pure_pursuit import Path, Point
from intellwheels_schemas.messages import GPS, Actions, Measures, Robot, Truth

HAND = "hand"
"""Id of the GPS receiver whose error is the noise of the hand."""


def equip(robot: Robot, options: Options) -> Robot:  # noqa: ARG001 - the signature of `Equip`
    """Return the robot with the person's eyes (a truth sensor) and the noise of the hand (a GPS receiver)."""
    return msgspec.structs.replace(robot, truth=(Truth(id="eyes"),), gps=(*robot.gps, GPS(id=HAND, noise=1.0)))


class Mind:
    """Steers along a path by sight."""

    def __init__(self, context: Context) -> None:
        options = context.options
        self._robot = context.robot
        self._pilot = PathFollower(options.number("speed", 0.6, 0.05, 5.0))
        self._within = options.number("within", 0.2, 0.01, 10.0)
        period = context.parameters.period
        delay = round(options.number("reaction", 0.3, 0.0, 5.0) / period)
        self._hand: deque[tuple[float, float]] = deque([(0.0, 0.0)] * delay)
        tremor, frequency = options.number("tremor", 0.05, 0.0, 1.0), options.number("tremor_hz", 5.0, 0.1, 20.0)
        self._forward, self._turn = (Tremor(tremor, frequency, period) for _ in range(2))
        points: list[Point] = [(context.position.x, context.position.y), *context.points("points")]
        points += [(place.x, place.y) for place in (context.place(name, "to") for name in options.words("to"))]
        if len(points) == 1:
            raise OptionError("options: expected at least one of points and to, got none")
        self._path = Path(points)
        self._seen = Odometry(context.robot, context.position)
        self._arrived = False

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that the hand gives."""
        truth = measures.sensors.truth if measures.sensors else ()
        if truth:
            self._seen.x, self._seen.y, self._seen.heading = truth[0].x, truth[0].y, truth[0].heading
        self._hand.append(self._intended())
        left, right = self._hand.popleft()
        self._arrived = self._arrived or dist((self._seen.x, self._seen.y), self._path.end) <= self._within
        if self._arrived:
            return Actions(left_motor=0.0, right_motor=0.0, mode="arrived")
        forward, turn = self._tremor(measures)
        return Actions(left_motor=left + forward - turn, right_motor=right + forward + turn, mode="manual")

    def _tremor(self, measures: Measures) -> tuple[float, float]:
        """Return the tremor on both axes, in full deflections."""
        found = [reading for reading in measures.sensors.gps if reading.id == HAND] if measures.sensors else []
        if not found or found[0].x is None or found[0].y is None:
            return self._forward.next(0.0), self._turn.next(0.0)
        return self._forward.next(found[0].x - self._seen.x), self._turn.next(found[0].y - self._seen.y)

    def _intended(self) -> tuple[float, float]:
        path, seen = self._path, self._seen
        path.update(seen.x, seen.y)
        steering = self._pilot.steer(path, seen, path.remaining)
        rate = steering.turn_rate if steering.turns else steering.speed * steering.curvature
        return powers(self._robot, steering.speed, rate)


class Tremor:
    """The tremor of a hand on one axis: white noise through a resonance.

    Args:
        size: Standard deviation, in full deflections.
        frequency: Frequency of the resonance, Hz, less than half the sampling rate.
        period: Sampling period, s.
    """

    DAMPING = 0.9
    """Radius of the poles of the resonance at 20 samples a second: it loses its phase in half a second."""

    def __init__(self, size: float, frequency: float, period: float) -> None:
        radius = power(self.DAMPING, period / 0.05)
        self._a1, self._a2 = 2.0 * radius * cos(2.0 * math.pi * frequency * period), -radius * radius
        # The variance of x = a1 x' + a2 x'' + e is (1 - a2) / ((1 + a2) ((1 - a2)^2 - a1^2)) times that of e.
        rest = 1.0 - self._a2
        gain = rest / ((1.0 + self._a2) * (rest * rest - self._a1 * self._a1))
        self._size = size / math.sqrt(gain)
        self._last = self._before = 0.0

    def next(self, noise: float) -> float:
        """Return the next deflection; `noise` has standard deviation 1."""
        new = self._a1 * self._last + self._a2 * self._before + self._size * noise
        self._last, self._before = new, self._last
        return new
