"""A live run without its network: arrivals go in, messages come out, and the world moves when it may.

Nothing here waits, decides by a clock or knows Zenoh: time is passed in, and `due` says when to call `work` again. One
thread calls it. The order at a tick: arrivals are kept as they come; when the pace allows, one step is made; then the
queued changes (joins, leaves, control messages) act, and the measures of the new tick are sent.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

from intellwheels_schemas.file_records import Verdict
from intellwheels_schemas.messages import Event
from intellwheels_server.log.branch import Branch
from intellwheels_server.service import (
    control,
    crew_inbound,
    crew_joining,
    inbound,
    joining,
    leaving,
    outbound,
    presence,
)
from intellwheels_server.service.arrival import Arrival, Put, Query, Token
from intellwheels_server.service.connected_agents import BridgeStatus
from intellwheels_server.service.load_floor import FloorWorker
from intellwheels_server.service.publisher import Outlet
from intellwheels_server.service.run_state import Recorder
from intellwheels_server.service.service_state import Options, ServiceState
from intellwheels_server.world import State

STALE_AFTER: Final = 0.3
"""Seconds without a pose after which a real body is stale, or three ticks if they are longer."""


class LiveRun:
    """Decides when the world of a live run moves and what is sent."""

    def __init__(
        self,
        options: Options,
        outlet: Outlet,
        floor_worker: FloorWorker,
        unix_time: Callable[[], float],
        record: Recorder | None = None,
        run: str | None = None,
        timer: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Begin a run; the arguments are those of `ServiceState`, and what measures how long a step takes, s."""
        self._timer = timer
        self._service = ServiceState(options, outlet, floor_worker, unix_time, record, run)
        self._service.pacing.paused = options.await_page

    @property
    def exit(self) -> int | None:
        """The exit code of the process once the service is over, else None."""
        return self._service.exit

    @property
    def state(self) -> State:
        """The world."""
        return self._service.run.state

    def digest(self) -> str:
        """Return the hash of the state."""
        return self._service.run.digest()

    def observe_events(self, observer: Callable[[Event], None]) -> None:
        """Call `observer` with each event, before positions are removed from it."""
        self._service.publisher.observer = observer

    def begin(self) -> None:
        """Publish the map, before anything happens."""
        outbound.publish_map(self._service.run, self._service.publisher)

    def take(self, arrival: Arrival, now: float) -> None:
        """Take what arrived. The world does not move."""
        if isinstance(arrival, Put) and arrival.kind == "crew":
            crew_inbound.take_crew_put(self._service, arrival, now)
        elif isinstance(arrival, Put):
            inbound.take_put(self._service, arrival, now)
        elif isinstance(arrival, Token):
            presence.take_token(self._service, arrival, now)
            crew_joining.take_crew_token(self._service, arrival)
        else:
            self._take_query(arrival, now)

    def work(self, now: float) -> None:
        """Do everything that is due; at most one step is made."""
        service = self._service
        if service.exit is not None:
            return
        presence.handle_deadlines(service, now)
        crew_joining.handle_crew_deadlines(service, now)
        for request in service.floors.work(now):
            service.queue_change(request)
        if service.has_queued_changes and service.may_change():
            service.make_queued_changes(now)
        if self._may_start():
            self._start(now)
        self._move(now)
        outbound.publish_due(service, now)
        outbound.put_idle_powers(service, now)

    def due(self, now: float) -> float:
        """Return when to call `work` next if nothing arrives; `now` or less means at once."""
        service, pacing, agents = self._service, self._service.pacing, self._service.agents
        times = [
            service.publisher.schedule.due(),
            agents.leases.due(),
            agents.roster.due(service.options.grace),
            service.floors.due(now),
            *(join.until for join in agents.waiting_joins),
            *(crew.until for crew in agents.waiting_crews),
        ]
        if agents.bridges and service.is_stopped():
            times.append(service.publisher.idle_power_at)
        if (service.has_queued_changes and service.may_change()) or self._may_start():
            return now
        if not service.is_stopped():
            if not pacing.lockstep:
                times.append(pacing.metronome.due() if pacing.pace == "realtime" else now)
            elif pacing.barrier_open:
                if pacing.barrier.complete(now):
                    return now
                times.append(pacing.barrier.due())
            elif pacing.answers or pacing.steps:
                return now
        return min(times)

    def spend(self, seconds: float, now: float) -> None:
        """Note that the work of this run has taken so many seconds of wall time until now."""
        self._service.pacing.busy_share.spend(seconds, now)

    def finish(self, now: float) -> None:
        """Publish and record what is left before the service ends."""
        service = self._service
        service.answer_steps("failed", "the simulator ends")
        for request in service.floors.close():
            request(now)
        for join in service.agents.waiting_joins:
            join.query.close()
        for crew in service.agents.waiting_crews:
            crew.query.close()
        service.agents.waiting_joins.clear()
        service.agents.waiting_crews.clear()
        outbound.publish(service, now)
        outbound.put_zero_powers(service)
        if service.run.unrecorded:
            service.run.record_changes(service.run.state.tick)

    def _take_query(self, query: Query, now: float) -> None:
        match query.topic:
            case "join":
                joining.handle_join(self._service, query, now)
            case "leave":
                leaving.handle_leave(self._service, query)
            case "crew-join":
                crew_joining.handle_crew_join(self._service, query, now)
            case "crew-leave":
                crew_joining.handle_crew_leave(self._service, query)
            case "ctl":
                control.handle_control(self._service, query, now)
            case _:
                outbound.answer_query(self._service, query, now)

    # ------------------------------------------------------------ moving

    def _may_start(self) -> bool:
        return self._service.pacing.waiting_to_start and self._service.is_complete()

    def _start(self, now: float) -> None:
        service, pacing, state = self._service, self._service.pacing, self._service.run.state
        pacing.waiting_to_start = False
        if service.run.unrecorded:
            # Who joined before the first step is in a line of its own, so that files of the run begin with all bodies.
            service.run.record_changes(state.tick)
        pacing.metronome.start(now)
        service.agents.count_silence_from(now)
        service.publisher.schedule.mark_changed()
        service.publisher.outlet.print_line(f"running tick={state.tick} run={state.run}")
        if not pacing.lockstep:
            outbound.put_all_measures(service)

    def _move(self, now: float) -> None:
        pacing = self._service.pacing
        if self._service.is_stopped():
            return
        if pacing.lockstep:
            self._move_in_lockstep(now)
        elif pacing.pace == "free":
            self._step(now)
        elif now >= pacing.metronome.due():
            outbound.report_lateness(self._service, pacing.metronome.begin_tick(now), now)
            self._step(now)

    def _move_in_lockstep(self, now: float) -> None:
        pacing = self._service.pacing
        if not pacing.barrier_open:
            if pacing.answers:
                self._open_barrier(now)
            elif pacing.steps is not None:
                self._step(now)
            return
        if not pacing.barrier.complete(now) and not self._handle_missing(now):
            return
        if pacing.barrier.complete(now):
            self._step(now)

    def _handle_missing(self, now: float) -> bool:
        """Handle missed answers and send measures again; return whether the run continues."""
        service, barrier, agents = self._service, self._service.pacing.barrier, self._service.agents
        missed = barrier.missed(now)
        if missed and service.pacing.strict:
            service.end_for_missed_answer(missed[0][0])
            return False
        for agent, kind in missed:
            service.publisher.outlet.log_line(f"late agent={agent} tick={service.run.state.tick}")
            if kind == "pose" and agent in agents.bridges:
                agents.bridges[agent].reported_at = float("-inf")
        outbound.put_measures_again(service, barrier.to_repeat(now))
        return True

    def _open_barrier(self, now: float) -> None:
        pacing = self._service.pacing
        pacing.barrier_open = True
        outbound.put_all_measures(self._service)
        pacing.barrier.open(pacing.answers, now)

    def _step(self, now: float) -> None:
        service, run, pacing = self._service, self._service.run, self._service.pacing
        tick = run.state.tick
        inputs = service.latch.collect((), self._verdicts(now))
        branch = service.options.branch
        parent_inputs = branch.inputs(tick) if branch is not None else None
        if parent_inputs is not None:
            inputs = parent_inputs
        before = run.state
        began = self._timer()
        outputs = run.advance(inputs)
        pacing.world_share.spend(self._timer() - began, now)
        service.travelled.follow(before, run.state)
        ended = run.state.ended
        if branch is not None and parent_inputs is not None:
            self._compare(branch, tick)
        for event in outputs.events:
            service.publisher.put_event(event)
        run.record_step(tick, inputs)
        pacing.barrier_open = False
        pacing.real_time_factor.count_tick(now)
        service.publisher.schedule.mark_changed()
        if service.agents.bridges:
            outbound.put_powers(service, tick)
        if service.has_queued_changes:
            service.make_queued_changes(now)
        if ended and run.state.ended:
            self._end(now)
        elif pacing.steps is not None:
            pacing.steps.left -= 1
            if pacing.steps.left <= 0:
                service.answer_steps("ok")
                outbound.publish(service, now)
        if pacing.waiting_to_start or service.exit is not None:
            return
        if not pacing.lockstep:
            outbound.put_all_measures(service)
        elif pacing.answers:
            self._open_barrier(now)

    def _compare(self, branch: Branch, tick: int) -> None:
        """End a branch that differs from its parent; report where its own inputs begin to count."""
        service, digest = self._service, self._service.run.digest()
        differs = branch.differs(tick, digest)
        if differs is not None:
            service.publisher.outlet.log_line(
                f"branch {differs}; its bodies and their options must be those of the parent"
            )
            service.publisher.outlet.print_line(f"differs tick={tick + 1}")
            service.exit = 1
        elif tick + 1 == branch.at:
            service.publisher.outlet.print_line(f"branched tick={branch.at} hash={digest}")

    def _end(self, now: float) -> None:
        service, run = self._service, self._service.run
        service.answer_steps("ok", "the run has ended")
        outbound.publish(service, now)
        service.publisher.outlet.print_line(f"ended tick={run.state.tick} hash={run.digest()} run={run.state.run}")
        if service.options.quit_at_end:
            service.exit = 0

    # ------------------------------------------------------------ verdicts

    def _verdicts(self, now: float) -> list[Verdict]:
        pacing, agents = self._service.pacing, self._service.agents
        verdicts = pacing.barrier.verdicts() if pacing.lockstep else []
        if not pacing.strict:
            verdicts += [Verdict(agent=agent, code="silent") for agent in agents.leases.newly_silent(now)]
        for agent, bridge in agents.bridges.items():
            verdicts += self._bridge_verdicts(agent, bridge, now)
        models = self._service.run.state.body_set.models
        return [verdict for verdict in verdicts if verdict.agent in models]

    def _bridge_verdicts(self, agent: str, bridge: BridgeStatus, now: float) -> list[Verdict]:
        pacing = self._service.pacing
        found: list[Verdict] = []
        if not pacing.strict:
            limit = max(3.0 * pacing.metronome.interval if pacing.pace == "realtime" else 0.0, STALE_AFTER)
            # Lockstep waits for a pose, so there only a missed one is old.
            stale = bridge.reported_at == float("-inf") if pacing.lockstep else now - bridge.reported_at > limit
            if stale != bridge.stale:
                bridge.stale = stale
                found.append(Verdict(agent=agent, code="stale" if stale else "fresh"))
        halted = outbound.is_hardware(self._service.agents.roster, agent) and not pacing.at_real_speed
        if halted != bridge.halted:
            bridge.halted = halted
            found.append(Verdict(agent=agent, code="halt" if halted else "unhalt"))
        return found
