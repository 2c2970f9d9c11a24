"""What agents put: checked against seats, sessions, ticks and limits, and laid on the tray for the next step."""

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
from intellwheels_server import membership
from intellwheels_server.admission import check_session
from intellwheels_server.arrival import Put
from intellwheels_server.barrier import AnswerKind
from intellwheels_server.complaint import Fault
from intellwheels_server.desk import Desk
from intellwheels_server.tray import check_time


def take_put(desk: Desk, put: Put, now: float) -> None:
    """Take what was put on a key of an agent; what is wrong with it is told to that agent."""
    agent = put.agent
    kind = put.kind
    if kind in ("actions", "pose") and desk.open and desk.barrier.repeats(agent, kind, put.data):
        return
    # A user who floods must not use up what the agent itself may send; no agent's name has a slash.
    sender = agent if kind != "user" else f"user/{agent}"
    if not desk.gate.admit(sender, desk.state.tick, now):
        complain(desk, agent, Fault("too-many", f"{kind}: expected fewer messages a second"), now)
        return
    if put.size > len(put.data):
        complain(desk, agent, Fault("too-long", f"{kind}: expected fewer bytes, got {put.size}"), now)
        return
    try:
        encoding = encoding_of(put.encoding, put.data)
        if kind == "actions":
            fault = _take_actions(desk, agent, decode(Actions, put.data, encoding), put.data, now)
        elif kind == "pose":
            fault = _take_pose(desk, agent, decode(Pose, put.data, encoding), put.data, now)
        elif kind == "say":
            fault = _take_say(desk, agent, decode(Say, put.data, encoding))
        else:
            fault = _take_user(desk, agent, decode(UserInput, put.data, encoding), now)
    except WireError as error:
        fault = Fault(error.code, error.text, error.where or None)
    if fault is not None:
        complain(desk, agent, fault, now)


def _take_actions(desk: Desk, agent: str, actions: Actions, data: bytes, now: float) -> Fault | None:
    seat = desk.roster.mind(agent)
    fault = check_session(seat, desk.roster.seats(agent), actions.session, "Actions")
    if fault is None:
        fault = check_time(actions.run, actions.tick, desk.state.run, desk.state.tick, "Actions")
        if fault is not None and fault.code == "late" and actions.run in (None, desk.state.run):
            if desk.barrier.repeats_late(agent, "actions", data):
                return None
            desk.barrier.revive(agent)
    if fault is not None or seat is None:
        return fault._replace(seq=actions.seq) if fault else None
    fault = _answered(desk, agent, "actions", data, "Actions")
    if fault is not None:
        return None if fault.text == "" else fault._replace(seq=actions.seq)
    if actions.say is not None and len(actions.say) > desk.state.setup.say_limit:
        complain(desk, agent, _too_long(desk, "Actions.Say", actions.say, actions.seq), now)
        actions = msgspec.structs.replace(actions, say=None)
    put_aside = desk.tray.act(agent, actions)
    if actions.leave:
        membership.let_go(desk, seat, None)
    return put_aside


def _take_pose(desk: Desk, agent: str, pose: Pose, data: bytes, now: float) -> Fault | None:
    seat = desk.roster.body(agent)
    fault = check_session(seat, desk.roster.seats(agent), pose.session, "Pose")
    if fault is None and seat is not None and not seat.real:
        fault = Fault("role", "Pose: expected a robot of Type real, got a simulated one", "Pose")
    if fault is None:
        fault = check_time(pose.run, pose.tick, desk.state.run, desk.state.tick, "Pose")
        if fault is not None and fault.code == "late" and pose.run in (None, desk.state.run):
            if desk.barrier.repeats_late(agent, "pose", data):
                return None
            desk.barrier.revive(agent)
            # A bridge that is a cycle behind still says where its chair is.
            if not desk.lockstep and pose.tick is not None and desk.state.tick - pose.tick <= 1:
                fault = None
    if fault is not None:
        return fault._replace(seq=pose.seq)
    fault = _answered(desk, agent, "pose", data, "Pose")
    if fault is not None:
        return None if fault.text == "" else fault._replace(seq=pose.seq)
    desk.tray.report(agent, pose)
    bridge = desk.bridges.get(agent)
    if bridge is not None:
        bridge.at = now
    return None


def _answered(desk: Desk, agent: str, kind: AnswerKind, data: bytes, where: str) -> Fault | None:
    """Take a member's answer and return what is wrong with all but the first; the same bytes give no text."""
    if (agent, kind) not in desk.answers:
        return None
    if not desk.open:
        # Measures are not out yet, or those of a tick that was answered still stand: nothing is awaited.
        return None
    reception = desk.barrier.answer(agent, kind, data)
    if reception == "first":
        return None
    if reception == "same":
        return Fault("answered", "")
    return Fault("answered", f"{where}: tick {desk.state.tick} is answered already", where)


def _take_say(desk: Desk, agent: str, say: Say) -> Fault | None:
    seats = desk.roster.seats(agent)
    fault: Fault | None = None
    if not seats:
        fault = Fault("not-joined", "Say: expected an agent that has joined, got one that has not", "Say")
    elif say.session is not None and all(say.session != seat.session for seat in seats):
        fault = Fault("session", "Say.Session: expected the session of the last join, got another", "Say.Session")
    elif say.run is not None and say.run != desk.state.run:
        fault = Fault("late", f"Say.Run: expected {desk.state.run}, got {say.run}", "Say.Run")
    elif say.tick is not None and say.tick > desk.state.tick:
        fault = Fault("early", f"Say.Tick: expected {desk.state.tick}, got {say.tick}", "Say.Tick")
    elif len(say.text) > desk.state.setup.say_limit:
        fault = _too_long(desk, "Say", say.text, say.seq)
    if fault is not None:
        return fault._replace(seq=say.seq)
    return desk.tray.say(agent, say)


def _too_long(desk: Desk, where: str, text: str, seq: int | None) -> Fault:
    limit = desk.state.setup.say_limit
    return Fault("too-long", f"{where}: expected at most {limit} characters, got {len(text)}", where, seq)


def _take_user(desk: Desk, agent: str, user: UserInput, now: float) -> Fault | None:
    figure = desk.state.fleet.figures.get(agent)
    if figure is None:
        return None  # nobody to steer, and nobody to tell
    judged = desk.leases.judge(agent, user, now)
    if isinstance(judged, Fault):
        return judged._replace(seq=user.seq)
    if judged:
        desk.tray.use(agent, user)
    return None


def complain(desk: Desk, agent: str, fault: Fault, now: float) -> None:
    """Tell an agent what is wrong with what it sent, unless it was told much of late."""
    known = agent in desk.roster
    kept_back = desk.complaints.admit(agent, known, now)
    if kept_back is None:
        return
    seat = desk.roster.mind(agent) or desk.roster.body(agent)
    error = Error(
        run=desk.state.run,
        tick=desk.state.tick,
        code=fault.code,
        where=fault.where[:200] if fault.where else None,
        seq=fault.seq,
        suppressed=kept_back,
        text=fault.text[:1000],
    )
    desk.out.agent(agent, "error", error, seat.encoding if seat else Encoding.JSON)
