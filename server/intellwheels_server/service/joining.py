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
from intellwheels_server.service import outbound
from intellwheels_server.service.arrival import Ask, Token
from intellwheels_server.service.roster import Seat, new_hex, same_body
from intellwheels_server.service.service_state import Bridge, ServiceState, Waiting
from intellwheels_server.service.truth_filter import nominal
from intellwheels_server.world.inputs import (
    Depart,
    Join,
    Note,
    TakeBody,
)
from intellwheels_server.world.kernels import rows

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


def take_token(service: ServiceState, token: Token, now: float) -> None:
    """Take in that a token came or went."""
    seat = service.roster.token(token.agent, token.role, token.instance, token.present, now)
    if seat is not None:
        code = "returned" if token.present else "lost"
        service.out.note(f"{code} agent={seat.agent} role={seat.role}")
        service.later(partial(_note_presence, service, seat, token.present))
    if token.present and service.waiting:
        _recheck_waiting(service)


def _note_presence(service: ServiceState, seat: Seat, present: bool, now: float) -> None:
    if seat in service.roster.seats(seat.agent):
        text = None if seat.role == "both" else seat.role
        service.apply(Note(code="returned" if present else "lost", agent=seat.agent, text=text), now)


def _recheck_waiting(service: ServiceState) -> None:
    still: list[Waiting] = []
    for waiting in service.waiting:
        if _has_token(service, waiting.ask.name, waiting.robot):
            service.later(partial(_join, service, waiting.ask, waiting.robot, waiting.encoding))
        else:
            still.append(waiting)
    service.waiting = still


def expire(service: ServiceState, now: float) -> None:
    """Do what is due by the clock: joins whose token did not come, seats whose grace is over, leases."""
    if service.waiting and service.waiting[0].until <= now:
        _recheck_waiting(service)
    # Without its token a join is refused, which changes nothing and waits for no barrier: a flood of them must not
    # pile up at one.
    for waiting in [w for w in service.waiting if w.until <= now]:
        service.waiting.remove(waiting)
        _join(service, waiting.ask, waiting.robot, waiting.encoding, now)
    for seat in service.roster.lost(now, service.options.grace):
        seat.absent_since = None  # once is enough
        if service.strict and service.lockstep and seat.answers() and not service.stands():
            service.miss(seat.agent)
        let_go(service, seat, None)
    for agent in service.leases.expired(now):
        service.later(partial(_release, service, agent))


def _release(service: ServiceState, agent: str, now: float) -> None:
    if agent in service.state.body_set.figures and service.leases.holder(agent) is None:
        service.apply(TakeBody(agent=agent, on=False), now)


def ask_join(service: ServiceState, ask: Ask, now: float) -> None:
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
    if not _has_token(service, ask.name, robot):
        if len(service.waiting) < MOST_WAITING:
            service.waiting.append(Waiting(ask, robot, encoding, now + TOKEN_WAIT))
        else:
            _join(service, ask, robot, encoding, now)
        return
    service.later(partial(_join, service, ask, robot, encoding))


def _has_token(service: ServiceState, agent: str, robot: Robot) -> bool:
    instance = robot.instance or service.roster.only_instance(agent, robot.role)
    return instance is not None and service.roster.has_token(agent, robot.role, instance)


def _join(service: ServiceState, ask: Ask, robot: Robot, encoding: Encoding, now: float) -> None:
    try:
        joined = _admit(service, ask.name, robot, encoding, ask.parameters.get("session"), now)
    except RequestRefusedError as refusal:
        service.out.note(f"refused agent={ask.name} role={robot.role} code={refusal.code}")
        ask.refuse(Refused(code=refusal.code, text=refusal.text[:1000]))
        return
    ask.reply(joined)


def _admit(
    service: ServiceState, agent: str, robot: Robot, encoding: Encoding, shown: str | None, now: float
) -> Joined:
    if robot.format is not None:
        raise RequestRefusedError("field", "Robot.Format: expected none in a join, as it is of files")
    if robot.crew is not None:
        raise RequestRefusedError("value", "Robot.Crew: crews are not supported; join each body by itself")
    if robot.instance is None:
        robot = msgspec.structs.replace(robot, instance=service.roster.only_instance(agent, robot.role))
    held = service.roster.holder(agent, robot, shown)
    figure = service.state.body_set.figures.get(agent)
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
        _check_real(service, robot)
    if barrier and service.options.pace == "free" and not service.options.open_loop:
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
    position = _embody(service, seat, held, kept, now)
    service.roster.sit(seat)
    service.barrier.renew(agent)
    if real and seat.embodies:
        # That of a body which stays knows what the world was told of it, such as that it is stale.
        service.bridges.setdefault(agent, bridge_of(service, agent, now))
    _reseat(service, agent)
    service.out.note(f"joined agent={agent} role={seat.role} tick={service.state.tick}")
    if service.open and service.lockstep:
        service.barrier.join(seat.answers())
    if not service.held and (service.open or not service.lockstep):
        outbound.put_measures(service, agent)
    return _joined_of(service, seat, position)


def _check_real(service: ServiceState, robot: Robot) -> None:
    if robot.type != "real" or robot.hardware == "simulated":
        return
    if service.lockstep or service.options.pace == "free" or service.metronome.speed != 1.0:
        raise RequestRefusedError(
            "real-in-lockstep",
            "Robot.Type: expected simulated, as real hardware takes part in real time at speed 1 only, got real",
        )


def _embody(service: ServiceState, seat: Seat, held: Seat | None, kept: bool, now: float) -> Position:
    """Give a seat its body: the one that is here, if it may be kept, else a new one. Return where it is."""
    agent = seat.agent
    if held is not None and kept:
        if held.absent_since is not None or held.instance != seat.instance:
            service.apply(Note(code="returned", agent=agent, text=None if seat.role == "both" else seat.role), now)
        return _position_of(service, agent)
    if held is None and seat.embodies and is_vacant(service, agent):
        if same_body(service.state.body_set.figures[agent].robot, seat.robot):
            service.apply(Note(code="returned", agent=agent), now)
            return _position_of(service, agent)
        service.apply(Depart(agent=agent), now)
    others = [seat for seat in service.roster.seats(agent) if seat.role == "mind" and seat is not held]
    if held is not None and agent in service.state.body_set.figures:
        service.apply(Depart(agent=agent, role=held.role, lost=held.absent_since is not None), now)
        if held.embodies:
            forget_body(service, agent)
        else:
            service.latch.forget(agent)
    outcome = service.apply(Join(agent=agent, robot=_as_joined(seat.robot, agent)), now)
    if outcome.code != "ok":
        if held is not None:
            dismiss(service, held)
        raise RequestRefusedError(outcome.refused or "value", outcome.text)
    for mind in others:  # of a body that was changed
        service.apply(Join(agent=agent, robot=_as_joined(mind.robot, agent)), now)
    return outcome.position or _position_of(service, agent)


def is_vacant(service: ServiceState, agent: str) -> bool:
    """Return whether an agent's body is here without the agent, as after a restore to when it was here.

    What an operator spawned is nobody's: only who joined has an instance.
    """
    figure = service.state.body_set.figures.get(agent)
    return figure is not None and figure.robot.instance is not None and service.roster.body(agent) is None


def bridge_of(service: ServiceState, agent: str, now: float) -> Bridge:
    """Return what is known of a real body's reports, as the world has it. The body must be here."""
    flags = service.state.flags[:, service.state.body_set.index[agent]]
    return Bridge(at=now, stale=bool(flags[rows.STALE]), halted=bool(flags[rows.HALTED]))


def _position_of(service: ServiceState, agent: str) -> Position:
    x, y, heading = service.state.numbers[[rows.X, rows.Y, rows.HEADING], service.state.body_set.index[agent]].tolist()
    return Position(x=x, y=y, heading=heading)


def _joined_of(service: ServiceState, seat: Seat, position: Position) -> Joined:
    setup = service.state.setup
    figure = service.state.body_set.figures[seat.agent]
    hides = service.options.hide_truth
    return Joined(
        run=service.state.run,
        tick=service.state.tick,
        session=seat.session,
        parameters=Parameters(
            world=service.options.world,
            period=setup.period,
            pace=service.options.pace,
            say_limit=setup.say_limit,
            say_range=setup.say_range,
            command_timeout=setup.command_timeout,
            grace=service.options.grace,
        ),
        # Who comes back to a laboratory learns where its chair began, not where it is.
        position=figure.start if hides else position,
        robot=nominal(figure.robot) if hides else figure.robot,
    )


def ask_leave(service: ServiceState, ask: Ask) -> None:
    """Take a wish to leave; it is answered when the agent has left."""
    if not ask.name:
        if not ask.wild:
            ask.refuse(service.result("failed", "leave/<agent>: expected a name: a-z, then a-z 0-9 _ -, at most 32"))
        else:
            ask.close()
        return
    try:
        leave = decode(Leave, ask.data, encoding_of(ask.encoding, ask.data)) if ask.data else Leave()
    except WireError as error:
        ask.refuse(service.result("failed", error.text))
        return
    seats = service.roster.seats(ask.name)
    leaving = [seat for seat in seats if leave.session in (None, seat.session)]
    if not leaving:
        why = "no such agent here" if not seats else "expected the session of the last join, got another"
        ask.reply(service.result("not-found", f"agent '{ask.name}': {why}"))
        return
    # The body last: without it its mind is gone too.
    leaving.sort(key=lambda seat: seat.embodies)
    for seat in leaving:
        let_go(service, seat, ask if seat is leaving[-1] else None)


def let_go(service: ServiceState, seat: Seat, ask: Ask | None) -> None:
    """Let a seat's agent leave at the next barrier; it is awaited no more."""
    for agent, kind in seat.answers():
        service.barrier.excuse(agent, kind)
    service.later(partial(_leave, service, seat, ask))


def _leave(service: ServiceState, seat: Seat, ask: Ask | None, now: float) -> None:
    if seat in service.roster.seats(seat.agent):
        service.apply(Depart(agent=seat.agent, role=seat.role), now)
        dismiss(service, seat)
    if ask is not None:
        ask.reply(service.result("ok"))


def dismiss(service: ServiceState, seat: Seat) -> None:
    """Take a seat away, and with a body all that hangs on it."""
    agent = seat.agent
    service.out.note(f"left agent={agent} role={seat.role} tick={service.state.tick}")
    gone = service.roster.seats(agent) if agent not in service.state.body_set.figures else (seat,)
    for each in gone:
        for name, kind in each.answers():
            service.barrier.excuse(name, kind)
        service.roster.rise(each)
    if agent not in service.state.body_set.figures:
        forget_body(service, agent)
    _reseat(service, agent)


def forget_body(service: ServiceState, agent: str) -> None:
    """Forget all that hangs on a body which is gone."""
    service.barrier.forget(agent)
    service.latch.forget(agent)
    service.leases.forget(agent)
    service.bridges.pop(agent, None)


def _reseat(service: ServiceState, agent: str) -> None:
    """Draw the conclusions from a change of seats."""
    members = [answer for seat in service.roster.every_seat() for answer in seat.answers()]
    service.members = tuple(members) if service.lockstep else ()
    service.answers = frozenset(service.members)
    mind, body = service.roster.mind(agent), service.roster.body(agent)
    listener = mind or body
    if listener is None:
        service.encodings.pop(agent, None)
        service.complaints.forget(agent)
        service.out.farewell(agent)
    else:
        service.encodings[agent] = listener.encoding
        service.out.welcome(agent, listener.encoding, (body or listener).encoding)
    if agent in service.state.body_set.figures:
        service.out.body(agent, outbound.body_of(service, agent))


def _as_joined(robot: Robot, agent: str) -> Robot:
    return robot if robot.name is not None else msgspec.structs.replace(robot, name=agent)
