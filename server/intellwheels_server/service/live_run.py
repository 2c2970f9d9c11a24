"""The service without its network: arrivals go in, messages come out, and the world moves when it may.

Nothing here waits, reads a clock or knows zenoh: time is passed in, and `due` says when to come back. One thread
calls it. The order at a tick: what arrived is latched; when the pace allows, one step is made; then the
changes asked for (joins, leaves, verbs) act, before the measures of the new tick go out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import msgspec

from intellwheels_schemas.messages import (
    Event,
    Load,
    Map,
    PowerInForce,
)
from intellwheels_server import world
from intellwheels_server.log.branch import Branch
from intellwheels_server.service import control, inbound, joining, outbound
from intellwheels_server.service.arrival import Arrival, Ask, Put, Token
from intellwheels_server.service.service_state import Bridge, Options, Outlet, Recorder, ServiceState
from intellwheels_server.world import State
from intellwheels_server.world.inputs import (
    Inputs,
    Verdict,
)

STALE_AFTER: Final = 0.3
"""Seconds without a pose, or three cycles if they are longer, after which a real body is stale."""


class LiveRun:
    """The service's decisions."""

    def __init__(
        self,
        options: Options,
        outlet: Outlet,
        floor_of: Callable[[Load], Map],
        wall: Callable[[], float],
        record: Recorder | None = None,
        run: str | None = None,
    ) -> None:
        """Begin a run; takes what `ServiceState` takes."""
        self._service = ServiceState(options, outlet, floor_of, wall, record, run)

    @property
    def exit(self) -> int | None:
        """The process's exit code once the service is over, else None."""
        return self._service.exit

    @property
    def state(self) -> State:
        """The world."""
        return self._service.state

    def digest(self) -> str:
        """Return the hash of the state."""
        return self._service.digest()

    def tell(self, witness: Callable[[Event], None]) -> None:
        """Tell somebody each event as it is, before what is hidden is left out."""
        self._service.witness = witness

    def begin(self) -> None:
        """Publish what there is to know before anything happens."""
        service = self._service
        outbound.publish_map(service)

    def take(self, arrival: Arrival, now: float) -> None:
        """Take in what arrived. The world does not move."""
        service = self._service
        if isinstance(arrival, Put):
            inbound.take_put(service, arrival, now)
        elif isinstance(arrival, Token):
            joining.take_token(service, arrival, now)
        else:
            self._take_ask(arrival, now)

    def work(self, now: float) -> None:
        """Do all that is due; at most one step is made."""
        service = self._service
        if service.exit is not None:
            return
        joining.expire(service, now)
        if service.pending and service.may_change():
            service.change(now)
        if service.held and self._may_begin():
            self._begin_run(now)
        self._move(now)
        if service.cadence.ready(now):
            outbound.publish(service, now)
        outbound.rest_real(service, now)

    def due(self, now: float) -> float:
        """Return when `work` must be called next if nothing arrives; `now` or less: at once."""
        service = self._service
        times = [service.cadence.due(), service.leases.due(), service.roster.due(service.options.grace)]
        times += [waiting.until for waiting in service.waiting]
        if service.bridges and service.stands():
            times.append(service.idle_power_at)
        if (service.pending and service.may_change()) or (service.held and self._may_begin()):
            return now
        if not service.stands():
            if not service.lockstep:
                times.append(service.metronome.due() if service.options.pace == "realtime" else now)
            elif service.open:
                if service.barrier.complete(now):
                    return now
                times.append(service.barrier.due())
            elif service.members or service.steps:
                return now
        return min(times)

    def finish(self, now: float) -> None:
        """Publish and record what is left before the service ends."""
        service = self._service
        service.close_steps("failed", "the simulator ends")
        for waiting in service.waiting:
            waiting.ask.close()
        service.waiting.clear()
        outbound.publish(service, now)
        for agent in service.bridges:
            outbound.put_power(
                service,
                agent,
                PowerInForce(
                    run=service.state.run, tick=service.state.tick, left_motor=0.0, right_motor=0.0, state="paused"
                ),
            )
        if service.changes and service.record is not None:
            service.record(service.state.tick, Inputs(changes=tuple(service.changes)), service.digest(), stepped=False)
            service.changes.clear()

    def _take_ask(self, ask: Ask, now: float) -> None:
        service = self._service
        match ask.topic:
            case "join":
                joining.ask_join(service, ask, now)
            case "leave":
                joining.ask_leave(service, ask)
            case "ctl":
                control.ask_ctl(service, ask, now)
            case _:
                outbound.ask_what_is(service, ask, now)

    def _may_begin(self) -> bool:
        service = self._service
        return not service.missing()

    def _begin_run(self, now: float) -> None:
        service = self._service
        service.held = False
        service.metronome.start(now)
        service.cadence.note()
        service.out.tell(f"running tick={service.state.tick} run={service.state.run}")
        if not service.lockstep:
            outbound.put_all_measures(service)

    def _move(self, now: float) -> None:
        service = self._service
        if service.stands():
            return
        if service.lockstep:
            self._move_in_lockstep(now)
        elif service.options.pace == "free":
            self._step(now)
        elif now >= service.metronome.due():
            service.metronome.began(now)
            self._step(now)

    def _move_in_lockstep(self, now: float) -> None:
        service = self._service
        barrier = service.barrier
        if not service.open:
            if service.members:
                self._open_barrier(now)
            elif service.steps is not None:
                self._step(now)
            return
        if not barrier.complete(now):
            missed = barrier.missed(now)
            if missed and service.strict:
                service.miss(missed[0][0])
                return
            for agent, kind in missed:
                service.out.note(f"late agent={agent} tick={service.state.tick}")
                if kind == "pose" and agent in service.bridges:
                    service.bridges[agent].at = float("-inf")
            for agent in barrier.to_repeat(now):
                outbound.put_measures(service, agent)
        if barrier.complete(now):
            self._step(now)

    def _open_barrier(self, now: float) -> None:
        service = self._service
        service.open = True
        outbound.put_all_measures(service)
        service.barrier.open(service.members, now)

    def _step(self, now: float) -> None:
        service = self._service
        closed = service.state.tick
        inputs = service.latch.collect((), self._verdicts(now))
        branch = service.options.branch
        told = branch.inputs(closed) if branch is not None else None
        state, outputs = world.advance(service.state, inputs if told is None else told)
        service.state = state
        if branch is not None and told is not None:
            inputs = told
            self._compare(branch, closed)
        for event in outputs.events:
            service.put_event(event)
        if service.record is not None:
            if service.changes:
                inputs = msgspec.structs.replace(inputs, changes=tuple(service.changes))
            service.record(closed, inputs, service.digest(), stepped=True)
        service.changes.clear()
        service.open = False
        service.tachometer.ticked(now)
        service.cadence.note()
        if service.bridges:
            outbound.put_powers(service, closed)
        if service.pending:
            service.change(now)
        if state.ended and service.state.ended:
            self._end(now)
        elif service.steps is not None:
            service.steps.left -= 1
            if service.steps.left <= 0:
                service.close_steps("ok", None)
                outbound.publish(service, now)
        if service.held or service.exit is not None:
            return
        if not service.lockstep:
            outbound.put_all_measures(service)
        elif service.members:
            self._open_barrier(now)

    def _compare(self, branch: Branch, tick: int) -> None:
        """End a branch that is not as its parent was; tell where it is free."""
        service = self._service
        differs = branch.differs(tick, service.digest())
        if differs is not None:
            service.out.note(f"branch {differs}; its bodies and options of bodies must be the parent's")
            service.out.tell(f"differs tick={tick + 1}")
            service.exit = 1
        elif tick + 1 == branch.at:
            service.out.tell(f"branched tick={branch.at} hash={service.digest()}")

    def _end(self, now: float) -> None:
        service = self._service
        service.close_steps("ok", "the run has ended")
        outbound.publish(service, now)
        service.out.tell(f"ended tick={service.state.tick} hash={service.digest()} run={service.state.run}")
        if service.options.quit_at_end:
            service.exit = 0

    def _verdicts(self, now: float) -> list[Verdict]:
        service = self._service
        verdicts = service.barrier.verdicts() if service.lockstep else []
        if not service.strict:
            verdicts += [Verdict(agent=agent, code="silent") for agent in service.leases.silent(now)]
        for agent, bridge in service.bridges.items():
            verdicts += self._judge_bridge(agent, bridge, now)
        here = service.state.body_set.figures
        return [verdict for verdict in verdicts if verdict.agent in here]

    def _judge_bridge(self, agent: str, bridge: Bridge, now: float) -> list[Verdict]:
        service = self._service
        found: list[Verdict] = []
        if not service.strict:
            realtime = service.options.pace == "realtime"
            limit = max(3.0 * service.metronome.interval if realtime else 0.0, STALE_AFTER)
            # In lockstep a pose is awaited: only a missed one is old.
            stale = bridge.at == float("-inf") if service.lockstep else now - bridge.at > limit
            if stale != bridge.stale:
                bridge.stale = stale
                found.append(Verdict(agent=agent, code="stale" if stale else "fresh"))
        halted = outbound.is_hardware(service, agent) and (
            service.options.pace != "realtime" or service.metronome.speed != 1.0
        )
        if halted != bridge.halted:
            bridge.halted = halted
            found.append(Verdict(agent=agent, code="halt" if halted else "unhalt"))
        return found
