"""The driver `world`: a chair of another running simulation as the hardware.

It joins that simulation through the same harness as any agent: its measures are the chair's electronics, its actions
the motors. It reads no state, and it refuses a robot with a truth sensor, because a real chair has neither.
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
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.timeouts import POWER_TIMEOUT
from intellwheels_agents.mind import Context, Make
from intellwheels_agents.options import OptionError
from intellwheels_schemas.messages import GPS, Actions, GPSReading, Measures, Pace, Robot, Sensors
from intellwheels_schemas.process import THREADS_END, start_network_thread

MAX_READINGS: Final = 1200
"""Readings kept until they are read: a minute at 20 Hz."""

JoinLaboratory = Callable[[Make], int]
"""Joins the laboratory as an agent, stays until the process stops, and returns the exit code."""


def with_receiver(robot: Robot, *, fixes: bool, noise: float, every: int) -> Robot:
    """Return a chair with a receiver for position fixes, if they are needed and it has none.

    Args:
        robot: The chair as built.
        fixes: Whether they are needed.
        noise: Standard deviation on each axis, in metres.
        every: Ticks from one to the next.

    Raises:
        OptionError: The chair has a truth sensor, or no encoders.
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
        restarts_at_start: True, because a new run of the laboratory puts the chair back to its start.
        failure: Why the bridge has left the laboratory for good, or None.
        connected: Set when the first reading has arrived.
    """

    restarts_at_start = True

    def __init__(self, robot: Robot, motors: MotorDeadman, join: JoinLaboratory, stop: threading.Event) -> None:
        """Prepare to join.

        Args:
            robot: The chair as it joins the laboratory.
            motors: Gives the power in lockstep; otherwise `write` does.
            join: Joins the laboratory.
            stop: Ends every wait.
        """
        self.failure: str | None = None
        self.connected = threading.Event()
        self._receivers = {gps.id: gps for gps in robot.gps}
        self._motors = motors
        self._join = join
        self._stop = stop
        self._pairing = LockstepPairing(stop)
        self._readings: deque[tuple[int, Reading]] = deque(maxlen=MAX_READINGS)
        self._power = (0.0, 0.0)
        self._power_at = float("-inf")
        self._simulation_pace: Pace | None = None
        self._laboratory_pace: Pace | None = None
        self._period = 0.05
        self._run = ""
        self._fix_tick = -1
        self._thread: threading.Thread | None = None

    # ------------------------------------------------------------ the driver

    def start(self) -> None:
        """Join the laboratory."""
        self._thread = start_network_thread("laboratory", self._run_laboratory)

    def read(self) -> list[Reading]:
        """Return the readings since the last call; of two lockstep worlds only those of the paired run."""
        found = []
        paired = self._simulation_pace == self._laboratory_pace == "lockstep"
        run = self._pairing.simulation_run
        while self._readings and not (paired and self._readings[0][0] > run):
            number, reading = self._readings.popleft()
            if not paired or number == run:
                found.append(reading)
        return found

    def write(self, left: float, right: float) -> None:
        """Set the motor powers."""
        self._power = (left, right)
        self._power_at = time.monotonic()

    def begin_run(self, run: str) -> None:
        """Count a run of the simulation."""
        self._pairing.simulation_run_began(run)

    def sync_tick(self, run: str, tick: int, pace: Pace) -> bool:
        """Note the simulation's tick; in lockstep wait for the measures of the same tick."""
        self._simulation_pace = pace
        self._pairing.simulation_run_began(run)
        if pace != "lockstep" or self._laboratory_pace != "lockstep":
            return False
        return self._pairing.await_measures(tick)

    def power_received(self, run: str, tick: int) -> None:
        """Note that the power of a tick is set."""
        self._pairing.simulation_powered(run, tick)

    def faults(self) -> dict[str, int]:
        """Return none: the harness counts what is lost on the way to a laboratory."""
        return {}

    def close(self) -> None:
        """Leave the laboratory; `stop` is set already."""
        if self._thread is not None:
            self._thread.join(timeout=THREADS_END)

    # ------------------------------------------------------------ in the laboratory

    def _run_laboratory(self) -> None:
        code = 1
        try:
            code = self._join(self._begin)
        finally:
            if not self._stop.is_set():
                self.failure = f"the connection to the laboratory ended with exit code {code}"
                self._stop.set()

    def _begin(self, context: Context) -> WorldDriver:
        self._laboratory_pace = context.parameters.pace
        self._period = context.parameters.period
        self._pairing.laboratory_run_began(context.run)
        return self

    def decide(self, measures: Measures) -> Actions:
        """Pass the measures on as a reading and return the motor power. Called by the harness."""
        self._add(measures)
        left, right = self._output(measures.tick)
        return Actions(left_motor=left, right_motor=right)

    def _add(self, measures: Measures) -> None:
        sensors = measures.sensors or Sensors()
        number = self._pairing.laboratory_run_began(measures.run)
        if measures.run != self._run:
            self._run, self._fix_tick = measures.run, -1
        if sensors.encoders:
            counts, user = sensors.encoders[0], measures.user_input
            reading = Reading(
                epoch=measures.run,
                seq=measures.tick,
                stamp=measures.time,
                received=time.monotonic(),
                left=counts.left,
                right=counts.right,
                tick=measures.tick,
                proximity=sensors.proximity,
                fix=self._fix(sensors.gps, measures.tick),
                forward=None if user is None else user.forward,
                turn=None if user is None else user.turn,
            )
            self._readings.append((number, reading))
            self.connected.set()
        self._pairing.laboratory_measured(measures.run, measures.tick)

    def _fix(self, readings: tuple[GPSReading, ...], tick: int) -> Fix | None:
        """Return a new position, or None: between two samples measures repeat the last one."""
        for reading in readings:
            receiver = self._receivers.get(reading.id)
            sampled = tick if reading.tick is None else reading.tick
            if receiver is None or reading.x is None or reading.y is None or sampled <= self._fix_tick:
                continue
            self._fix_tick = sampled
            return Fix(reading.x, reading.y, max(receiver.noise, receiver.step), receiver.x, receiver.y)
        return None

    def _output(self, tick: int) -> tuple[float, float]:
        if self._laboratory_pace == "lockstep":
            if tick == 0:
                return 0.0, 0.0
            # The first power comes after `sync_tick`, which tells the simulation's pace.
            self._pairing.await_power(tick - 1)
            if self._simulation_pace == "lockstep":
                return self._motors.output(tick * self._period)
        if time.monotonic() - self._power_at > POWER_TIMEOUT:
            return 0.0, 0.0
        return self._power
