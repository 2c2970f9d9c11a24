"""What operators ask for with `ctl/<verb>`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

import msgspec

from intellwheels_schemas.channels import VERB_CLASSES
from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    Delete,
    Load,
    OperatorSay,
    Record,
    Reset,
    Spawn,
    Speed,
    Step,
    Take,
    Teleport,
)
from intellwheels_server.service import joining, outbound, saved_states
from intellwheels_server.service.arrival import Ask
from intellwheels_server.service.new_run import begin_new_run
from intellwheels_server.service.roster import OPERATOR, new_hex
from intellwheels_server.service.service_state import ServiceState, Steps
from intellwheels_server.world import Outcome
from intellwheels_server.world.inputs import (
    DeleteBody,
    GoOn,
    Note,
    Restart,
    SpawnBody,
    Speech,
    TakeBody,
    TeleportBody,
)


def ask_ctl(service: ServiceState, ask: Ask, now: float) -> None:
    """Take an operator's wish; it is answered with how it went."""
    message = read_verb(service, ask)
    if message is None:
        return
    match ask.name:
        case "seek":
            ask.reply(service.result("unsupported", "this run is live: only a log that is played can be sought"))
        case "pause":
            _pause(service, ask, now)
        case "resume":
            _resume(service, ask, now)
        case "step":
            _step_on(service, ask, message, now)
        case "quit":
            ask.reply(service.result("ok"))
            service.out.note(f"quit tick={service.state.tick}")
            service.exit = 0
        case _:
            service.later(partial(_VERBS[ask.name], service, ask, message))


def read_verb(service: ServiceState, ask: Ask) -> Record | None:
    """Return what is asked for; None when it cannot be read, which the asker is told."""
    cls = VERB_CLASSES.get(ask.name)
    if cls is None:
        ask.refuse(service.result("unsupported", "no such verb"))
        return None
    try:
        # A verb without fields needs no bytes.
        data = ask.data or b"{}"
        message: Record = decode(cls, data, encoding_of(ask.encoding, data) if ask.data else Encoding.JSON)
    except WireError as error:
        ask.refuse(service.result("failed", error.text))
        return None
    service.out.note(f"asked verb={ask.name} tick={service.state.tick}")
    return message


def _pause(service: ServiceState, ask: Ask, now: float) -> None:
    if not service.paused:
        service.paused = True
        service.tachometer.stop()
        service.change(now)
        service.apply(Note(code="paused"), now)
        outbound.publish(service, now)
        service.idle_power_at = now
    ask.reply(service.result("ok"))


def _resume(service: ServiceState, ask: Ask, now: float) -> None:
    service.close_steps("incorrect-state", "resumed before all steps were made")
    service.change_if(now)
    if service.state.ended:
        service.apply(GoOn(), now)
    if service.paused:
        service.apply(Note(code="resumed"), now)
        service.paused = False
    service.metronome.start(now)
    service.barrier.rearm(now)
    service.tachometer.stop()
    service.cadence.note()
    ask.reply(service.result("ok"))


def _step_on(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    step: Step = message
    if not service.paused:
        ask.reply(service.result("incorrect-state", "expected a paused run"))
    elif service.state.ended:
        ask.reply(service.result("incorrect-state", "the run has ended; resume to go on"))
    elif service.steps is not None:
        ask.reply(service.result("incorrect-state", "steps are being made"))
    elif service.held:
        ask.reply(service.result("incorrect-state", f"waiting for {', '.join(service.missing())}"))
    else:
        service.steps = Steps(step.count, ask)
        service.metronome.start(now)
        service.barrier.rearm(now)


def _do_reset(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    reset: Reset = message
    seed = reset.seed if reset.seed is not None else service.state.setup.seed
    _restart(service, ask, Restart(run=new_hex(), seed=seed, end=reset.end), now)


def _do_load(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    load: Load = message
    seed = load.seed if load.seed is not None else service.state.setup.seed
    try:
        floor = service.floor_of(load)
    except WireError as error:
        ask.reply(service.result("not-found" if load.map is None else "failed", error.text))
        return
    _restart(service, ask, Restart(run=new_hex(), seed=seed, map=floor, end=load.end), now)


def _restart(service: ServiceState, ask: Ask, restart: Restart, now: float) -> None:
    before = service.state
    try:
        outcome = service.apply(restart, now)
    except ValueError as error:  # a floor that only the world finds wrong
        if restart.map is None:
            raise
        ask.reply(service.result("failed", f"Load.Map: {error}"))
        return
    if outcome.code != "ok":
        ask.reply(service.result(outcome.code, outcome.text))
        return
    for agent in before.names:
        service.leases.free(agent)
    for bridge in service.bridges.values():
        bridge.at, bridge.stale = now, False
    begin_new_run(service, before, now)
    ask.reply(service.result("ok"))


def _do_speed(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    speed: Speed = message
    if service.options.pace != "realtime":
        ask.reply(service.result("incorrect-state", f"the pace is {service.options.pace}: only real time has a speed"))
        return
    service.metronome.change_speed(speed.factor, now)
    service.tachometer.stop()
    service.apply(Note(code="speed", speed=min(speed.factor, 100.0)), now)
    ask.reply(service.result("ok"))


def _do_spawn(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    spawn: Spawn = message
    if spawn.robot.name == OPERATOR:
        ask.reply(service.result("failed", f"Spawn.Robot.Name: the name '{OPERATOR}' is reserved for people"))
        return
    outcome = service.apply(SpawnBody(robot=spawn.robot, position=spawn.position), now)
    if outcome.code == "ok" and spawn.robot.name is not None:
        service.out.body(spawn.robot.name, outbound.body_of(service, spawn.robot.name))
    _reply_outcome(service, ask, outcome)


def _do_delete(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    delete: Delete = message
    outcome = service.apply(DeleteBody(agent=delete.agent), now)
    if outcome.code == "ok":
        seats = service.roster.seats(delete.agent)
        joining.forget_body(service, delete.agent)
        if seats:
            joining.dismiss(service, seats[0])
        else:
            service.out.farewell(delete.agent)
    _reply_outcome(service, ask, outcome)


def _do_teleport(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    teleport: Teleport = message
    change = TeleportBody(agent=teleport.agent, position=teleport.position)
    _reply_outcome(service, ask, service.apply(change, now))


def _do_take(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    take: Take = message
    agent, holder = take.agent, service.leases.holder(take.agent)
    if agent not in service.state.body_set.figures:
        ask.reply(service.result("not-found", f"no agent '{agent}' here"))
    elif holder is not None and take.lease != holder:
        ask.reply(service.result("incorrect-state", f"agent '{agent}' is taken by somebody else"))
    elif holder is None and take.lease is not None and take.seconds > 0.0:
        ask.reply(service.result("incorrect-state", f"agent '{agent}': this lease is over; take it anew"))
    elif take.seconds == 0.0:
        service.leases.free(agent)
        if holder is not None:
            service.apply(TakeBody(agent=agent, on=False), now)
        ask.reply(service.result("ok"))
    else:
        lease = holder or new_hex()
        service.leases.grant(agent, lease, take.seconds, now)
        if holder is None:
            service.apply(TakeBody(agent=agent, on=True), now)
        ask.reply(msgspec.structs.replace(service.result("ok"), lease=lease))


def _do_say(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    say: OperatorSay = message
    limit = service.state.setup.say_limit
    if len(say.text) > limit:
        ask.reply(service.result("failed", f"Say: expected at most {limit} characters, got {len(say.text)}"))
        return
    _reply_outcome(service, ask, service.apply(Speech(text=say.text, to=say.to), now))


def _reply_outcome(service: ServiceState, ask: Ask, outcome: Outcome) -> None:
    ask.reply(service.result(outcome.code, outcome.text or None))


_VERBS: Final[Mapping[str, Callable[..., None]]] = {
    "reset": _do_reset,
    "load": _do_load,
    "speed": _do_speed,
    "spawn": _do_spawn,
    "delete": _do_delete,
    "teleport": _do_teleport,
    "take": _do_take,
    "say": _do_say,
    "save": saved_states.save,
    "restore": saved_states.restore,
}
