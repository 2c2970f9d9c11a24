"""The body of a real chair in the simulation: a `Bridge` for the harness, which joins with role `body`.

Each tick turns the readings received since the last one into a pose, with covariance and time stamp. Without a new
reading for max(3 ticks, 0.3 s) no pose is reported, and the simulator shows the chair as stale. In lockstep the
simulator awaits an answer, so the last pose is repeated. `Faults` act on the line from the electronics.

Times are in seconds: of the monotonic clock in real time, of the simulation in lockstep.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

from intellwheels_agents.bridge.clock_offset import ClockOffset
from intellwheels_agents.bridge.hardware_driver import Driver, Reading
from intellwheels_agents.bridge.line_faults import Faults, FaultyLine
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.pose_source import PoseSource
from intellwheels_agents.bridge.sensor_merge import SensorMerge
from intellwheels_agents.bridge.timeouts import POSE_TIMEOUT, POSE_TIMEOUT_TICKS
from intellwheels_agents.mind import Context
from intellwheels_schemas.messages import Measures, Pose, PowerInForce


@dataclass
class BridgeStatistics:
    """The counts of a bridge.

    Attributes:
        poses: Poses reported.
        readings: Readings used.
        stale: How often the hardware fell silent.
        oldest: Largest age of a reported pose, in seconds.
        age: Sum of the ages of all reported poses, in seconds.
    """

    poses: int = 0
    readings: int = 0
    stale: int = 0
    oldest: float = 0.0
    age: float = 0.0


class RealChair:
    """A real chair's body. Its method `begin` is what the harness calls to make a mind.

    Attributes:
        lockstep: Whether the simulation is in lockstep; None before it is known.
        statistics: Counted so far.
    """

    def __init__(
        self,
        driver: Driver,
        source: PoseSource,
        motors: MotorDeadman,
        merge: SensorMerge,
        *,
        faults: Faults | None = None,
        on_reading: Callable[[Reading], None] | None = None,
        clock_offset: float = 0.0,
        clock: Callable[[], float] = time.monotonic,
        wall: Callable[[], float] = time.time,
    ) -> None:
        """Create a body that has no place yet.

        Args:
            driver: The electronics.
            source: Turns their readings into poses.
            motors: Receives the powers.
            merge: Selects the chair's own readings that the mind gets.
            faults: Faults of the line that readings arrive on.
            on_reading: Called with each new reading.
            clock_offset: Seconds added to every time stamp: the simulator's clock minus this machine's.
            clock: Returns monotonic seconds.
            wall: Returns Unix seconds.
        """
        self.lockstep: bool | None = None
        self.statistics = BridgeStatistics()
        self._driver = driver
        self._source = source
        self._motors = motors
        self._merge = merge
        self._line: FaultyLine[tuple[float, Reading]] = FaultyLine(faults or Faults(), "up")
        self._on_reading = on_reading
        self._clock_offset = clock_offset
        self._clock = clock
        self._wall = wall
        self._offset = ClockOffset()
        self._context: Context | None = None
        self._run = ""
        self._newest: Reading | None = None
        self._received = 0.0
        self._is_stale = False

    @property
    def lost(self) -> int:
        """Number of readings lost on the line."""
        return self._line.lost

    def begin(self, context: Context) -> RealChair:
        """Start in a run of the simulation; the harness calls this after a join and at each new run."""
        self._context = context
        self.lockstep = context.parameters.pace == "lockstep"
        self._source.set_start(context.position)
        self._driver.begin_run(context.run)
        return self

    def decide(self, measures: Measures) -> Pose | None:
        """Return the chair's pose, or None when it is not known."""
        context = self._context
        if context is None:
            raise RuntimeError("RealChair.decide was called before begin")
        self._begin_run(measures.run)
        paired = self._driver.sync_tick(measures.run, measures.tick, context.parameters.pace)
        period = context.parameters.period
        now = measures.tick * period if self.lockstep else self._clock()
        for reading in self._driver.read():
            if paired and reading.tick is not None:
                received = reading.tick * period
            else:
                received = now if self.lockstep else reading.received
            self._line.send((received, reading), received)
        for due, (received, reading) in self._line.receive(now):
            self._add(reading, received, due)
        return self._pose(now, max(POSE_TIMEOUT_TICKS * period, POSE_TIMEOUT))

    def obey(self, power: PowerInForce) -> None:
        """Set the power in force; the harness calls this for each `PowerInForce`."""
        context = self._context
        if context is None:
            return
        # In lockstep the power of a tick belongs to the step that ends it.
        now = (power.tick + 1) * context.parameters.period if self.lockstep else self._clock()
        self._motors.set_power(power, now)
        self._driver.power_received(power.run, power.tick)

    def _begin_run(self, run: str) -> None:
        if run != self._run:
            self._run = run
            self._line.reset()
            self._motors.reset()
            if self.lockstep and self._driver.restarts_at_start:
                # Both worlds restart: a late reading of the old run must not set the pose.
                self._source.reset()
                self._newest = None

    def _add(self, reading: Reading, received: float, due: float) -> None:
        newest = self._newest
        if newest is not None and newest.epoch != reading.epoch:
            self._offset.reset()
        if not self._source.add(reading):
            return
        # The time of arrival at this machine counts: simulated faults make a reading older, not the clock different.
        self._offset.add(reading.stamp, received)
        self._newest, self._received = reading, due
        self.statistics.readings += 1
        if self._on_reading is not None:
            self._on_reading(reading)

    def _pose(self, now: float, limit: float) -> Pose | None:
        newest, estimate = self._newest, self._source.estimate
        if newest is None or estimate is None:
            # In lockstep a pose is awaited. Until the first reading arrives the chair is at its start.
            start = self._source.start
            return Pose(x=start.x, y=start.y, heading=start.heading) if self.lockstep else None
        stale = now - self._received > limit
        if stale != self._is_stale:
            self._is_stale = stale
            self.statistics.stale += stale
            _log("stale hardware=silent" if stale else "fresh hardware=heard")
        if stale and not self.lockstep:
            return None
        age = max(now - self._offset.to_ours(newest.stamp), 0.0)
        self.statistics.poses += 1
        self.statistics.age += age
        self.statistics.oldest = max(self.statistics.oldest, age)
        return Pose(
            x=estimate.x,
            y=estimate.y,
            heading=estimate.heading,
            # Lockstep has no wall clock, and its log must be the same each time.
            stamp=None if self.lockstep else self._wall() - age + self._clock_offset,
            covariance=estimate.covariance,
            sensors=self._merge.sensors(newest, self._source),
        )


def _log(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()
