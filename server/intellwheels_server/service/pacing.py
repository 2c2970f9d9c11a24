"""Decides when the next tick begins: pace, speed, pause, steps and the lockstep barrier."""

from __future__ import annotations

from dataclasses import dataclass

from intellwheels_schemas.messages import Pace
from intellwheels_server.service.arrival import Query
from intellwheels_server.service.barrier import Answer, Barrier
from intellwheels_server.service.pace import BusyShare, LateWatch, Metronome, RealTimeFactor
from intellwheels_server.world import Setup


@dataclass(slots=True)
class PendingSteps:
    """Steps that an operator asked for while the run is paused.

    Attributes:
        left: Steps still to make.
        query: Is answered after the last one.
    """

    left: int
    query: Query


class Pacing:
    """When ticks begin.

    Attributes:
        pace: What makes a tick begin.
        lockstep: Whether the pace is lockstep.
        strict: Whether a missed answer ends the run.
        metronome: Deadlines of ticks in real time.
        real_time_factor: How fast the run goes.
        busy_share: How much of the time the simulator works.
        world_share: How much of the time it moves the world.
        late_watch: Whether ticks are late again and again.
        barrier: The answers to the current tick, in lockstep.
        answers: What lockstep expects at each tick; empty at any other pace.
        barrier_open: Whether the measures of this tick are out and its answers are expected.
        waiting_to_start: Whether tick 0 waits for the expected agents.
        paused: Whether an operator paused the run.
        steps: Steps to make while paused, if any.
    """

    def __init__(self, pace: Pace, setup: Setup, *, speed: float, deadline: float) -> None:
        self.pace = pace
        self.lockstep = pace == "lockstep"
        self.strict = setup.strict
        self.metronome = Metronome(setup.period, speed)
        self.real_time_factor = RealTimeFactor(setup.period)
        self.busy_share = BusyShare()
        self.world_share = BusyShare()
        self.late_watch = LateWatch()
        self.barrier = Barrier(strict=self.strict, deadline=deadline)
        self.answers: frozenset[Answer] = frozenset()
        self.barrier_open = False
        self.waiting_to_start = True
        self.paused = False
        self.steps: PendingSteps | None = None

    @property
    def at_real_speed(self) -> bool:
        """Whether simulated time passes as fast as wall time, as real hardware needs."""
        return self.pace == "realtime" and self.metronome.speed == 1.0

    @property
    def measures_are_out(self) -> bool:
        """Whether the measures of this tick are out, so that who joins now must get them too."""
        return not self.waiting_to_start and (self.barrier_open or not self.lockstep)

    def is_stopped(self, *, ended: bool) -> bool:
        """Return whether no message that arrives can cause a step now.

        Args:
            ended: Whether the end condition of the run is met.
        """
        return self.waiting_to_start or ended or (self.paused and self.steps is None)

    def start_clock(self, now: float) -> None:
        """Measure all deadlines from now: at the start, after a pause, after a jump."""
        self.metronome.start(now)
        self.barrier.restart_timers(now)

    def begin_new_run(self, rested: list[str]) -> None:
        """Wait to start, as at the beginning.

        Args:
            rested: Bodies at rest in the first state; the barrier does not wait for them.
        """
        self.barrier.begin_new_run(rested)
        self.waiting_to_start, self.barrier_open = True, False
        self.metronome.late = 0
        self.real_time_factor.reset()
