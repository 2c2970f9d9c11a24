"""Joins, leaves and liveliness tokens, and everything that follows from them."""

from __future__ import annotations

from functools import partial
from typing import Final

import msgspec

from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import RequestRefusedError, WireError
from intellwheels_schemas.file_records import Depart, Join, Note, TakeBody
from intellwheels_schemas.messages import ErrorCode, Joined, Leave, Position, Refused, RefusedCode, Robot
from intellwheels_schemas.metal_codes import new_key
from intellwheels_schemas.rules import has_motors
from intellwheels_server.service import outbound
from intellwheels_server.service.arrival import Query, Token
from intellwheels_server.service.connected_agents import BridgeStatus, WaitingJoin
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.service.roster import Member, Roster, new_hex, same_body
from intellwheels_server.service.sensor_budget import check_sensor_budget
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.service.start_report import report_joined
from intellwheels_server.service.truth_filter import nominal
from intellwheels_server.world import State
from intellwheels_server.world.kernels import rows

TOKEN_WAIT: Final = 0.3
"""Seconds a join waits for its token, which travels separately."""

MAX_WAITING: Final = 256
"""Joins that may wait for their token. Further ones are refused at once; their agents can try again."""

NAME_EXPECTED: Final = "expected a name: a-z, then a-z 0-9 _ -, at most 32"

REFUSED: Final[dict[ErrorCode, RefusedCode]] = {
    "field": "field",
    "value": "value",
    "malformed": "value",
    "encoding": "version",
    "version": "version",
    "too-long": "limit",
    "too-many": "limit",
}
"""The code of a refused join if its robot cannot be read."""

# ------------------------------------------------------------ tokens and deadlines


def take_token(service: ServiceState, token: Token, now: float) -> None:
    """Note that a liveliness token appeared or disappeared."""
    member = service.agents.roster.token(token.agent, token.role, token.presence, token.present, now)
    if member is not None:
        code = "returned" if token.present else "lost"
        service.publisher.outlet.log_line(f"{code} agent={member.agent} role={member.role}")
        service.queue_change(partial(_note_presence, service, member, token.present))
    if token.present and service.agents.waiting_joins:
        _recheck_waiting_joins(service)


def _note_presence(service: ServiceState, member: Member, present: bool, _now: float) -> None:
    if member in service.agents.roster.members(member.agent):
        service.apply(Note(code="returned" if present else "lost", agent=member.agent, text=_role_text(member)))


def _role_text(member: Member) -> str | None:
    return None if member.role == "both" else member.role


def _recheck_waiting_joins(service: ServiceState) -> None:
    agents = service.agents
    still: list[WaitingJoin] = []
    for join in agents.waiting_joins:
        if _has_token(agents.roster, join.query.name, join.robot):
            service.queue_change(partial(_join, service, join.query, join.robot, join.encoding))
        else:
            still.append(join)
    agents.waiting_joins = still


def handle_deadlines(service: ServiceState, now: float) -> None:
    """Handle joins whose token did not come, members whose grace time is over, and leases that ran out."""
    agents, pacing = service.agents, service.pacing
    if agents.waiting_joins and agents.waiting_joins[0].until <= now:
        _recheck_waiting_joins(service)
    # A join without its token is refused. That changes nothing, so it need not wait for a barrier, and a flood of such
    # joins cannot pile up there.
    for join in [waiting for waiting in agents.waiting_joins if waiting.until <= now]:
        agents.waiting_joins.remove(join)
        _join(service, join.query, join.robot, join.encoding, now)
    for member in agents.roster.lost(now, service.options.grace):
        member.absent_since = None  # so that it is handled once
        if pacing.strict and pacing.lockstep and member.answers() and not service.is_stopped():
            service.end_for_missed_answer(member.agent)
        queue_leave(service, member)
    for agent in agents.leases.take_expired(now):
        service.queue_change(partial(_release, service, agent))


def _release(service: ServiceState, agent: str, _now: float) -> None:
    if agent in service.run.state.body_set.models and service.agents.leases.active(agent) is None:
        service.apply(TakeBody(agent=agent, on=False))


# ------------------------------------------------------------ joins


def handle_join(service: ServiceState, query: Query, now: float) -> None:
    """Take a request to join; it is answered when changes may act."""
    if not query.name:
        if not query.has_wildcards:
            query.refuse(Refused(code="name", text=f"join/<agent>: {NAME_EXPECTED}"))
        else:
            query.close()
        return
    try:
        encoding = encoding_of(query.encoding, query.data)
        robot = decode(Robot, query.data, encoding)
    except WireError as error:
        query.refuse(Refused(code=REFUSED.get(error.code, "value"), text=error.text[:1000]))
        return
    if not _has_token(service.agents.roster, query.name, robot):
        if len(service.agents.waiting_joins) < MAX_WAITING:
            service.agents.waiting_joins.append(WaitingJoin(query, robot, encoding, now + TOKEN_WAIT))
        else:
            _join(service, query, robot, encoding, now)
        return
    service.queue_change(partial(_join, service, query, robot, encoding))


def _has_token(roster: Roster, agent: str, robot: Robot) -> bool:
    instance = robot.instance or roster.only_instance(agent, robot.role)
    return instance is not None and roster.has_token(agent, robot.role, instance)


def _join(service: ServiceState, query: Query, robot: Robot, encoding: Encoding, now: float) -> None:
    try:
        joined = admit(service, query.name, robot, encoding, query.parameters.get("session"), now)
    except RequestRefusedError as refusal:
        service.publisher.outlet.log_line(f"refused agent={query.name} role={robot.role} code={refusal.code}")
        query.refuse(Refused(code=refusal.code, text=refusal.text[:1000]))
        return
    query.reply(joined)


def admit(
    service: ServiceState, agent: str, robot: Robot, encoding: Encoding, session: str | None, now: float, crew: str = ""
) -> Joined:
    """Let an agent join and return the reply. If it has a crew, the caller puts its measures.

    Raises:
        RequestRefusedError: It may not join.
    """
    agents, pacing = service.agents, service.pacing
    if robot.format is not None:
        raise RequestRefusedError("field", "Robot.Format: expected none in a join; it belongs to files")
    if robot.crew != (crew or None):
        raise RequestRefusedError("value", f"Robot.Crew: expected none in join/{agent}; crews join at crew/<crew>/join")
    if robot.instance is None:
        robot = msgspec.structs.replace(robot, instance=agents.roster.only_instance(agent, robot.role))
    current = agents.roster.predecessor(agent, robot, session, crew)
    model = service.run.state.body_set.models.get(agent)
    keeps_body = current is not None and model is not None and same_body(current.robot, robot)
    if robot.role == "mind":
        if model is None:
            raise RequestRefusedError("no-body", f"agent '{agent}' has no body here yet; join again when it has")
        body = model.robot
    else:
        body = robot
        _check_real(service, robot)
        check_sensor_budget(service, agent, robot)
    barrier = robot.barrier if robot.barrier is not None else has_motors(body)
    if barrier and pacing.pace == "free" and not service.options.open_loop:
        raise RequestRefusedError(
            "value",
            "Robot.Barrier: expected false, as a run at pace free does not wait for answers (--open-loop allows it)",
        )
    member = Member(
        agent=agent,
        role=robot.role,
        instance=robot.instance or "",
        session=current.session if current is not None and current.instance == robot.instance else new_hex(),
        encoding=encoding,
        robot=robot,
        real=body.type == "real",
        simulated_hardware=body.hardware == "simulated",
        barrier=barrier,
        crew=crew,
    )
    returns = current is not None and current.instance == member.instance
    if member.real and member.has_body:
        member.key = current.key if returns and current is not None and current.key else new_key()
    position = _give_body(service, member, current, keeps_body)
    agents.roster.add(member)
    agents.deleted.pop(agent, None)
    pacing.barrier.reset_member(agent)
    if member.real and member.has_body:
        # The entry of a body that stays is kept: it records what the world knows, such as that the pose is old.
        agents.bridges.setdefault(agent, bridge_status(service.run.state, agent, now))
    _update_members(service, agent)
    report_joined(service, member, position, starts=current is None)
    if pacing.barrier_open and pacing.lockstep:
        pacing.barrier.add(member.answers())
    if not crew and pacing.measures_are_out:
        outbound.put_measures(service, agent)
    return _joined_reply(service, member, position, shows_key=not returns)


def _check_real(service: ServiceState, robot: Robot) -> None:
    if robot.type == "real" and robot.hardware != "simulated" and not service.pacing.at_real_speed:
        raise RequestRefusedError(
            "real-in-lockstep",
            "Robot.Type: expected simulated, got real; real hardware can join only in real time at speed 1",
        )


def _give_body(service: ServiceState, member: Member, current: Member | None, keeps_body: bool) -> Position:
    """Give a member its body and return its pose. A body that is here already is kept if possible."""
    agent, roster = member.agent, service.agents.roster
    if current is not None and keeps_body:
        if current.absent_since is not None or current.instance != member.instance:
            service.apply(Note(code="returned", agent=agent, text=_role_text(member)))
        return position_of(service.run.state, agent)
    if current is None and member.has_body and is_unowned(service, agent):
        if same_body(service.run.state.body_set.models[agent].robot, member.robot):
            service.apply(Note(code="returned", agent=agent))
            return position_of(service.run.state, agent)
        service.apply(Depart(agent=agent))
    other_minds = [other for other in roster.members(agent) if other.role == "mind" and other is not current]
    if current is not None and agent in service.run.state.body_set.models:
        service.apply(Depart(agent=agent, role=current.role, lost=current.absent_since is not None))
        if current.has_body:
            forget_body(service, agent)
        else:
            service.latch.forget(agent)
    outcome = service.apply(_body_join(service, member))
    if outcome.code != "ok":
        if current is not None:
            remove_member(service, current)
        raise RequestRefusedError(outcome.refused or "value", outcome.text)
    for mind in other_minds:  # they join the new body
        service.apply(Join(agent=agent, robot=_named(mind.robot, agent)))
    return outcome.position or position_of(service.run.state, agent)


def _body_join(service: ServiceState, member: Member) -> Join:
    """Return the change by which a member joins: its body at its place in the scene, and at nobody else's."""
    agent, robot = member.agent, member.robot
    if not member.has_body:
        return Join(agent=agent, robot=_named(robot, agent))
    others = reserved_places(service, besides=agent)
    own = service.options.reserved.get(agent)
    if own in reserved_places(service) and robot.place is None and robot.position is None:
        robot = msgspec.structs.replace(robot, place=own)
    return Join(agent=agent, robot=_named(robot, agent), reserved=others)


def reserved_places(service: ServiceState, besides: str = "") -> tuple[str, ...]:
    """Return the places that are kept for agents, sorted. A place that this map does not have is nobody's."""
    grid = service.run.state.setup.floor.grid
    known = {spot.name for spot in grid.position} if grid is not None else set()
    reserved = service.options.reserved.items()
    return tuple(sorted(place for agent, place in reserved if agent != besides and place in known))


def is_unowned(service: ServiceState, agent: str) -> bool:
    """Return whether the body of an agent is here without the agent, which can happen after a restore.

    Bodies that an operator spawned do not count: they have no instance.
    """
    model = service.run.state.body_set.models.get(agent)
    return model is not None and model.robot.instance is not None and service.agents.roster.body(agent) is None


def bridge_status(state: State, agent: str, now: float) -> BridgeStatus:
    """Return the status of a real body that reports now, with its flags in the world. The body must be here."""
    flags = state.flags[:, state.body_set.index[agent]]
    return BridgeStatus(reported_at=now, stale=bool(flags[rows.STALE]), halted=bool(flags[rows.HALTED]))


def position_of(state: State, agent: str) -> Position:
    """Return the pose of a body. It must be here."""
    x, y, heading = state.numbers[[rows.X, rows.Y, rows.HEADING], state.body_set.index[agent]].tolist()
    return Position(x=x, y=y, heading=heading)


def _joined_reply(service: ServiceState, member: Member, position: Position, *, shows_key: bool) -> Joined:
    state, options = service.run.state, service.options
    model = state.body_set.models[member.agent]
    return Joined(
        run=state.run,
        tick=state.tick,
        session=member.session,
        parameters=service.parameters(),
        # An agent that returns to a laboratory gets the start pose of its chair, not the true pose.
        position=model.start if options.hide_truth else position,
        robot=nominal(model.robot) if options.hide_truth else model.robot,
        # Once only: anybody can read the instance of a process in its token, and join in its name.
        key=member.key if member.key and shows_key else None,
    )


def _named(robot: Robot, agent: str) -> Robot:
    return robot if robot.name is not None else msgspec.structs.replace(robot, name=agent)


# ------------------------------------------------------------ leaves


def handle_leave(service: ServiceState, query: Query) -> None:
    """Take a request to leave; it is answered when the agent has left."""
    if not query.name:
        if not query.has_wildcards:
            query.refuse(service.result("failed", f"leave/<agent>: {NAME_EXPECTED}"))
        else:
            query.close()
        return
    try:
        # A query without bytes gets the same words as one without a Session.
        data = query.data or b"{}"
        leave = decode(Leave, data, encoding_of(query.encoding, data) if query.data else Encoding.JSON)
    except WireError as error:
        query.refuse(service.result("failed", error.text))
        return
    members = service.agents.roster.members(query.name)
    leaving = next((member for member in members if member.session == leave.session), None)
    if leaving is None:
        why = "no such agent here" if not members else "expected the session of the last join, got another"
        query.reply(service.result("not-found", f"agent '{query.name}': {why}"))
        return
    queue_leave(service, leaving, query)


def queue_leave(service: ServiceState, member: Member, query: Query | None = None) -> None:
    """Let a member leave as soon as changes may act, and do not wait for its answers; then answer the query."""
    for agent, kind in member.answers():
        service.pacing.barrier.cancel(agent, kind)
    service.queue_change(partial(_leave, service, member, query))


def _leave(service: ServiceState, member: Member, query: Query | None, now: float) -> None:
    if member in service.agents.roster.members(member.agent):
        if member.role == "body" and service.agents.roster.mind(member.agent) is not None:
            fault = Fault("not-joined", f"agent '{member.agent}' has no body any more, so its mind has left too")
            outbound.send_error(service, member.agent, fault, now)
        service.apply(Depart(agent=member.agent, role=member.role))
        remove_member(service, member)
    if query is not None:
        query.reply(service.result("ok"))


def remove_member(service: ServiceState, member: Member) -> None:
    """Remove a member and, if its body is gone, everything that belonged to the body."""
    agent, state, roster = member.agent, service.run.state, service.agents.roster
    service.publisher.outlet.log_line(f"left agent={agent} role={member.role} tick={state.tick}")
    body_is_gone = agent not in state.body_set.models
    for each in roster.members(agent) if body_is_gone else (member,):
        for name, kind in each.answers():
            service.pacing.barrier.cancel(name, kind)
        roster.remove(each)
    if body_is_gone:
        forget_body(service, agent)
    _update_members(service, agent)


def forget_body(service: ServiceState, agent: str) -> None:
    """Drop everything that belonged to a body which is gone."""
    service.pacing.barrier.forget(agent)
    service.latch.forget(agent)
    service.command_ages.forget(agent)
    service.travelled.forget(agent)
    service.agents.leases.forget(agent)
    service.agents.bridges.pop(agent, None)


def _update_members(service: ServiceState, agent: str) -> None:
    """Update what depends on the members of an agent: expected answers, publishers, the published body."""
    agents, outlet = service.agents, service.publisher.outlet
    service.pacing.answers = agents.expected_answers() if service.pacing.lockstep else frozenset()
    mind, body = agents.roster.mind(agent), agents.roster.body(agent)
    reader = mind or body
    if (ended := agents.crews.place(agent, reader)) is not None:
        outlet.undeclare_crew(ended)
    if reader is None:
        agents.set_encoding(agent, None)
        service.error_limit.forget(agent)
        service.unasked_limit.forget(agent)
        outlet.undeclare_agent(agent)
    elif reader.crew:
        agents.set_encoding(agent, None)
    else:
        agents.set_encoding(agent, reader.encoding)
        outlet.declare_agent(agent, reader.encoding, (body or reader).encoding)
    if agent in service.run.state.body_set.models:
        outbound.publish_body(service, agent)
