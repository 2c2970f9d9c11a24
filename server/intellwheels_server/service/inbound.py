"""What agents put: checked against seats, sessions, ticks and limits, and latched for the next step."""

from __future__ import annotations

import msgspec

from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    Actions,
    Error,
    Pose,
    Say,
    UserInput,
)
from intellwheels_server.service import joining
from intellwheels_server.service.arrival import Put
from intellwheels_server.service.barrier import AnswerKind
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.service.input_latch import check_time
from intellwheels_server.service.roster import check_session
from intellwheels_server.service.service_state import ServiceState


def take_put(service: ServiceState, put: Put, now: float) -> None:
    """Take what was put on a key of an agent; what is wrong with it is told to that agent."""
    agent = put.agent
    kind = put.kind
    if kind in ("actions", "pose") and service.open and service.barrier.repeats(agent, kind, put.data):
        return
    # A user who floods must not use up what the agent itself may send; no agent's name has a slash.
    sender = agent if kind != "user" else f"user/{agent}"
    if not service.gate.admit(sender, service.state.tick, now):
        complain(service, agent, Fault("too-many", f"{kind}: expected fewer messages a second"), now)
        return
    if put.size > len(put.data):
        complain(service, agent, Fault("too-long", f"{kind}: expected fewer bytes, got {put.size}"), now)
        return
    try:
        encoding = encoding_of(put.encoding, put.data)
        if kind == "actions":
            fault = _take_actions(service, agent, decode(Actions, put.data, encoding), put.data, now)
        elif kind == "pose":
            fault = _take_pose(service, agent, decode(Pose, put.data, encoding), put.data, now)
        elif kind == "say":
            fault = _take_say(service, agent, decode(Say, put.data, encoding))
        else:
            fault = _take_user(service, agent, decode(UserInput, put.data, encoding), now)
    except WireError as error:
        fault = Fault(error.code, error.text, error.where or None)
    if fault is not None:
        complain(service, agent, fault, now)


def _take_actions(service: ServiceState, agent: str, actions: Actions, data: bytes, now: float) -> Fault | None:
    seat = service.roster.mind(agent)
    fault = check_session(seat, service.roster.seats(agent), actions.session, "Actions")
    if fault is None:
        fault = check_time(actions.run, actions.tick, service.state.run, service.state.tick, "Actions")
        if fault is not None and fault.code == "late" and actions.run in (None, service.state.run):
            if service.barrier.repeats_late(agent, "actions", data):
                return None
            service.barrier.revive(agent)
    if fault is not None or seat is None:
        return fault._replace(seq=actions.seq) if fault else None
    fault = _answered(service, agent, "actions", data, "Actions")
    if fault is not None:
        return None if fault.text == "" else fault._replace(seq=actions.seq)
    if actions.say is not None and len(actions.say) > service.state.setup.say_limit:
        complain(service, agent, _too_long(service, "Actions.Say", actions.say, actions.seq), now)
        actions = msgspec.structs.replace(actions, say=None)
    put_aside = service.latch.act(agent, actions)
    if actions.leave:
        joining.let_go(service, seat, None)
    return put_aside


def _take_pose(service: ServiceState, agent: str, pose: Pose, data: bytes, now: float) -> Fault | None:
    seat = service.roster.body(agent)
    fault = check_session(seat, service.roster.seats(agent), pose.session, "Pose")
    if fault is None and seat is not None and not seat.real:
        fault = Fault("role", "Pose: expected a robot of Type real, got a simulated one", "Pose")
    if fault is None:
        fault = check_time(pose.run, pose.tick, service.state.run, service.state.tick, "Pose")
        if fault is not None and fault.code == "late" and pose.run in (None, service.state.run):
            if service.barrier.repeats_late(agent, "pose", data):
                return None
            service.barrier.revive(agent)
            # A bridge that is a cycle behind still says where its chair is.
            if not service.lockstep and pose.tick is not None and service.state.tick - pose.tick <= 1:
                fault = None
    if fault is not None:
        return fault._replace(seq=pose.seq)
    fault = _answered(service, agent, "pose", data, "Pose")
    if fault is not None:
        return None if fault.text == "" else fault._replace(seq=pose.seq)
    service.latch.report(agent, pose)
    bridge = service.bridges.get(agent)
    if bridge is not None:
        bridge.at = now
    return None


def _answered(service: ServiceState, agent: str, kind: AnswerKind, data: bytes, where: str) -> Fault | None:
    """Take a member's answer and return what is wrong with all but the first; the same bytes give no text."""
    if (agent, kind) not in service.answers:
        return None
    if not service.open:
        # Measures are not out yet, or those of a tick that was answered still stand: nothing is awaited.
        return None
    reception = service.barrier.answer(agent, kind, data)
    if reception == "first":
        return None
    if reception == "same":
        return Fault("answered", "")
    return Fault("answered", f"{where}: tick {service.state.tick} is answered already", where)


def _take_say(service: ServiceState, agent: str, say: Say) -> Fault | None:
    seats = service.roster.seats(agent)
    fault: Fault | None = None
    if not seats:
        fault = Fault("not-joined", "Say: expected an agent that has joined, got one that has not", "Say")
    elif say.session is not None and all(say.session != seat.session for seat in seats):
        fault = Fault("session", "Say.Session: expected the session of the last join, got another", "Say.Session")
    elif say.run is not None and say.run != service.state.run:
        fault = Fault("late", f"Say.Run: expected {service.state.run}, got {say.run}", "Say.Run")
    elif say.tick is not None and say.tick > service.state.tick:
        fault = Fault("early", f"Say.Tick: expected {service.state.tick}, got {say.tick}", "Say.Tick")
    elif len(say.text) > service.state.setup.say_limit:
        fault = _too_long(service, "Say", say.text, say.seq)
    if fault is not None:
        return fault._replace(seq=say.seq)
    return service.latch.say(agent, say)


def _too_long(service: ServiceState, where: str, text: str, seq: int | None) -> Fault:
    limit = service.state.setup.say_limit
    return Fault("too-long", f"{where}: expected at most {limit} characters, got {len(text)}", where, seq)


def _take_user(service: ServiceState, agent: str, user: UserInput, now: float) -> Fault | None:
    figure = service.state.body_set.figures.get(agent)
    if figure is None:
        return None  # nobody to steer, and nobody to tell
    judged = service.leases.judge(agent, user, now)
    if isinstance(judged, Fault):
        return judged._replace(seq=user.seq)
    if judged:
        service.latch.use(agent, user)
    return None


def complain(service: ServiceState, agent: str, fault: Fault, now: float) -> None:
    """Tell an agent what is wrong with what it sent, unless it was told much of late."""
    known = agent in service.roster
    kept_back = service.complaints.admit(agent, known, now)
    if kept_back is None:
        return
    seat = service.roster.mind(agent) or service.roster.body(agent)
    error = Error(
        run=service.state.run,
        tick=service.state.tick,
        code=fault.code,
        where=fault.where[:200] if fault.where else None,
        seq=fault.seq,
        suppressed=kept_back,
        text=fault.text[:1000],
    )
    service.out.agent(agent, "error", error, seat.encoding if seat else Encoding.JSON)
