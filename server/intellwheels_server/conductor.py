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
from intellwheels_server import membership, publication, reception, verbs, world
from intellwheels_server.arrival import Arrival, Ask, Put, Token
from intellwheels_server.branch import Branch
from intellwheels_server.desk import Bridge, Desk, Options, Outlet, Recorder
from intellwheels_server.inputs import (
    Inputs,
    Verdict,
)
from intellwheels_server.world import State

STALE_AFTER: Final = 0.3
"""Seconds without a pose, or three cycles if they are longer, after which a real body is stale."""


class Conductor:
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
        """Begin a run; takes what `Desk` takes."""
        self._desk = Desk(options, outlet, floor_of, wall, record, run)

    @property
    def exit(self) -> int | None:
        """The process's exit code once the service is over, else None."""
        return self._desk.exit

    @property
    def state(self) -> State:
        """The world."""
        return self._desk.state

    def digest(self) -> str:
        """Return the hash of the state."""
        return self._desk.digest()

    def tell(self, witness: Callable[[Event], None]) -> None:
        """Tell somebody each event as it is, before what is hidden is left out."""
        self._desk.witness = witness

    def begin(self) -> None:
        """Publish what there is to know before anything happens."""
        desk = self._desk
        publication.publish_map(desk)

    def take(self, arrival: Arrival, now: float) -> None:
        """Take in what arrived. The world does not move."""
        desk = self._desk
        if isinstance(arrival, Put):
            reception.take_put(desk, arrival, now)
        elif isinstance(arrival, Token):
            membership.take_token(desk, arrival, now)
        else:
            self._take_ask(arrival, now)

    def work(self, now: float) -> None:
        """Do all that is due; at most one step is made."""
        desk = self._desk
        if desk.exit is not None:
            return
        membership.expire(desk, now)
        if desk.pending and desk.may_change():
            desk.change(now)
        if desk.held and self._may_begin():
            self._begin_run(now)
        self._move(now)
        if desk.cadence.ready(now):
            publication.publish(desk, now)
        publication.rest_real(desk, now)

    def due(self, now: float) -> float:
        """Return when `work` must be called next if nothing arrives; `now` or less: at once."""
        desk = self._desk
        times = [desk.cadence.due(), desk.leases.due(), desk.roster.due(desk.options.grace)]
        times += [waiting.until for waiting in desk.waiting]
        if desk.bridges and desk.stands():
            times.append(desk.idle_power_at)
        if (desk.pending and desk.may_change()) or (desk.held and self._may_begin()):
            return now
        if not desk.stands():
            if not desk.lockstep:
                times.append(desk.metronome.due() if desk.options.pace == "realtime" else now)
            elif desk.open:
                if desk.barrier.complete(now):
                    return now
                times.append(desk.barrier.due())
            elif desk.members or desk.steps:
                return now
        return min(times)

    def finish(self, now: float) -> None:
        """Publish and record what is left before the service ends."""
        desk = self._desk
        desk.close_steps("failed", "the simulator ends")
        for waiting in desk.waiting:
            waiting.ask.close()
        desk.waiting.clear()
        publication.publish(desk, now)
        for agent in desk.bridges:
            publication.put_power(
                desk,
                agent,
                PowerInForce(run=desk.state.run, tick=desk.state.tick, left_motor=0.0, right_motor=0.0, state="paused"),
            )
        if desk.changes and desk.record is not None:
            desk.record(desk.state.tick, Inputs(changes=tuple(desk.changes)), desk.digest(), stepped=False)
            desk.changes.clear()

    def _take_ask(self, ask: Ask, now: float) -> None:
        desk = self._desk
        match ask.topic:
            case "join":
                membership.ask_join(desk, ask, now)
            case "leave":
                membership.ask_leave(desk, ask)
            case "ctl":
                verbs.ask_ctl(desk, ask, now)
            case _:
                publication.ask_what_is(desk, ask, now)

    def _may_begin(self) -> bool:
        desk = self._desk
        return not desk.missing()

    def _begin_run(self, now: float) -> None:
        desk = self._desk
        desk.held = False
        desk.metronome.start(now)
        desk.cadence.note()
        desk.out.tell(f"running tick={desk.state.tick} run={desk.state.run}")
        if not desk.lockstep:
            publication.put_all_measures(desk)

    def _move(self, now: float) -> None:
        desk = self._desk
        if desk.stands():
            return
        if desk.lockstep:
            self._move_in_lockstep(now)
        elif desk.options.pace == "free":
            self._step(now)
        elif now >= desk.metronome.due():
            desk.metronome.began(now)
            self._step(now)

    def _move_in_lockstep(self, now: float) -> None:
        desk = self._desk
        barrier = desk.barrier
        if not desk.open:
            if desk.members:
                self._open_barrier(now)
            elif desk.steps is not None:
                self._step(now)
            return
        if not barrier.complete(now):
            missed = barrier.missed(now)
            if missed and desk.strict:
                desk.miss(missed[0][0])
                return
            for agent, kind in missed:
                desk.out.note(f"late agent={agent} tick={desk.state.tick}")
                if kind == "pose" and agent in desk.bridges:
                    desk.bridges[agent].at = float("-inf")
            for agent in barrier.to_repeat(now):
                publication.put_measures(desk, agent)
        if barrier.complete(now):
            self._step(now)

    def _open_barrier(self, now: float) -> None:
        desk = self._desk
        desk.open = True
        publication.put_all_measures(desk)
        desk.barrier.open(desk.members, now)

    def _step(self, now: float) -> None:
        desk = self._desk
        closed = desk.state.tick
        inputs = desk.tray.collect((), self._verdicts(now))
        branch = desk.options.branch
        told = branch.inputs(closed) if branch is not None else None
        state, outputs = world.advance(desk.state, inputs if told is None else told)
        desk.state = state
        if branch is not None and told is not None:
            inputs = told
            self._compare(branch, closed)
        for event in outputs.events:
            desk.put_event(event)
        if desk.record is not None:
            if desk.changes:
                inputs = msgspec.structs.replace(inputs, changes=tuple(desk.changes))
            desk.record(closed, inputs, desk.digest(), stepped=True)
        desk.changes.clear()
        desk.open = False
        desk.tachometer.ticked(now)
        desk.cadence.note()
        if desk.bridges:
            publication.put_powers(desk, closed)
        if desk.pending:
            desk.change(now)
        if state.ended and desk.state.ended:
            self._end(now)
        elif desk.steps is not None:
            desk.steps.left -= 1
            if desk.steps.left <= 0:
                desk.close_steps("ok", None)
                publication.publish(desk, now)
        if desk.held or desk.exit is not None:
            return
        if not desk.lockstep:
            publication.put_all_measures(desk)
        elif desk.members:
            self._open_barrier(now)

    def _compare(self, branch: Branch, tick: int) -> None:
        """End a branch that is not as its parent was; tell where it is free."""
        desk = self._desk
        differs = branch.differs(tick, desk.digest())
        if differs is not None:
            desk.out.note(f"branch {differs}; its bodies and options of bodies must be the parent's")
            desk.out.tell(f"differs tick={tick + 1}")
            desk.exit = 1
        elif tick + 1 == branch.at:
            desk.out.tell(f"branched tick={branch.at} hash={desk.digest()}")

    def _end(self, now: float) -> None:
        desk = self._desk
        desk.close_steps("ok", "the run has ended")
        publication.publish(desk, now)
        desk.out.tell(f"ended tick={desk.state.tick} hash={desk.digest()} run={desk.state.run}")
        if desk.options.quit_at_end:
            desk.exit = 0

    def _verdicts(self, now: float) -> list[Verdict]:
        desk = self._desk
        verdicts = desk.barrier.verdicts() if desk.lockstep else []
        if not desk.strict:
            verdicts += [Verdict(agent=agent, code="silent") for agent in desk.leases.silent(now)]
        for agent, bridge in desk.bridges.items():
            verdicts += self._judge_bridge(agent, bridge, now)
        here = desk.state.fleet.figures
        return [verdict for verdict in verdicts if verdict.agent in here]

    def _judge_bridge(self, agent: str, bridge: Bridge, now: float) -> list[Verdict]:
        desk = self._desk
        found: list[Verdict] = []
        if not desk.strict:
            realtime = desk.options.pace == "realtime"
            limit = max(3.0 * desk.metronome.interval if realtime else 0.0, STALE_AFTER)
            # In lockstep a pose is awaited: only a missed one is old.
            stale = bridge.at == float("-inf") if desk.lockstep else now - bridge.at > limit
            if stale != bridge.stale:
                bridge.stale = stale
                found.append(Verdict(agent=agent, code="stale" if stale else "fresh"))
        halted = publication.is_hardware(desk, agent) and (
            desk.options.pace != "realtime" or desk.metronome.speed != 1.0
        )
        if halted != bridge.halted:
            bridge.halted = halted
            found.append(Verdict(agent=agent, code="halt" if halted else "unhalt"))
        return found
