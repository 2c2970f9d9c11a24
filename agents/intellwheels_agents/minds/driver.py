"""A person at the joystick who sees where the chair is, for runs by hand that are repeated.

    points   "x y x y": corners of the way the person means to take, in metres
    to       the place of the map where it ends
    speed    metres a second meant on the straight (default 0.6)
    reaction seconds from what is seen to what the hand does (default 0.3)
    tremor   standard deviation of the hand, in full deflections (default 0.05)
    tremor_hz  its frequency (default 5)
    within   metres from the end that count as there (default 0.2)

The eyes are a truth sensor, so the simulation must allow it: a person who drives by hand sees the chair and the floor,
not a pose that wheels tell. What is seen is a point ahead on the way; what the hand does follows later by the reaction
time, with the tremor on both axes. Nothing looks after the person: what is touched is touched.

The tremor's noise is the simulation's own, so that it follows from the seed of the run as all noise does: a receiver
that tells the place with an error of standard deviation 1 on each axis, less the true place.

Of the three figures of the hand all defaults are chosen, not measured: the reaction, of the size of the delays that
quasi-linear models of a person who tracks what he sees have (McRuer and Jex 1967, A review of quasi-linear pilot
models, IEEE
Transactions on Human Factors in Electronics 8); the tremor's size; and its frequency, among those that are told of
pathological tremors. A study takes its own.
"""

from __future__ import annotations

import math
from collections import deque

import msgspec

from intellwheels_agents.differential_drive import Odometry, powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path_follower import PathFollower
from intellwheels_agents.pure_pursuit import Path, Point
from intellwheels_schemas.messages import GPS, Actions, Measures, Robot, Truth

HAND = "hand"
"""The receiver whose error is the noise of the hand."""


def equip(robot: Robot, options: Options) -> Robot:  # noqa: ARG001 - as `Equip` has it
    """Return the robot with the person's eyes and the unrest of the hand."""
    return msgspec.structs.replace(robot, truth=(Truth(id="eyes"),), gps=(*robot.gps, GPS(id=HAND, noise=1.0)))


class Mind:
    """Steers along a way that is seen."""

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
        points: list[Point] = [(context.position.x, context.position.y), *options.points("points")]
        points += [(place.x, place.y) for place in (context.place(name, "to") for name in options.words("to"))]
        if len(points) == 1:
            raise OptionError("option points: expected points or to, got none")
        self._path = Path(points)
        self._eyes = Odometry(context.robot, context.position)
        self._there = False

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that the hand gives."""
        seen = measures.sensors.truth if measures.sensors else ()
        if seen:
            self._eyes.x, self._eyes.y, self._eyes.heading = seen[0].x, seen[0].y, seen[0].heading
        self._hand.append(self._meant())
        left, right = self._hand.popleft()
        self._there = self._there or math.dist((self._eyes.x, self._eyes.y), self._path.end) <= self._within
        if self._there:
            return Actions(left_motor=0.0, right_motor=0.0, mode="arrived")
        forward, turn = self._shaken(measures)
        return Actions(left_motor=left + forward - turn, right_motor=right + forward + turn, mode="manual")

    def _shaken(self, measures: Measures) -> tuple[float, float]:
        """Return the hand's unrest on both axes."""
        found = [one for one in measures.sensors.gps if one.id == HAND] if measures.sensors else []
        if not found or found[0].x is None or found[0].y is None:
            return self._forward.next(0.0), self._turn.next(0.0)
        return self._forward.next(found[0].x - self._eyes.x), self._turn.next(found[0].y - self._eyes.y)

    def _meant(self) -> tuple[float, float]:
        path, eyes = self._path, self._eyes
        path.update(eyes.x, eyes.y)
        steering = self._pilot.steer(path, eyes, path.left)
        rate = steering.turn_rate if steering.turns else steering.speed * steering.curvature
        return powers(self._robot, steering.speed, rate)


class Tremor:
    """A hand that shakes on one axis: white noise through a resonance.

    Args:
        size: Standard deviation, in full deflections.
        frequency: Of the resonance, Hz, less than half the rate.
        period: Between samples, s.
    """

    DAMPING = 0.9
    """Radius of the resonance's poles at 20 samples a second: it loses its phase in half a second."""

    def __init__(self, size: float, frequency: float, period: float) -> None:
        radius = math.pow(self.DAMPING, period / 0.05)
        self._a1, self._a2 = 2.0 * radius * math.cos(2.0 * math.pi * frequency * period), -(radius**2)
        # Variance of x = a1 x' + a2 x'' + e: (1 - a2) / ((1 + a2) ((1 - a2)^2 - a1^2)) of that of e.
        gain = (1.0 - self._a2) / ((1.0 + self._a2) * ((1.0 - self._a2) ** 2 - self._a1**2))
        self._size = size / math.sqrt(gain)
        self._last = self._before = 0.0

    def next(self, noise: float) -> float:
        """Return the next deflection; `noise` is of standard deviation 1."""
        new = self._a1 * self._last + self._a2 * self._before + self._size * noise
        self._last, self._before = new, self._last
        return new
