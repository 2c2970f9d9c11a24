"""How the wheels of a body follow their commands, as its robot document says, and how late the commands act.

The lag is v' = u + (v - u) k with k = a^(T / 50 ms), a the `AccelerationCurve`; the travel of a cycle is its integral.
An `AccelerationLimit` changes the speed evenly. Source: equation (1) of the IntellWheels simulator paper, and the
model of the simulated world.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from math import inf
from typing import Final, NamedTuple

from intellwheels_agents.portable_math import exp, log
from intellwheels_schemas.messages import EncodersReading, Measures, Robot

REFERENCE: Final = 0.05
"""Cycle for which `AccelerationCurve` is given, s."""
LATEST: Final = 6
"""Most ticks by which commands may act late. The contract lets a command act a tick late at best; chosen."""
TOLERANCE: Final = 0.05
"""Difference at which measured wheels override the model, m/s. The model has no quantisation, so it is preferred."""
COUNTS: Final = 2.0
"""The same in counts of an encoder in the measured time, where these are more."""
SPEED_STEP: Final = 0.02
"""Step between the speeds whose braking distances are known, m/s."""
SAME: Final = 0.0009
"""Errors that differ by less count as equal, (m/s)2: the square of 3 cm/s, the step of an encoder at 20 ms."""


class Wheels(NamedTuple):
    """Speeds of the wheels, m/s, or their travels, m."""

    left: float
    right: float


STILL: Final = Wheels(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Motors:
    """The motors of a body over one cycle.

    Attributes:
        kept: Share of a wheel's speed that is left after a cycle.
        settling: Time constant of the lag times the rest of that share, s.
        limit: Highest acceleration of a wheel, m/s2.
        period: Time of a cycle, s.
    """

    kept: float
    settling: float
    limit: float
    period: float

    @classmethod
    def of(cls, robot: Robot, period: float) -> Motors:
        """Return the motors of a robot over cycles of `period` s."""
        limit = inf if robot.acceleration_limit is None else robot.acceleration_limit
        curve = robot.acceleration_curve
        if curve <= 0.0:
            return cls(0.0, 0.0, limit, period)
        rate = -log(curve) / REFERENCE
        kept = curve if period == REFERENCE else exp(-rate * period)
        return cls(kept, (1.0 - kept) / rate, limit, period)

    def cycle(self, now: Wheels, wanted: Wheels) -> tuple[Wheels, Wheels]:
        """Return the speeds after a cycle, and the travels in it."""
        left, left_travel = self.wheel(now.left, wanted.left)
        right, right_travel = self.wheel(now.right, wanted.right)
        return Wheels(left, right), Wheels(left_travel, right_travel)

    def stopping(self, speed: float) -> float:
        """Return how far a body rolls from a speed (m/s) until it stands, m."""
        travelled, now = 0.0, Wheels(speed, speed)
        for _ in range(round(30.0 / self.period)):
            now, travel = self.cycle(now, STILL)
            travelled += travel.left
            if now.left < 0.005:
                break
        return travelled

    def run_out(self, speed: float) -> float:
        """Return how far a wheel rolls from a speed (m/s) until it stands, m: evenly at the limit, then with the lag.

        This is `stopping` in closed form, for any period and in the direction of the speed.
        """
        lag = self.settling / (1.0 - self.kept)
        fast, eased = abs(speed), self.limit * lag if self.limit < inf else inf
        if fast <= eased:
            return speed * lag
        return math.copysign((fast * fast - eased * eased) / (2.0 * self.limit) + eased * lag, speed)

    def braking_time(self, speed: float, least: float) -> float:
        """Return a time in which a wheel slows down from a speed to the least one, m/s, in s; 0 if it is slower."""
        if speed <= least:
            return 0.0
        lag = self.settling / (1.0 - self.kept) * log(speed / least) if self.kept > 0.0 else 0.0
        return lag + speed / self.limit

    def wheel(self, speed: float, wanted: float) -> tuple[float, float]:
        """Return the speed of one wheel after a cycle, m/s, and its travel, m."""
        new = (1.0 - self.kept) * wanted + self.kept * speed
        most = self.limit * self.period
        if abs(new - speed) > most:
            new = speed + most if new > speed else speed - most
            return new, 0.5 * (speed + new) * self.period
        return new, wanted * self.period + (speed - wanted) * self.settling


class SafeSpeed:
    """The speeds from which a body stops within what its sensors see."""

    def __init__(self, motors: Motors, top: float, sees: float) -> None:
        """Take the motors, the highest speed (m/s), and how far from the body the sensors see, m."""
        self._sees = sees
        self._stopping = [motors.stopping(SPEED_STEP * n) for n in range(1, int(top / SPEED_STEP) + 2)]

    def after(self, blind: float) -> float:
        """Return the highest such speed if the body drives on for `blind` s before it brakes, m/s."""
        most = SPEED_STEP
        for n, metres in enumerate(self._stopping, start=1):
            if metres + SPEED_STEP * n * blind > self._sees:
                break
            most = SPEED_STEP * n
        return most


class CommandLateness:
    """By how many ticks commands act late, measured with the wheels, and what is still to act.

    For each possible lateness the motors are simulated with the commands that were sent. The lateness is that whose
    wheels roll as the measured ones do; as long as several do, it is the longest of them.

    Attributes:
        ticks: The lateness.
        tick: The last tick whose encoders are known; None before the first.
        speeds: The speeds of the wheels at that tick: by the model, unless the encoders clearly differ, m/s.
    """

    def __init__(self, robot: Robot, period: float) -> None:
        """Take the robot and the period of the simulation, s."""
        self.ticks = LATEST
        self.tick: int | None = None
        self.speeds = STILL
        self.motors = Motors.of(robot, period)
        self._per_count = math.pi * robot.wheel_diameter / robot.encoder_ticks
        self._sent: deque[tuple[int, Wheels]] = deque(maxlen=400)
        self._models = [STILL] * (LATEST + 1)
        self._errors = [0.0] * (LATEST + 1)
        self._counts: tuple[int, int] | None = None

    def send(self, tick: int, wheels: Wheels) -> None:
        """Take the command that answers a tick."""
        self._sent.append((tick, wheels))

    def update(self, measures: Measures, encoders: EncodersReading | None) -> None:
        """Take the encoders that came with a tick; None if none did."""
        if encoders is None:
            tick = measures.tick if self.tick is None else self.tick
        else:
            tick = measures.tick if encoders.tick is None else encoders.tick
        self.tick, last = tick, tick if self.tick is None else self.tick
        if tick > last:
            travels = self._simulated(last, tick)
            self.speeds = self._models[self.ticks]
            if encoders is not None and self._counts is not None:
                self._compare(travels, encoders, (tick - last) * self.motors.period)
        if encoders is not None:
            self._counts = encoders.left, encoders.right

    def roll_on(self, measures: Measures) -> None:
        """Take a tick of a robot without encoders: its wheels roll as the model says."""
        tick, last = measures.tick, measures.tick if self.tick is None else self.tick
        self.tick = tick
        self._simulated(last, tick)
        self.speeds = self._models[self.ticks]

    def pending(self, now: int) -> list[Wheels]:
        """Return the commands that act between the last known tick and the one that answers `now`."""
        first = now if self.tick is None else self.tick
        return [self._command(step - self.ticks) for step in range(first, now + self.ticks)]

    def _simulated(self, last: int, tick: int) -> list[Wheels]:
        travels = [STILL] * (LATEST + 1)
        for step in range(last, tick):
            for late in range(LATEST + 1):
                self._models[late], rolled = self.motors.cycle(self._models[late], self._command(step - late))
                travels[late] = Wheels(travels[late].left + rolled.left, travels[late].right + rolled.right)
        return travels

    def _compare(self, travels: list[Wheels], encoders: EncodersReading, time: float) -> None:
        assert self._counts is not None  # noqa: S101 - the caller looked
        share = self._per_count / time
        left, right = (encoders.left - self._counts[0]) * share, (encoders.right - self._counts[1]) * share
        off = [max(abs(left - one.left / time), abs(right - one.right / time)) for one in travels]
        self._errors = [error + most * most for error, most in zip(self._errors, off, strict=True)]
        least = min(self._errors) + SAME
        self.ticks = max(late for late, error in enumerate(self._errors) if error <= least)
        self.speeds = self._models[self.ticks]
        if off[self.ticks] > max(TOLERANCE, COUNTS * share):
            self.speeds = Wheels(left, right)

    def _command(self, tick: int) -> Wheels:
        """Return the command that answered a tick, or the last before it."""
        for sent, wheels in reversed(self._sent):
            if sent <= tick:
                return wheels
        return STILL
