"""Messages of agents and users, checked against membership, session, tick and limits and kept for the next step."""

from __future__ import annotations

import difflib

import msgspec

from intellwheels_schemas.codec import decode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown
from intellwheels_schemas.keys import IN_KINDS
from intellwheels_schemas.messages import (
    Actions,
    Pose,
    Say,
    UserInput,
)
from intellwheels_schemas.metal_codes import is_genuine, pose_line
from intellwheels_server.service import leaving
from intellwheels_server.service.arrival import Put
from intellwheels_server.service.barrier import Answered, AnswerKind
from intellwheels_server.service.command_ages import has_command
from intellwheels_server.service.error_replies import DELETED, Fault, flooding
from intellwheels_server.service.input_latch import check_time
from intellwheels_server.service.outbound import send_error, send_unasked_error
from intellwheels_server.service.pacing import Pacing
from intellwheels_server.service.roster import Member, check_session
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world import State


def take_put(service: ServiceState, put: Put, now: float) -> None:
    """Take a message on a key of an agent; the agent gets an error if something is wrong with it."""
    agent, kind, pacing = put.agent, put.kind, service.pacing
    if kind == "stray":
        if service.message_limit.admit(f"stray/{agent}", service.run.state.tick, now):
            _report_stray(service, put, now)
        return
    if kind in ("actions", "pose") and pacing.barrier_open and pacing.barrier.repeats(agent, kind, put.data):
        return
    # A user who floods must not use up what the agent itself may send. No agent's name has a slash.
    sender = agent if kind != "user" else f"user/{agent}"
    if not service.message_limit.admit(sender, service.run.state.tick, now):
        send_error(service, agent, flooding(kind), now)
        return
    if put.size > len(put.data):
        send_error(service, agent, Fault("too-long", f"{kind}: expected fewer bytes, got {put.size}"), now)
        return
    try:
        encoding = encoding_of(put.encoding, put.data)
        if kind == "actions":
            fault = take_actions(service, agent, decode(Actions, put.data, encoding), put.data, now)
        elif kind == "pose":
            fault = _take_pose(service, agent, decode(Pose, put.data, encoding), put.data, now)
        elif kind == "say":
            fault = _take_say(service, agent, decode(Say, put.data, encoding))
        else:
            fault = _take_user_input(service, agent, decode(UserInput, put.data, encoding), now)
    except WireError as error:
        fault = Fault(error.code, error.text, error.where or None)
    if fault is not None:
        send_error(service, agent, fault, now)


def take_actions(service: ServiceState, agent: str, actions: Actions, data: Answered, now: float) -> Fault | None:
    """Take the actions of an agent, and return what is wrong with them.

    Args:
        service: The service.
        agent: The agent.
        actions: Its actions.
        data: What is compared with a second answer to the same tick.
        now: The current time, s.
    """
    roster, state, barrier = service.agents.roster, service.run.state, service.pacing.barrier
    member = roster.mind(agent)
    fault = _check_session(service, agent, member, actions.session, "Actions")
    if fault is None:
        fault = check_time(actions.run, actions.tick, state.run, state.tick, "Actions")
        if fault is not None and fault.code == "late" and actions.run in (None, state.run):
            if barrier.repeats_late(agent, "actions", data):
                return None
            barrier.revive(agent)
            if not service.pacing.lockstep:
                fault = service.command_ages.check_late(agent, actions, state.run, state.tick)
    if fault is not None or member is None:
        return fault._replace(seq=actions.seq) if fault else None
    fault = _answer(service.pacing, state.tick, agent, "actions", data, "Actions")
    if fault is not None:
        return fault._replace(seq=actions.seq)
    if actions.say is not None and len(actions.say) > state.setup.say_limit:
        send_error(service, agent, _too_long(state, "Actions.Say", actions.say, actions.seq), now)
        actions = msgspec.structs.replace(actions, say=None)
    if not service.pacing.lockstep and has_command(actions):
        service.command_ages.take(agent, actions, state.tick)
    replaced_say = service.latch.act(agent, actions)
    if actions.leave:
        leaving.queue_leave(service, member)
    return replaced_say


def _take_pose(service: ServiceState, agent: str, pose: Pose, data: bytes, now: float) -> Fault | None:
    roster, state, pacing = service.agents.roster, service.run.state, service.pacing
    member = roster.body(agent)
    fault = _check_session(service, agent, member, pose.session, "Pose")
    if fault is None and member is not None and not member.real:
        fault = Fault("role", "Pose: expected a robot of Type real, got a simulated one", "Pose")
    if fault is None and member is not None and not is_genuine(member.key, pose_line(pose), pose.code):
        text = f"Pose.Code: expected the code that the key of the bridge makes, got {pose.code or 'none'}"
        fault = Fault("forged", text, "Pose.Code")
    if fault is None:
        fault = check_time(pose.run, pose.tick, state.run, state.tick, "Pose")
        if fault is not None and fault.code == "late" and pose.run in (None, state.run):
            if pacing.barrier.repeats_late(agent, "pose", data):
                return None
            pacing.barrier.revive(agent)
            # The pose of a bridge that is one cycle behind is still good.
            if not pacing.lockstep and pose.tick is not None and state.tick - pose.tick <= 1:
                fault = None
    if fault is not None:
        return fault._replace(seq=pose.seq)
    fault = _answer(pacing, state.tick, agent, "pose", data, "Pose")
    if fault is not None:
        return fault._replace(seq=pose.seq)
    service.latch.set_pose(agent, pose)
    bridge = service.agents.bridges.get(agent)
    if bridge is not None:
        bridge.reported_at = now
    return None


def _check_session(
    service: ServiceState, agent: str, member: Member | None, session: str | None, where: str
) -> Fault | None:
    """Return what is wrong with the session of a message, or None. An agent that was deleted is told so."""
    fault = check_session(member, service.agents.roster.members(agent), session, where)
    if fault is not None and service.agents.deleted.get(agent) == session:
        return DELETED
    return fault


def _answer(pacing: Pacing, tick: int, agent: str, kind: AnswerKind, data: Answered, where: str) -> Fault | None:
    """Give a message to the barrier, if it expects one from this agent; return the fault of a second answer."""
    if not pacing.barrier_open or (agent, kind) not in pacing.answers:
        return None  # the barrier is closed: no measures were sent yet, or all their answers have come
    if pacing.barrier.answer(agent, kind, data) == "conflict":
        return Fault("answered", f"{where}: tick {tick} is answered already", where)
    return None


def _take_say(service: ServiceState, agent: str, say: Say) -> Fault | None:
    members, state = service.agents.roster.members(agent), service.run.state
    fault: Fault | None = None
    if not members:
        fault = Fault("not-joined", "Say: expected an agent that has joined, got one that has not", "Say")
    elif all(say.session != member.session for member in members):
        fault = Fault("session", "Say.Session: expected the session of the last join, got another", "Say.Session")
    elif say.run is not None and say.run != state.run:
        fault = Fault("late", f"Say.Run: expected {state.run}, got {say.run}", "Say.Run")
    elif say.tick is not None and say.tick > state.tick:
        fault = Fault("early", f"Say.Tick: expected {state.tick}, got {say.tick}", "Say.Tick")
    elif len(say.text) > state.setup.say_limit:
        fault = _too_long(state, "Say", say.text, say.seq)
    if fault is not None:
        return fault._replace(seq=say.seq)
    return service.latch.say(agent, say)


def _too_long(state: State, where: str, text: str, seq: int | None) -> Fault:
    limit = state.setup.say_limit
    return Fault("too-long", f"{where}: expected at most {limit} characters, got {len(text)}", where, seq)


def _take_user_input(service: ServiceState, agent: str, user: UserInput, now: float) -> Fault | None:
    model = service.run.state.body_set.models.get(agent)
    if model is None:
        text = f"UserInput: expected the name of an agent that is here, got '{agent}'"
        send_unasked_error(service, agent, Fault("not-joined", text, "UserInput", user.seq), now)
        return None
    if not model.wants_user and user.lease is None and service.agents.leases.active(agent) is None:
        text = f"UserInput: expected an agent whose Robot has UserInput, or a lease of ctl/take, got '{agent}'"
        send_unasked_error(service, agent, Fault("role", text, "UserInput", user.seq), now)
        return None
    checked = service.agents.leases.check_input(agent, user, now)
    if isinstance(checked, Fault):
        return checked._replace(seq=user.seq)
    if checked:
        service.latch.set_user_input(agent, user)
    return None


def _report_stray(service: ServiceState, put: Put, now: float) -> None:
    """Report a message on a key that nobody reads: to the agent in it, or in the log if there is no such name."""
    head = put.key.partition("/")[0]
    valid = [f"user/{put.agent}"] if head == "user" else [f"in/{put.agent}/{kind}" for kind in IN_KINDS]
    near = difflib.get_close_matches(put.key, valid, n=1) if put.agent else []
    hint = f"; did you mean {near[0]}?" if near else ""
    pattern = "user/<agent>" if head == "user" else f"in/<agent>/ and one of {', '.join(IN_KINDS)}"
    text = f"key: expected {pattern}, got {shown(put.key)}{hint}"
    if put.agent:
        send_unasked_error(service, put.agent, Fault("field", text, put.key), now)
    elif service.unasked_limit.admit("", False, now) is not None:
        service.publisher.outlet.log_line(f"dropped why={text!r}")
