"""Who is here: tokens, joins, leaves, and all that hangs on them."""

from __future__ import annotations

from functools import partial
from typing import Final

import msgspec

from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import RequestRefusedError, WireError
from intellwheels_schemas.messages import (
    ErrorCode,
    Joined,
    Leave,
    Parameters,
    Position,
    Refused,
    RefusedCode,
    Robot,
)
from intellwheels_schemas.rules import has_motors
from intellwheels_server import publication
from intellwheels_server.admission import Seat, new_hex, same_body
from intellwheels_server.arrival import Ask, Token
from intellwheels_server.desk import Bridge, Desk, Waiting
from intellwheels_server.hiding import nominal
from intellwheels_server.inputs import (
    Depart,
    Join,
    Note,
    TakeBody,
)
from intellwheels_server.kernels.rows import HALTED, HEADING, STALE, X, Y

TOKEN_WAIT: Final = 0.3
"""Seconds a join waits for its token, which travels apart from it."""

MOST_WAITING: Final = 256
"""Joins that may wait so; a flood of more is refused at once, and who means it tries again."""

_REFUSED: Final[dict[ErrorCode, RefusedCode]] = {
    "field": "field",
    "value": "value",
    "malformed": "value",
    "encoding": "version",
    "version": "version",
    "too-long": "limit",
    "too-many": "limit",
}
"""How a robot that cannot be read is refused."""


def take_token(desk: Desk, token: Token, now: float) -> None:
    """Take in that a token came or went."""
    seat = desk.roster.token(token.agent, token.role, token.instance, token.present, now)
    if seat is not None:
        code = "returned" if token.present else "lost"
        desk.out.note(f"{code} agent={seat.agent} role={seat.role}")
        desk.later(partial(_note_presence, desk, seat, token.present))
    if token.present and desk.waiting:
        _recheck_waiting(desk)


def _note_presence(desk: Desk, seat: Seat, present: bool, now: float) -> None:
    if seat in desk.roster.seats(seat.agent):
        text = None if seat.role == "both" else seat.role
        desk.apply(Note(code="returned" if present else "lost", agent=seat.agent, text=text), now)


def _recheck_waiting(desk: Desk) -> None:
    still: list[Waiting] = []
    for waiting in desk.waiting:
        if _has_token(desk, waiting.ask.name, waiting.robot):
            desk.later(partial(_join, desk, waiting.ask, waiting.robot, waiting.encoding))
        else:
            still.append(waiting)
    desk.waiting = still


def expire(desk: Desk, now: float) -> None:
    """Do what is due by the clock: joins whose token did not come, seats whose grace is over, leases."""
    if desk.waiting and desk.waiting[0].until <= now:
        _recheck_waiting(desk)
    # Without its token a join is refused, which changes nothing and waits for no barrier: a flood of them must not
    # pile up at one.
    for waiting in [w for w in desk.waiting if w.until <= now]:
        desk.waiting.remove(waiting)
        _join(desk, waiting.ask, waiting.robot, waiting.encoding, now)
    for seat in desk.roster.lost(now, desk.options.grace):
        seat.absent_since = None  # once is enough
        if desk.strict and desk.lockstep and seat.answers() and not desk.stands():
            desk.miss(seat.agent)
        let_go(desk, seat, None)
    for agent in desk.leases.expired(now):
        desk.later(partial(_release, desk, agent))


def _release(desk: Desk, agent: str, now: float) -> None:
    if agent in desk.state.fleet.figures and desk.leases.holder(agent) is None:
        desk.apply(TakeBody(agent=agent, on=False), now)


def ask_join(desk: Desk, ask: Ask, now: float) -> None:
    """Take a wish to join; it is answered when changes may act."""
    if not ask.name:
        if not ask.wild:
            ask.refuse(Refused(code="name", text="join/<agent>: expected a name: a-z, then a-z 0-9 _ -, at most 32"))
        else:
            ask.close()
        return
    try:
        encoding = encoding_of(ask.encoding, ask.data)
        robot = decode(Robot, ask.data, encoding)
    except WireError as error:
        ask.refuse(Refused(code=_REFUSED.get(error.code, "value"), text=error.text[:1000]))
        return
    if not _has_token(desk, ask.name, robot):
        if len(desk.waiting) < MOST_WAITING:
            desk.waiting.append(Waiting(ask, robot, encoding, now + TOKEN_WAIT))
        else:
            _join(desk, ask, robot, encoding, now)
        return
    desk.later(partial(_join, desk, ask, robot, encoding))


def _has_token(desk: Desk, agent: str, robot: Robot) -> bool:
    instance = robot.instance or desk.roster.only_instance(agent, robot.role)
    return instance is not None and desk.roster.has_token(agent, robot.role, instance)


def _join(desk: Desk, ask: Ask, robot: Robot, encoding: Encoding, now: float) -> None:
    try:
        joined = _admit(desk, ask.name, robot, encoding, ask.parameters.get("session"), now)
    except RequestRefusedError as refusal:
        desk.out.note(f"refused agent={ask.name} role={robot.role} code={refusal.code}")
        ask.refuse(Refused(code=refusal.code, text=refusal.text[:1000]))
        return
    ask.reply(joined)


def _admit(desk: Desk, agent: str, robot: Robot, encoding: Encoding, shown: str | None, now: float) -> Joined:
    if robot.format is not None:
        raise RequestRefusedError("field", "Robot.Format: expected none in a join, as it is of files")
    if robot.crew is not None:
        raise RequestRefusedError("value", "Robot.Crew: crews are not supported; join each body by itself")
    if robot.instance is None:
        robot = msgspec.structs.replace(robot, instance=desk.roster.only_instance(agent, robot.role))
    held = desk.roster.holder(agent, robot, shown)
    figure = desk.state.fleet.figures.get(agent)
    kept = held is not None and figure is not None and same_body(held.robot, robot)
    if robot.role == "mind":
        if figure is None:
            raise RequestRefusedError("no-body", f"agent '{agent}' has no body here yet; join again when it has")
        body = figure.robot
    else:
        body = robot
    barrier = robot.barrier if robot.barrier is not None else has_motors(body)
    real = body.type == "real"
    if robot.role != "mind":
        _check_real(desk, robot)
    if barrier and desk.options.pace == "free" and not desk.options.open_loop:
        raise RequestRefusedError(
            "value",
            "Robot.Barrier: expected false, as this run is free and waits for nobody (--open-loop allows it)",
        )
    seat = Seat(
        agent=agent,
        role=robot.role,
        instance=robot.instance or "",
        session=held.session if held is not None and held.instance == robot.instance else new_hex(),
        encoding=encoding,
        robot=robot,
        real=real,
        simulated_hardware=body.hardware == "simulated",
        barrier=barrier,
    )
    position = _embody(desk, seat, held, kept, now)
    desk.roster.sit(seat)
    desk.barrier.renew(agent)
    if real and seat.embodies:
        # That of a body which stays knows what the world was told of it, such as that it is stale.
        desk.bridges.setdefault(agent, bridge_of(desk, agent, now))
    _reseat(desk, agent)
    desk.out.note(f"joined agent={agent} role={seat.role} tick={desk.state.tick}")
    if desk.open and desk.lockstep:
        desk.barrier.join(seat.answers())
    if not desk.held and (desk.open or not desk.lockstep):
        publication.put_measures(desk, agent)
    return _joined_of(desk, seat, position)


def _check_real(desk: Desk, robot: Robot) -> None:
    if robot.type != "real" or robot.hardware == "simulated":
        return
    if desk.lockstep or desk.options.pace == "free" or desk.metronome.speed != 1.0:
        raise RequestRefusedError(
            "real-in-lockstep",
            "Robot.Type: expected simulated, as real hardware takes part in real time at speed 1 only, got real",
        )


def _embody(desk: Desk, seat: Seat, held: Seat | None, kept: bool, now: float) -> Position:
    """Give a seat its body: the one that is here, if it may be kept, else a new one. Return where it is."""
    agent = seat.agent
    if held is not None and kept:
        if held.absent_since is not None or held.instance != seat.instance:
            desk.apply(Note(code="returned", agent=agent, text=None if seat.role == "both" else seat.role), now)
        return _position_of(desk, agent)
    if held is None and seat.embodies and is_vacant(desk, agent):
        if same_body(desk.state.fleet.figures[agent].robot, seat.robot):
            desk.apply(Note(code="returned", agent=agent), now)
            return _position_of(desk, agent)
        desk.apply(Depart(agent=agent), now)
    others = [seat for seat in desk.roster.seats(agent) if seat.role == "mind" and seat is not held]
    if held is not None and agent in desk.state.fleet.figures:
        desk.apply(Depart(agent=agent, role=held.role, lost=held.absent_since is not None), now)
        if held.embodies:
            forget_body(desk, agent)
        else:
            desk.tray.forget(agent)
    outcome = desk.apply(Join(agent=agent, robot=_as_joined(seat.robot, agent)), now)
    if outcome.code != "ok":
        if held is not None:
            dismiss(desk, held)
        raise RequestRefusedError(outcome.refused or "value", outcome.text)
    for mind in others:  # of a body that was changed
        desk.apply(Join(agent=agent, robot=_as_joined(mind.robot, agent)), now)
    return outcome.position or _position_of(desk, agent)


def is_vacant(desk: Desk, agent: str) -> bool:
    """Return whether an agent's body is here without the agent, as after a restore to when it was here.

    What an operator spawned is nobody's: only who joined has an instance.
    """
    figure = desk.state.fleet.figures.get(agent)
    return figure is not None and figure.robot.instance is not None and desk.roster.body(agent) is None


def bridge_of(desk: Desk, agent: str, now: float) -> Bridge:
    """Return what is known of a real body's reports, as the world has it. The body must be here."""
    flags = desk.state.flags[:, desk.state.fleet.index[agent]]
    return Bridge(at=now, stale=bool(flags[STALE]), halted=bool(flags[HALTED]))


def _position_of(desk: Desk, agent: str) -> Position:
    x, y, heading = desk.state.numbers[[X, Y, HEADING], desk.state.fleet.index[agent]].tolist()
    return Position(x=x, y=y, heading=heading)


def _joined_of(desk: Desk, seat: Seat, position: Position) -> Joined:
    setup = desk.state.setup
    figure = desk.state.fleet.figures[seat.agent]
    hides = desk.options.hide_truth
    return Joined(
        run=desk.state.run,
        tick=desk.state.tick,
        session=seat.session,
        parameters=Parameters(
            world=desk.options.world,
            period=setup.period,
            pace=desk.options.pace,
            say_limit=setup.say_limit,
            say_range=setup.say_range,
            command_timeout=setup.command_timeout,
            grace=desk.options.grace,
        ),
        # Who comes back to a laboratory learns where its chair began, not where it is.
        position=figure.start if hides else position,
        robot=nominal(figure.robot) if hides else figure.robot,
    )


def ask_leave(desk: Desk, ask: Ask) -> None:
    """Take a wish to leave; it is answered when the agent has left."""
    if not ask.name:
        if not ask.wild:
            ask.refuse(desk.result("failed", "leave/<agent>: expected a name: a-z, then a-z 0-9 _ -, at most 32"))
        else:
            ask.close()
        return
    try:
        leave = decode(Leave, ask.data, encoding_of(ask.encoding, ask.data)) if ask.data else Leave()
    except WireError as error:
        ask.refuse(desk.result("failed", error.text))
        return
    seats = desk.roster.seats(ask.name)
    leaving = [seat for seat in seats if leave.session in (None, seat.session)]
    if not leaving:
        why = "no such agent here" if not seats else "expected the session of the last join, got another"
        ask.reply(desk.result("not-found", f"agent '{ask.name}': {why}"))
        return
    # The body last: without it its mind is gone too.
    leaving.sort(key=lambda seat: seat.embodies)
    for seat in leaving:
        let_go(desk, seat, ask if seat is leaving[-1] else None)


def let_go(desk: Desk, seat: Seat, ask: Ask | None) -> None:
    """Let a seat's agent leave at the next barrier; it is awaited no more."""
    for agent, kind in seat.answers():
        desk.barrier.excuse(agent, kind)
    desk.later(partial(_leave, desk, seat, ask))


def _leave(desk: Desk, seat: Seat, ask: Ask | None, now: float) -> None:
    if seat in desk.roster.seats(seat.agent):
        desk.apply(Depart(agent=seat.agent, role=seat.role), now)
        dismiss(desk, seat)
    if ask is not None:
        ask.reply(desk.result("ok"))


def dismiss(desk: Desk, seat: Seat) -> None:
    """Take a seat away, and with a body all that hangs on it."""
    agent = seat.agent
    desk.out.note(f"left agent={agent} role={seat.role} tick={desk.state.tick}")
    gone = desk.roster.seats(agent) if agent not in desk.state.fleet.figures else (seat,)
    for each in gone:
        for name, kind in each.answers():
            desk.barrier.excuse(name, kind)
        desk.roster.rise(each)
    if agent not in desk.state.fleet.figures:
        forget_body(desk, agent)
    _reseat(desk, agent)


def forget_body(desk: Desk, agent: str) -> None:
    """Forget all that hangs on a body which is gone."""
    desk.barrier.forget(agent)
    desk.tray.forget(agent)
    desk.leases.forget(agent)
    desk.bridges.pop(agent, None)


def _reseat(desk: Desk, agent: str) -> None:
    """Draw the conclusions from a change of seats."""
    members = [answer for seat in desk.roster.every_seat() for answer in seat.answers()]
    desk.members = tuple(members) if desk.lockstep else ()
    desk.answers = frozenset(desk.members)
    mind, body = desk.roster.mind(agent), desk.roster.body(agent)
    listener = mind or body
    if listener is None:
        desk.encodings.pop(agent, None)
        desk.complaints.forget(agent)
        desk.out.farewell(agent)
    else:
        desk.encodings[agent] = listener.encoding
        desk.out.welcome(agent, listener.encoding, (body or listener).encoding)
    if agent in desk.state.fleet.figures:
        desk.out.body(agent, publication.body_of(desk, agent))


def _as_joined(robot: Robot, agent: str) -> Robot:
    return robot if robot.name is not None else msgspec.structs.replace(robot, name=agent)
