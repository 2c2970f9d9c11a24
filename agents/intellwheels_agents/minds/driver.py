"""A model of a person who drives by joystick and sees the chair, for repeatable runs of manual driving.

    points     "x y x y": corners of the path that the person intends, in the coordinates of the map's site, m
    to         places of the map; the path goes through points, then these; at least one of the two options is required
    speed      intended speed on straight stretches, m/s (default 0.6)
    reaction   delay from seeing to moving the hand, s (default 0.3)
    tremor     standard deviation of the hand tremor, in full deflections (default 0.05)
    tremor_hz  frequency of the tremor, Hz (default 5)
    within     distance from the end that counts as arrived, m (default 0.2)
    eyes       truth: the person knows the pose exactly; glances: the person judges it, with an error (default truth)
    glance     time between two glances, s (default 0.3)
    glance_m   standard deviation of the position that a glance gives, on each axis, m (default 0.1)
    glance_deg standard deviation of the heading that a glance gives, degrees (default 3)

The person aims at a point ahead on the path; the hand follows after the reaction time, with tremor on both axes. There
is no collision avoidance.

With `eyes=truth`, a truth sensor gives the pose, which the simulation must allow. With `eyes=glances` the mind gets no
true pose. A glance gives position and heading with independent errors. Between glances the person feels how the chair
moves, as wheel encoders measure it. What a glance shows counts for 0.3 against what the person believed before; the
first glances count more. So the believed position is wrong by 0.42 of the error of a glance, for about a second at a
time, whatever the period of the simulation.

All noise comes from the simulation, so it follows from the seed of the run. The mind adds a GPS receiver to its robot
and uses only its error, with a standard deviation of 1 m on each axis, as the source of random numbers for the tremor.
With `eyes=glances` it adds a GPS receiver and a compass for the glances, and encoders to a robot without any.

The defaults of glances and hand are chosen, not measured. The reaction time is in the range of the delays in
quasi-linear models of a person who tracks a target (McRuer and Jex 1967, A review of quasi-linear pilot models, IEEE
Transactions on Human Factors in Electronics 8); the frequency is in the range reported for pathological tremors. A
study should set its own.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

import msgspec

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path_follower import PathFollower
from intellwheels_agents.portable_math import cos, dist, power, sincos
from intellwheels_agents.pure_pursuit import Path, Point
from intellwheels_schemas.messages import GPS, Actions, Compass, Encoders, Measures, Position, Robot, Sensors, Truth

HAND = "hand"
"""Id of the GPS receiver whose error is the noise of the hand."""
GLANCE, TURNED, FELT = "glance", "glance-heading", "felt"
"""Ids of the sensors of a person who judges the pose: position, heading, and the encoders if the robot has none."""
SHARE: Final = 0.3
"""What a glance counts against what the person believed before. Chosen."""


class Eyes(NamedTuple):
    """How a person sees the pose: exactly (None), or by glances with an error on position (m) and heading (degrees)."""

    errors: tuple[float, float] | None
    pause: float

    @classmethod
    def of(cls, options: Options) -> Eyes:
        """Read the options."""
        exact = options.choice("eyes", ("truth", "glances"), "truth") == "truth"
        pause = options.number("glance", 0.3, 0.0, 10.0)
        errors = options.number("glance_m", 0.1, 0.0, 10.0), options.number("glance_deg", 3.0, 0.0, 90.0)
        return cls(None if exact else errors, pause)


def equip(robot: Robot, options: Options) -> Robot:
    """Return the robot with the person's eyes (a truth sensor, or what gives glances) and the noise of the hand."""
    eyes, hand = Eyes.of(options), (*robot.gps, GPS(id=HAND, noise=1.0))
    if eyes.errors is None:
        return msgspec.structs.replace(robot, truth=(Truth(id="eyes"),), gps=hand)
    place, heading = eyes.errors
    felt = robot.encoders or (() if robot.odometry else (Encoders(id=FELT),))
    return msgspec.structs.replace(
        robot,
        gps=(*hand, GPS(id=GLANCE, noise=place)),
        compass=(*robot.compass, Compass(id=TURNED, noise_deg=heading)),
        encoders=felt,
    )


class Mind:
    """Steers along a path by sight.

    Attributes:
        seen: The pose as the person sees it.
    """

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
        eyes = Eyes.of(options)
        self._glances = None if eyes.errors is None else Glances(context.robot, context.position, eyes.pause, period)
        self.seen = Odometry(context.robot, context.position) if self._glances is None else self._glances.believed
        self._arrived = False

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that the hand gives."""
        truth = measures.sensors.truth if measures.sensors else ()
        if self._glances is not None:
            self._glances.update(measures.sensors)
        elif truth:
            self.seen.x, self.seen.y, self.seen.heading = truth[0].x, truth[0].y, truth[0].heading
        self._hand.append(self._intended())
        left, right = self._hand.popleft()
        self._arrived = self._arrived or dist((self.seen.x, self.seen.y), self._path.end) <= self._within
        if self._arrived:
            return Actions(left_motor=0.0, right_motor=0.0, mode="arrived")
        forward, turn = self._tremor(measures)
        return Actions(left_motor=left + forward - turn, right_motor=right + forward + turn, mode="manual")

    def _tremor(self, measures: Measures) -> tuple[float, float]:
        """Return the tremor on both axes, in full deflections."""
        found = [reading for reading in measures.sensors.gps if reading.id == HAND] if measures.sensors else []
        if not found or found[0].x is None or found[0].y is None:
            return self._forward.next(0.0), self._turn.next(0.0)
        return self._forward.next(found[0].x - self.seen.x), self._turn.next(found[0].y - self.seen.y)

    def _intended(self) -> tuple[float, float]:
        path, seen = self._path, self.seen
        path.update(seen.x, seen.y)
        steering = self._pilot.steer(path, seen, path.remaining)
        rate = steering.turn_rate if steering.turns else steering.speed * steering.curvature
        return powers(self._robot, steering.speed, rate)


class Glances:
    """Where a person believes to be, from glances and from what the person feels between them.

    Attributes:
        believed: The believed pose.
    """

    def __init__(self, robot: Robot, start: Position, pause: float, period: float) -> None:
        """Take the body, where it starts, and the time between two glances and between two updates, s."""
        self.believed = Odometry(robot, start)
        self._felt = Odometry(robot, start, compass_share=0.0)
        self._every = max(1, round(pause / period))
        self._ticks = self._count = 0

    def update(self, sensors: Sensors | None) -> None:
        """Take the readings of a tick; of glances, only those that are due."""
        believed, felt = self.believed, self._felt
        x, y, heading = felt.x, felt.y, felt.heading
        felt.update(sensors)
        # What was felt is turned from the felt heading to the believed one.
        s, c = sincos(believed.heading - heading)
        dx, dy = felt.x - x, felt.y - y
        believed.x, believed.y = believed.x + c * dx - s * dy, believed.y + s * dx + c * dy
        believed.heading = wrapped(believed.heading + felt.heading - heading)
        self._ticks += 1
        if sensors is None or (self._ticks - 1) % self._every:
            return
        self._count += 1
        share = max(SHARE, 1.0 / self._count)
        for place in sensors.gps:
            if place.id == GLANCE and place.x is not None and place.y is not None:
                believed.x += share * (place.x - believed.x)
                believed.y += share * (place.y - believed.y)
        for turned in sensors.compass:
            if turned.id == TURNED and turned.value is not None:
                believed.heading = wrapped(believed.heading + share * wrapped(turned.value - believed.heading))


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
