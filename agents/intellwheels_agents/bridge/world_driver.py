"""A chair of another running simulation as hardware: the driver `world`.

It is an agent there, through the same harness as any: its measures are the electronics, its actions the motors. What a
chair's electronics would not give it never asks for: it reads no state, and a robot with a truth sensor is refused.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Final

import msgspec

from intellwheels_agents.bridge.hardware_driver import Fix, Reading
from intellwheels_agents.bridge.lockstep_pairing import LockstepPairing
from intellwheels_agents.bridge.motor_deadman import SILENCE, MotorDeadman
from intellwheels_agents.mind import Context, Make
from intellwheels_agents.options import OptionError
from intellwheels_schemas.messages import GPS, Actions, GPSReading, Measures, Pace, Robot, Sensors

ROOM: Final = 1200
"""Readings kept until they are read: a minute at 20 Hz."""

Enter = Callable[[Make], int]
"""Joins the laboratory with minds made so, until told to stop; returns the exit code."""


def fitted(robot: Robot, *, fixes: bool, noise: float, every: int) -> Robot:
    """Return a chair with a receiver for fixes, where they are wanted and it has none.

    Args:
        robot: The chair as built.
        fixes: Whether they are wanted.
        noise: Standard deviation on each axis, in metres.
        every: Ticks from one to the next.

    Raises:
        OptionError: The chair would know the truth.
    """
    if robot.truth:
        raise OptionError("--chair: expected a robot without truth sensors, got one that has them")
    if not robot.encoders:
        raise OptionError("--chair: expected a robot with encoders, got one without")
    if not fixes or robot.gps:
        return robot
    return msgspec.structs.replace(robot, gps=(GPS(id="fix", noise=noise, every=every),))


class WorldDriver:
    """The driver `world`.

    Attributes:
        returns: True: a new run there puts the chair back to its start.
        failure: Why the laboratory was left for good, or None.
        heard: Set when the first reading is there.
    """

    returns = True

    def __init__(self, robot: Robot, motors: MotorDeadman, enter: Enter, stop: threading.Event) -> None:
        """Prepare to enter.

        Args:
            robot: The chair as it joins there.
            motors: Says what to give, in lockstep; otherwise `write` does.
            enter: Joins.
            stop: Ends every wait.
        """
        self.failure: str | None = None
        self.heard = threading.Event()
        self._receivers = {gps.id: gps for gps in robot.gps}
        self._motors = motors
        self._enter = enter
        self._stop = stop
        self._pairing = LockstepPairing(stop)
        self._readings: deque[tuple[int, Reading]] = deque(maxlen=ROOM)
        self._power = (0.0, 0.0)
        self._written = float("-inf")
        self._pace_here: Pace | None = None
        self._pace_there: Pace | None = None
        self._period = 0.05
        self._run = ""
        self._fixed_at = -1
        self._thread = threading.Thread(target=self._live, name="laboratory", daemon=True)

    # ------------------------------------------------------------ the driver

    def start(self) -> None:
        """Enter the laboratory."""
        self._thread.start()

    def read(self) -> list[Reading]:
        """Return what was measured since the last call; of two lockstep worlds, in the run that pairs with this one."""
        found = []
        paired = self._pace_here == self._pace_there == "lockstep"
        here = self._pairing.here
        while self._readings and not (paired and self._readings[0][0] > here):
            number, reading = self._readings.popleft()
            if not paired or number == here:
                found.append(reading)
        return found

    def write(self, left: float, right: float) -> None:
        """Give the motors these powers."""
        self._power = (left, right)
        self._written = time.monotonic()

    def enter(self, run: str) -> None:
        """Count a run of the simulation's."""
        self._pairing.here_entered(run)

    def meet(self, run: str, tick: int, pace: Pace) -> bool:
        """Note where the simulation is; in lockstep wait for the measures of the same tick."""
        self._pace_here = pace
        self._pairing.here_entered(run)
        if pace != "lockstep" or self._pace_there != "lockstep":
            return False
        return self._pairing.await_measures(tick)

    def powered(self, run: str, tick: int) -> None:
        """Note that the motors have the power of a tick."""
        self._pairing.here_powered(run, tick)

    def faults(self) -> dict[str, int]:
        """Return none: what is lost on the way to a laboratory its harness counts."""
        return {}

    def close(self) -> None:
        """Leave; `stop` is set already."""
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)

    # ------------------------------------------------------------ within the laboratory

    def _live(self) -> None:
        code = 1
        try:
            code = self._enter(self._begin)
        finally:
            if not self._stop.is_set():
                self.failure = f"the laboratory was left with exit code {code}"
                self._stop.set()

    def _begin(self, context: Context) -> WorldDriver:
        self._pace_there = context.parameters.pace
        self._period = context.parameters.period
        self._pairing.lab_entered(context.run)
        return self

    def decide(self, measures: Measures) -> Actions:
        """Hand on what is measured; return what the motors give. For the harness."""
        self._note(measures)
        left, right = self._output(measures.tick)
        return Actions(left_motor=left, right_motor=right)

    def _note(self, measures: Measures) -> None:
        sensors = measures.sensors or Sensors()
        number = self._pairing.lab_entered(measures.run)
        if measures.run != self._run:
            self._run, self._fixed_at = measures.run, -1
        if sensors.encoders:
            counts, user = sensors.encoders[0], measures.user_input
            reading = Reading(
                era=measures.run,
                seq=measures.tick,
                taken=measures.time,
                arrived=time.monotonic(),
                left=counts.left,
                right=counts.right,
                tick=measures.tick,
                proximity=sensors.proximity,
                fix=self._fix(sensors.gps, measures.tick),
                forward=None if user is None else user.forward,
                turn=None if user is None else user.turn,
            )
            self._readings.append((number, reading))
            self.heard.set()
        self._pairing.lab_measured(measures.run, measures.tick)

    def _fix(self, readings: tuple[GPSReading, ...], tick: int) -> Fix | None:
        """Return a position that is news: between two samples the last one is repeated."""
        for reading in readings:
            receiver = self._receivers.get(reading.id)
            taken = tick if reading.tick is None else reading.tick
            if receiver is None or reading.x is None or reading.y is None or taken <= self._fixed_at:
                continue
            self._fixed_at = taken
            return Fix(reading.x, reading.y, max(receiver.noise, receiver.step), receiver.x, receiver.y)
        return None

    def _output(self, tick: int) -> tuple[float, float]:
        if self._pace_there == "lockstep":
            if tick == 0:
                return 0.0, 0.0
            # Its first word is which pace it has.
            self._pairing.await_power(tick - 1)
            if self._pace_here == "lockstep":
                return self._motors.output(tick * self._period)
        if time.monotonic() - self._written > SILENCE:
            return 0.0, 0.0
        return self._power
