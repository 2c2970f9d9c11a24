"""Handles the requests of operators, `ctl/<verb>` and `ctl/<verb>/<agent>`.

The class of the message decides which function handles it. `handle` has the messages that act at once; it queues all
others for `change`, which has those that change the world.
"""

from __future__ import annotations

from functools import partial, singledispatch

import msgspec

from intellwheels_schemas.channels import VERB_CLASSES
from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import RequestRefusedError, WireError
from intellwheels_schemas.file_records import (
    DeleteBody,
    GoOn,
    Note,
    Restart,
    SpawnBody,
    Speech,
    TakeBody,
    TeleportBody,
)
from intellwheels_schemas.keys import AGENT_VERBS
from intellwheels_schemas.messages import (
    Delete,
    OperatorSay,
    Pause,
    Quit,
    Record,
    Reset,
    Restore,
    Resume,
    Save,
    Seek,
    Spawn,
    Speed,
    Step,
    Take,
    Teleport,
)
from intellwheels_server.service import body_places, joining, outbound, saved_states
from intellwheels_server.service.arrival import Query
from intellwheels_server.service.error_replies import DELETED
from intellwheels_server.service.floor_queue import MAX_LOADS
from intellwheels_server.service.load_floor import LoadedFloor, LoadFault, LoadRequest
from intellwheels_server.service.new_run import begin_new_run
from intellwheels_server.service.pacing import PendingSteps
from intellwheels_server.service.roster import OPERATOR, new_hex
from intellwheels_server.service.sensor_budget import check_sensor_budget
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world import Outcome, Walls

MAX_NOTED_SPEED = 100.0
"""Largest speed that an event can carry."""
IN_ORDER = (Reset, Restore, Save, Spawn, Delete, Teleport)
"""Messages that do not overtake a load, as they mean another thing on another map."""


def handle_control(service: ServiceState, query: Query, now: float) -> None:
    """Handle a control message and send its result."""
    if query.name == "load":
        _queue_load(service, query, now)
        return
    message = read_message(service, query)
    if message is not None:
        handle(message, service, query, now)


def read_message(service: ServiceState, query: Query) -> Record | None:
    """Return the control message of a query. If it cannot be read, send an error reply and return None."""
    cls = VERB_CLASSES.get(query.name)
    if cls is None and query.has_wildcards:  # it asks for whatever there is, and a verb is nothing to get
        query.close()
        return None
    if cls is None:
        query.refuse(service.result("unsupported", "no such verb"))
        return None
    try:
        # A verb without fields needs no bytes.
        data = query.data or b"{}"
        message: Record = decode(cls, data, encoding_of(query.encoding, data) if query.data else Encoding.JSON)
    except WireError as error:
        query.refuse(service.result("failed", error.text))
        return None
    if query.name in AGENT_VERBS:
        wrong = _wrong_agent(message, query)
        if wrong:
            query.refuse(service.result("failed", wrong))
            return None
    about = f" agent={query.agent}" if query.agent else ""
    service.publisher.outlet.log_line(f"asked verb={query.name}{about} tick={service.run.state.tick}")
    return message


def _wrong_agent(message: Record, query: Query) -> str:
    """Return what is wrong with the agent of a verb that is about one; empty if it is right."""
    named = getattr(message, "agent", None)
    if not query.agent:
        return f"ctl/{query.name}: expected ctl/{query.name}/<agent>, got no name of an agent in the key"
    if named not in (None, query.agent):
        return f"{type(message).__name__}.Agent: expected '{query.agent}' as in the key, got '{named}'"
    return ""


# ------------------------------------------------------------ messages that act at once


@singledispatch
def handle(message: Record, service: ServiceState, query: Query, _now: float) -> None:
    """Handle a control message at once, or queue it if it changes the world."""
    request = partial(change, message, service, query)
    if service.floors.is_empty or not isinstance(message, IN_ORDER):
        service.queue_change(request)
    else:
        service.floors.add(request)


@handle.register
def _seek(_message: Seek, service: ServiceState, query: Query, _now: float) -> None:
    query.reply(service.result("unsupported", "this run is live; only a playback can seek"))


@handle.register
def _quit(_message: Quit, service: ServiceState, query: Query, _now: float) -> None:
    query.reply(service.result("ok"))
    service.publisher.outlet.log_line(f"quit tick={service.run.state.tick}")
    service.exit = 0


@handle.register
def _pause(_message: Pause, service: ServiceState, query: Query, now: float) -> None:
    stepping = service.pacing.steps is not None
    service.answer_steps("incorrect-state", "paused before all steps were made")
    if stepping:
        service.pacing.real_time_factor.reset()
        outbound.publish(service, now)
        service.publisher.idle_power_at = now
    elif not service.pacing.paused:
        service.pacing.paused = True
        service.pacing.real_time_factor.reset()
        service.make_queued_changes(now)
        service.apply(Note(code="paused"))
        outbound.publish(service, now)
        service.publisher.idle_power_at = now
    query.reply(service.result("ok"))


@handle.register
def _resume(_message: Resume, service: ServiceState, query: Query, now: float) -> None:
    pacing = service.pacing
    service.answer_steps("incorrect-state", "resumed before all steps were made")
    if service.may_change():
        service.make_queued_changes(now)
    if service.run.state.ended:
        service.apply(GoOn())
    if pacing.paused:
        service.apply(Note(code="resumed"))
        pacing.paused = False
    pacing.start_clock(now)
    service.agents.count_silence_from(now)
    pacing.real_time_factor.reset()
    service.publisher.schedule.mark_changed()
    query.reply(service.result("ok"))


@handle.register
def _step(message: Step, service: ServiceState, query: Query, now: float) -> None:
    pacing = service.pacing
    if not pacing.paused:
        query.reply(service.result("incorrect-state", "expected a paused run"))
    elif service.run.state.ended:
        query.reply(service.result("incorrect-state", "the run has ended; resume continues it"))
    elif pacing.steps is not None:
        query.reply(service.result("incorrect-state", "steps are being made"))
    elif pacing.waiting_to_start:
        query.reply(service.result("incorrect-state", f"waiting for {', '.join(service.missing_agents())}"))
    else:
        pacing.steps = PendingSteps(message.count, query)
        pacing.start_clock(now)
        service.agents.count_silence_from(now)


# ------------------------------------------------------------ messages that change the world


@singledispatch
def change(message: Record, _service: ServiceState, _query: Query, _now: float) -> None:
    """Change the world as a control message asks, and answer it."""
    raise TypeError(f"expected a control message, got {message!r}")


@change.register
def _reset(message: Reset, service: ServiceState, query: Query, now: float) -> None:
    seed = message.seed if message.seed is not None else service.run.state.setup.seed
    _restart(service, query, Restart(run=new_hex(), seed=seed, end=message.end), now)


def _queue_load(service: ServiceState, query: Query, now: float) -> None:
    """Load a floor beside the world, as that may take long; even reading the request may."""
    service.publisher.outlet.log_line(f"asked verb=load tick={service.run.state.tick}")
    request = LoadRequest(query.data, query.encoding)
    if not service.floors.add_load(request, partial(_begin_on_floor, service, query), now):
        query.reply(service.result("failed", f"Load: expected at most {MAX_LOADS} that wait, got more; ask again"))


def _begin_on_floor(service: ServiceState, query: Query, found: LoadedFloor | LoadFault, now: float) -> None:
    if isinstance(found, LoadFault):
        answer = query.refuse if found.malformed else query.reply
        answer(service.result(found.code, found.text))
        return
    seed = found.seed if found.seed is not None else service.run.state.setup.seed
    restart = Restart(run=new_hex(), seed=seed, map=found.floor, end=found.end)
    _restart(service, query, restart, now, found.walls)


def _restart(service: ServiceState, query: Query, restart: Restart, now: float, walls: Walls | None = None) -> None:
    before = service.run.state
    outcome = service.apply(restart, walls)
    if outcome.code != "ok":
        query.reply(service.result(outcome.code, outcome.text))
        return
    for agent in before.names:
        service.agents.leases.release(agent)
    for bridge in service.agents.bridges.values():
        bridge.reported_at, bridge.stale = now, False
    begin_new_run(service, before, now)
    query.reply(service.result("ok"))


@change.register
def _speed(message: Speed, service: ServiceState, query: Query, now: float) -> None:
    pacing = service.pacing
    if pacing.pace != "realtime":
        query.reply(service.result("incorrect-state", f"the pace is {pacing.pace}; only realtime has a speed"))
        return
    pacing.metronome.change_speed(message.factor, now)
    pacing.real_time_factor.reset()
    service.apply(Note(code="speed", speed=min(message.factor, MAX_NOTED_SPEED)))
    query.reply(service.result("ok"))


@change.register
def _spawn(message: Spawn, service: ServiceState, query: Query, _now: float) -> None:
    name = message.robot.name
    if name == OPERATOR:
        query.reply(service.result("failed", f"Spawn.Robot.Name: the name '{OPERATOR}' is reserved for people"))
        return
    try:
        check_sensor_budget(service, name or "", message.robot)
    except RequestRefusedError as refusal:
        query.reply(service.result("failed", f"Spawn.{refusal.text}"))
        return
    # An operator may put a body anywhere. One that goes to any place leaves those of the scene's agents free.
    anywhere = message.position is None and message.robot.position is None and message.robot.place is None
    reserved = body_places.reserved_places(service) if anywhere else ()
    outcome = service.apply(SpawnBody(robot=message.robot, position=message.position, reserved=reserved))
    if outcome.code == "ok" and name is not None:
        outbound.publish_body(service, name)
    _reply(service, query, outcome)


@change.register
def _delete(_message: Delete, service: ServiceState, query: Query, now: float) -> None:
    agent = query.agent
    outcome = service.apply(DeleteBody(agent=agent))
    if outcome.code == "ok":
        members = service.agents.roster.members(agent)
        joining.forget_body(service, agent)
        if members:
            outbound.send_error(service, agent, DELETED, now)
            mind = service.agents.roster.mind(agent)
            service.agents.deleted[agent] = (mind or members[0]).session
            joining.remove_member(service, members[0])
        else:
            service.publisher.outlet.undeclare_agent(agent)
    _reply(service, query, outcome)


@change.register
def _teleport(message: Teleport, service: ServiceState, query: Query, _now: float) -> None:
    _reply(service, query, service.apply(TeleportBody(agent=query.agent, position=message.position)))


@change.register
def _take(message: Take, service: ServiceState, query: Query, now: float) -> None:
    agent, leases = query.agent, service.agents.leases
    active = leases.active(agent)
    if agent not in service.run.state.body_set.models:
        query.reply(service.result("not-found", f"no agent '{agent}' here"))
    elif active is not None and message.lease != active:
        query.reply(service.result("incorrect-state", f"agent '{agent}' is taken by somebody else"))
    elif active is None and message.lease is not None and message.seconds > 0.0:
        query.reply(service.result("incorrect-state", f"agent '{agent}': this lease has ended; take it again"))
    elif message.seconds == 0.0:
        leases.release(agent)
        if active is not None:
            service.apply(TakeBody(agent=agent, on=False))
        query.reply(service.result("ok"))
    else:
        lease = active or new_hex()
        leases.grant(agent, lease, message.seconds, now)
        if active is None:
            service.apply(TakeBody(agent=agent, on=True))
        query.reply(msgspec.structs.replace(service.result("ok"), lease=lease))


@change.register
def _say(message: OperatorSay, service: ServiceState, query: Query, _now: float) -> None:
    limit = service.run.state.setup.say_limit
    if len(message.text) > limit:
        query.reply(service.result("failed", f"Say: expected at most {limit} characters, got {len(message.text)}"))
        return
    _reply(service, query, service.apply(Speech(text=message.text, to=message.to)))


@change.register
def _save(_message: Save, service: ServiceState, query: Query, _now: float) -> None:
    saved_states.save(service, query)


@change.register
def _restore(message: Restore, service: ServiceState, query: Query, now: float) -> None:
    saved_states.restore(service, query, message, now)


def _reply(service: ServiceState, query: Query, outcome: Outcome) -> None:
    query.reply(service.result(outcome.code, outcome.text or None))
