"""The body of a real chair in the simulation: a `Bridge` for the harness, which joins as role `body`.

Each tick: what the electronics said becomes a pose, with covariance and the time it was true at. Nothing is reported
while nothing new was heard for max(3 ticks, 0.3 s), so that the simulator shows the chair as stale; in lockstep, where
an answer is awaited, the last pose stands. Faults of `Faults` lie between the electronics and all of this.

Times are seconds: of the monotonic clock in real time, of the simulation in lockstep.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from intellwheels_agents.bridge.clock_offset import ClockOffset
from intellwheels_agents.bridge.hardware_driver import Driver, Reading
from intellwheels_agents.bridge.line_faults import Faults, FaultyLine
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.pose_source import PoseSource
from intellwheels_agents.bridge.sensor_merge import SensorMerge
from intellwheels_agents.mind import Context
from intellwheels_schemas.messages import Measures, Pose, PowerInForce

STALE_TICKS: Final = 3
STALE: Final = 0.3
"""Seconds; the simulator's own measure of a stale pose."""


@dataclass
class Tally:
    """What the bridge saw.

    Attributes:
        poses: Poses reported.
        readings: Readings taken.
        stale: Times that the hardware fell silent.
        oldest: The greatest age of what a pose was made of, in seconds.
        age: The sum of those ages.
    """

    poses: int = 0
    readings: int = 0
    stale: int = 0
    oldest: float = 0.0
    age: float = 0.0


class RealChair:
    """A real chair's body. `begin` is the harness's `make`.

    Attributes:
        lockstep: Whether the simulation is in lockstep; None before it is known.
        tally: What was seen so far.
    """

    def __init__(
        self,
        driver: Driver,
        source: PoseSource,
        motors: MotorDeadman,
        merge: SensorMerge,
        *,
        faults: Faults | None = None,
        hear: Callable[[Reading], None] | None = None,
        clock_offset: float = 0.0,
        clock: Callable[[], float] = time.monotonic,
        wall: Callable[[], float] = time.time,
    ) -> None:
        """Make a body that is nowhere yet.

        Args:
            driver: The electronics.
            source: Makes poses of their readings.
            motors: Takes the powers.
            merge: Makes the chair's own readings what its mind perceives.
            faults: Of the line that readings come by.
            hear: Is told of each reading that is news.
            clock_offset: Seconds added to every stamp: the simulator's clock minus this machine's.
            clock: Monotonic seconds.
            wall: Unix seconds.
        """
        self.lockstep: bool | None = None
        self.tally = Tally()
        self._driver = driver
        self._source = source
        self._motors = motors
        self._merge = merge
        self._line: FaultyLine[tuple[float, Reading]] = FaultyLine(faults or Faults(), "up")
        self._hear = hear
        self._clock_offset = clock_offset
        self._clock = clock
        self._wall = wall
        self._offset = ClockOffset()
        self._context: Context | None = None
        self._run = ""
        self._newest: Reading | None = None
        self._heard = 0.0
        self._is_stale = False

    @property
    def lost(self) -> int:
        """Readings that the faults took."""
        return self._line.lost

    def begin(self, context: Context) -> RealChair:
        """Be told of the simulation that it joined."""
        self._context = context
        self.lockstep = context.parameters.pace == "lockstep"
        self._source.begin(context.position)
        self._driver.enter(context.run)
        return self

    def decide(self, measures: Measures) -> Pose | None:
        """Return where the chair is, or None when that is not known."""
        context = self._context
        if context is None:
            raise RuntimeError("a real chair decides before it has begun")
        self._enter(measures.run)
        paired = self._driver.meet(measures.run, measures.tick, context.parameters.pace)
        period = context.parameters.period
        now = measures.tick * period if self.lockstep else self._clock()
        for reading in self._driver.read():
            if paired and reading.tick is not None:
                came = reading.tick * period
            else:
                came = now if self.lockstep else reading.arrived
            self._line.send((came, reading), came)
        for due, (came, reading) in self._line.arrived(now):
            self._take(reading, came, due)
        return self._pose(now, max(STALE_TICKS * period, STALE))

    def obey(self, power: PowerInForce) -> None:
        """Take the power in force."""
        context = self._context
        if context is None:
            return
        # In lockstep the power of a tick is the step's that ends it.
        now = (power.tick + 1) * context.parameters.period if self.lockstep else self._clock()
        self._motors.obey(power, now)
        self._driver.powered(power.run, power.tick)

    def _enter(self, run: str) -> None:
        if run != self._run:
            self._run = run
            self._line.renew()
            self._motors.renew()
            if self.lockstep and self._driver.returns:
                # Both worlds begin anew: what is late must not be where it ended.
                self._source.renew()
                self._newest = None

    def _take(self, reading: Reading, came: float, due: float) -> None:
        newest = self._newest
        if newest is not None and newest.era != reading.era:
            self._offset.renew()
        if not self._source.take(reading):
            return
        # By when it came to this machine: what the faults add is an age, not an offset.
        self._offset.hear(reading.taken, came)
        self._newest, self._heard = reading, due
        self.tally.readings += 1
        if self._hear is not None:
            self._hear(reading)

    def _pose(self, now: float, limit: float) -> Pose | None:
        newest, estimate = self._newest, self._source.estimate
        if newest is None or estimate is None:
            # In lockstep it is awaited, and until the first reading arrived it is where it began.
            start = self._source.start
            return Pose(x=start.x, y=start.y, heading=start.heading) if self.lockstep else None
        stale = now - self._heard > limit
        if stale != self._is_stale:
            self._is_stale = stale
            self.tally.stale += stale
            _log("stale hardware=silent" if stale else "fresh hardware=heard")
        if stale and not self.lockstep:
            return None
        age = max(now - self._offset.ours(newest.taken), 0.0)
        self.tally.poses += 1
        self.tally.age += age
        self.tally.oldest = max(self.tally.oldest, age)
        return Pose(
            x=estimate.x,
            y=estimate.y,
            heading=estimate.heading,
            # A lockstep has no wall clock, and its log must be the same each time.
            stamp=None if self.lockstep else self._wall() - age + self._clock_offset,
            covariance=estimate.covariance,
            sensors=self._merge.forward(newest, self._source),
        )


def _log(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()
