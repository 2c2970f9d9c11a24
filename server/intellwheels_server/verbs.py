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
from intellwheels_server import membership, publication, slots
from intellwheels_server.admission import OPERATOR, new_hex
from intellwheels_server.anew import begin_anew
from intellwheels_server.arrival import Ask
from intellwheels_server.desk import Desk, Steps
from intellwheels_server.inputs import (
    DeleteBody,
    GoOn,
    Note,
    Restart,
    SpawnBody,
    Speech,
    TakeBody,
    TeleportBody,
)
from intellwheels_server.world import Outcome


def ask_ctl(desk: Desk, ask: Ask, now: float) -> None:
    """Take an operator's wish; it is answered with how it went."""
    message = read_verb(desk, ask)
    if message is None:
        return
    match ask.name:
        case "seek":
            ask.reply(desk.result("unsupported", "this run is live: only a log that is played can be sought"))
        case "pause":
            _pause(desk, ask, now)
        case "resume":
            _resume(desk, ask, now)
        case "step":
            _step_on(desk, ask, message, now)
        case "quit":
            ask.reply(desk.result("ok"))
            desk.out.note(f"quit tick={desk.state.tick}")
            desk.exit = 0
        case _:
            desk.later(partial(_VERBS[ask.name], desk, ask, message))


def read_verb(desk: Desk, ask: Ask) -> Record | None:
    """Return what is asked for; None when it cannot be read, which the asker is told."""
    cls = VERB_CLASSES.get(ask.name)
    if cls is None:
        ask.refuse(desk.result("unsupported", "no such verb"))
        return None
    try:
        # A verb without fields needs no bytes.
        data = ask.data or b"{}"
        message: Record = decode(cls, data, encoding_of(ask.encoding, data) if ask.data else Encoding.JSON)
    except WireError as error:
        ask.refuse(desk.result("failed", error.text))
        return None
    desk.out.note(f"asked verb={ask.name} tick={desk.state.tick}")
    return message


def _pause(desk: Desk, ask: Ask, now: float) -> None:
    if not desk.paused:
        desk.paused = True
        desk.tachometer.stop()
        desk.change(now)
        desk.apply(Note(code="paused"), now)
        publication.publish(desk, now)
        desk.idle_power_at = now
    ask.reply(desk.result("ok"))


def _resume(desk: Desk, ask: Ask, now: float) -> None:
    desk.close_steps("incorrect-state", "resumed before all steps were made")
    desk.change_if(now)
    if desk.state.ended:
        desk.apply(GoOn(), now)
    if desk.paused:
        desk.apply(Note(code="resumed"), now)
        desk.paused = False
    desk.metronome.start(now)
    desk.barrier.rearm(now)
    desk.tachometer.stop()
    desk.cadence.note()
    ask.reply(desk.result("ok"))


def _step_on(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    step: Step = message
    if not desk.paused:
        ask.reply(desk.result("incorrect-state", "expected a paused run"))
    elif desk.state.ended:
        ask.reply(desk.result("incorrect-state", "the run has ended; resume to go on"))
    elif desk.steps is not None:
        ask.reply(desk.result("incorrect-state", "steps are being made"))
    elif desk.held:
        ask.reply(desk.result("incorrect-state", f"waiting for {', '.join(desk.missing())}"))
    else:
        desk.steps = Steps(step.count, ask)
        desk.metronome.start(now)
        desk.barrier.rearm(now)


def _do_reset(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    reset: Reset = message
    seed = reset.seed if reset.seed is not None else desk.state.setup.seed
    _restart(desk, ask, Restart(run=new_hex(), seed=seed, end=reset.end), now)


def _do_load(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    load: Load = message
    seed = load.seed if load.seed is not None else desk.state.setup.seed
    try:
        floor = desk.floor_of(load)
    except WireError as error:
        ask.reply(desk.result("not-found" if load.map is None else "failed", error.text))
        return
    _restart(desk, ask, Restart(run=new_hex(), seed=seed, map=floor, end=load.end), now)


def _restart(desk: Desk, ask: Ask, restart: Restart, now: float) -> None:
    before = desk.state
    try:
        outcome = desk.apply(restart, now)
    except ValueError as error:  # a floor that only the world finds wrong
        if restart.map is None:
            raise
        ask.reply(desk.result("failed", f"Load.Map: {error}"))
        return
    if outcome.code != "ok":
        ask.reply(desk.result(outcome.code, outcome.text))
        return
    for agent in before.names:
        desk.leases.free(agent)
    for bridge in desk.bridges.values():
        bridge.at, bridge.stale = now, False
    begin_anew(desk, before, now)
    ask.reply(desk.result("ok"))


def _do_speed(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    speed: Speed = message
    if desk.options.pace != "realtime":
        ask.reply(desk.result("incorrect-state", f"the pace is {desk.options.pace}: only real time has a speed"))
        return
    desk.metronome.change_speed(speed.factor, now)
    desk.tachometer.stop()
    desk.apply(Note(code="speed", speed=min(speed.factor, 100.0)), now)
    ask.reply(desk.result("ok"))


def _do_spawn(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    spawn: Spawn = message
    if spawn.robot.name == OPERATOR:
        ask.reply(desk.result("failed", f"Spawn.Robot.Name: the name '{OPERATOR}' is reserved for people"))
        return
    outcome = desk.apply(SpawnBody(robot=spawn.robot, position=spawn.position), now)
    if outcome.code == "ok" and spawn.robot.name is not None:
        desk.out.body(spawn.robot.name, publication.body_of(desk, spawn.robot.name))
    _reply_outcome(desk, ask, outcome)


def _do_delete(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    delete: Delete = message
    outcome = desk.apply(DeleteBody(agent=delete.agent), now)
    if outcome.code == "ok":
        seats = desk.roster.seats(delete.agent)
        membership.forget_body(desk, delete.agent)
        if seats:
            membership.dismiss(desk, seats[0])
        else:
            desk.out.farewell(delete.agent)
    _reply_outcome(desk, ask, outcome)


def _do_teleport(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    teleport: Teleport = message
    change = TeleportBody(agent=teleport.agent, position=teleport.position)
    _reply_outcome(desk, ask, desk.apply(change, now))


def _do_take(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    take: Take = message
    agent, holder = take.agent, desk.leases.holder(take.agent)
    if agent not in desk.state.fleet.figures:
        ask.reply(desk.result("not-found", f"no agent '{agent}' here"))
    elif holder is not None and take.lease != holder:
        ask.reply(desk.result("incorrect-state", f"agent '{agent}' is taken by somebody else"))
    elif holder is None and take.lease is not None and take.seconds > 0.0:
        ask.reply(desk.result("incorrect-state", f"agent '{agent}': this lease is over; take it anew"))
    elif take.seconds == 0.0:
        desk.leases.free(agent)
        if holder is not None:
            desk.apply(TakeBody(agent=agent, on=False), now)
        ask.reply(desk.result("ok"))
    else:
        lease = holder or new_hex()
        desk.leases.grant(agent, lease, take.seconds, now)
        if holder is None:
            desk.apply(TakeBody(agent=agent, on=True), now)
        ask.reply(msgspec.structs.replace(desk.result("ok"), lease=lease))


def _do_say(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    say: OperatorSay = message
    limit = desk.state.setup.say_limit
    if len(say.text) > limit:
        ask.reply(desk.result("failed", f"Say: expected at most {limit} characters, got {len(say.text)}"))
        return
    _reply_outcome(desk, ask, desk.apply(Speech(text=say.text, to=say.to), now))


def _reply_outcome(desk: Desk, ask: Ask, outcome: Outcome) -> None:
    ask.reply(desk.result(outcome.code, outcome.text or None))


_VERBS: Final[Mapping[str, Callable[..., None]]] = {
    "reset": _do_reset,
    "load": _do_load,
    "speed": _do_speed,
    "spawn": _do_spawn,
    "delete": _do_delete,
    "teleport": _do_teleport,
    "take": _do_take,
    "say": _do_say,
    "save": slots.save,
    "restore": slots.restore,
}
