"""Joins, and everything that follows when members come and go."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, TypeVar

import msgspec

from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import RequestRefusedError, WireError
from intellwheels_schemas.file_records import Depart, Join, Note
from intellwheels_schemas.messages import ErrorCode, Joined, Position, Record, Refused, RefusedCode, Robot
from intellwheels_schemas.metal_codes import new_key
from intellwheels_schemas.rules import has_motors
from intellwheels_server.service import outbound
from intellwheels_server.service.arrival import Query
from intellwheels_server.service.body_places import body_join, bridge_status, is_unowned, named, position_of
from intellwheels_server.service.connected_agents import WaitingJoin
from intellwheels_server.service.roster import MAX_BODIES, Member, Roster, is_return, new_hex, role_text, same_body
from intellwheels_server.service.sensor_budget import check_sensor_budget
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.service.start_report import report_joined
from intellwheels_server.service.truth_filter import nominal
from intellwheels_server.world.sensors import rays_of

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

# ------------------------------------------------------------ joins


_M = TypeVar("_M", bound=Record)


def read_join(query: Query, cls: type[_M], key: str) -> tuple[_M, Encoding] | None:
    """Return what a request to join says, and its encoding; None if it cannot be read. Then it has its answer.

    Args:
        query: The request.
        cls: The class of what it says.
        key: The pattern of its key, for the text of a refusal.
    """
    if not query.name:
        if not query.has_wildcards:
            query.refuse(Refused(code="name", text=f"{key}: {NAME_EXPECTED}"))
        else:
            query.close()
        return None
    try:
        encoding = encoding_of(query.encoding, query.data)
        return decode(cls, query.data, encoding), encoding
    except WireError as error:
        query.refuse(Refused(code=REFUSED.get(error.code, "value"), text=error.text[:1000]))
        return None


def handle_join(service: ServiceState, query: Query, now: float) -> None:
    """Take a request to join; it is answered when changes may act."""
    found = read_join(query, Robot, "join/<agent>")
    if found is None:
        return
    robot, encoding = found
    if not has_token(service.agents.roster, query.name, robot):
        if len(service.agents.waiting_joins) < MAX_WAITING:
            service.agents.waiting_joins.append(WaitingJoin(query, robot, encoding, now + TOKEN_WAIT))
        else:
            join(service, query, robot, encoding, now)
        return
    queue_join(service, query, robot, encoding)


def has_token(roster: Roster, agent: str, robot: Robot) -> bool:
    """Return whether the token of the agent that sent a robot is present."""
    instance = robot.instance or roster.only_instance(agent, robot.role)
    return instance is not None and roster.has_token(agent, robot.role, instance)


class JoinGroup:
    """Joins that wait next to each other in the queue of changes, and are taken together."""

    def __init__(self, service: ServiceState) -> None:
        self.joins: list[tuple[Query, Robot, Encoding]] = []
        self._service = service

    def __call__(self, now: float) -> None:
        """Take them, in order: free names with one change of the bodies, all others one by one."""
        service, together = self._service, _Together(self._service)
        for query, robot, encoding in self.joins:
            if not together.add(query, robot, encoding):
                together.make(now)
                if not together.add(query, robot, encoding):
                    join(service, query, robot, encoding, now)
        together.make(now)


class _Together:
    """Agents with free names, whose bodies are put into the world at once."""

    def __init__(self, service: ServiceState) -> None:
        self._service = service
        self._members: dict[str, tuple[Query, Member]] = {}
        self._rays = 0.0

    def add(self, query: Query, robot: Robot, encoding: Encoding) -> bool:
        """Take an agent in and return True, unless it has to be handled by itself, or after the others."""
        service, agent = self._service, query.name
        roster, models = service.agents.roster, service.run.state.body_set.models
        if robot.role == "mind" or agent in models or agent in roster or agent in self._members:
            return False
        if len(models) + len(self._members) >= MAX_BODIES:
            return False
        try:
            member, _ = _checked(service, query, robot, encoding, self._rays)
        except RequestRefusedError:
            return False
        self._members[agent] = query, member
        self._rays += rays_of(robot)
        return True

    def make(self, now: float) -> None:
        """Let them join and answer them."""
        service, members = self._service, self._members
        if not members:
            return
        self._members, self._rays = {}, 0.0
        outcomes = service.apply_all([body_join(service, member) for _, member in members.values()])
        joined = []
        for (query, member), outcome in zip(members.values(), outcomes, strict=True):
            if outcome.code == "ok":
                service.agents.roster.add(member)
                joined.append((query, member, outcome.position or position_of(service.run.state, member.agent)))
            else:
                refuse(service, query, member.robot, RequestRefusedError(outcome.refused or "value", outcome.text))
        _update_members(service, [member.agent for _, member, _ in joined])
        for query, member, position in joined:
            query.reply(_enter(service, member, None, position, now))


def queue_join(service: ServiceState, query: Query, robot: Robot, encoding: Encoding) -> None:
    """Let an agent join as soon as changes may act, together with those that wait next to it."""
    last = service.last_queued
    if not isinstance(last, JoinGroup):
        last = JoinGroup(service)
        service.queue_change(last)
    last.joins.append((query, robot, encoding))


def refuse(service: ServiceState, query: Query, robot: Robot, refusal: RequestRefusedError) -> None:
    """Refuse a join, and say so in the log."""
    service.publisher.outlet.log_line(f"refused agent={query.name} role={robot.role} code={refusal.code}")
    query.refuse(Refused(code=refusal.code, text=refusal.text[:1000]))


def join(service: ServiceState, query: Query, robot: Robot, encoding: Encoding, now: float) -> None:
    """Let an agent join now and answer it."""
    try:
        joined = _admit(service, query, robot, encoding, now)
    except RequestRefusedError as refusal:
        refuse(service, query, robot, refusal)
        return
    query.reply(joined)


def _admit(service: ServiceState, query: Query, robot: Robot, encoding: Encoding, now: float) -> Joined:
    """Let an agent join and return the reply.

    Raises:
        RequestRefusedError: It may not join.
    """
    agent = query.name
    member, current = _checked(service, query, robot, encoding)
    position = _give_body(service, member, current)
    service.agents.roster.add(member)
    _update_members(service, (agent,))
    return _enter(service, member, current, position, now)


def _checked(
    service: ServiceState, query: Query, robot: Robot, encoding: Encoding, waiting: float = 0.0
) -> tuple[Member, Member | None]:
    """Return an agent as a member, and the member that it replaces.

    Args:
        service: The service.
        query: How it asked: by itself or with its crew, and with its earlier session or without.
        robot: What it sent.
        encoding: The encoding of what it sent.
        waiting: Rays per tick of those that join together with it.

    Raises:
        RequestRefusedError: It may not join.
    """
    agent, session = query.name, query.parameters.get("session")
    crew = (robot.crew or "") if query.topic == "crew-join" else ""
    agents, pacing = service.agents, service.pacing
    if robot.format is not None:
        raise RequestRefusedError("field", "Robot.Format: expected none in a join; it belongs to files")
    if robot.crew != (crew or None):
        raise RequestRefusedError("value", f"Robot.Crew: expected none in join/{agent}; crews join at crew/<crew>/join")
    if robot.instance is None:
        robot = msgspec.structs.replace(robot, instance=agents.roster.only_instance(agent, robot.role))
    current = agents.roster.predecessor(agent, robot, session, crew)
    model = service.run.state.body_set.models.get(agent)
    if robot.role == "mind":
        if model is None:
            raise RequestRefusedError("no-body", f"agent '{agent}' has no body here yet; join again when it has")
        body = model.robot
    else:
        body = robot
        _check_real(service, robot)
        check_sensor_budget(service, agent, robot, waiting)
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
    if member.real and member.has_body:
        member.key = current.key if current is not None and is_return(current, member) and current.key else new_key()
    return member, current


def _enter(service: ServiceState, member: Member, current: Member | None, position: Position, now: float) -> Joined:
    """Let a member take part that has its body and is in the roster; return the reply."""
    agent, agents, pacing = member.agent, service.agents, service.pacing
    agents.deleted.pop(agent, None)
    pacing.barrier.reset_member(agent)
    if member.real and member.has_body:
        # The entry of a body that stays is kept: it records what the world knows, such as that the pose is old.
        agents.bridges.setdefault(agent, bridge_status(service.run.state, agent, now))
    report_joined(service, member, position, starts=current is None)
    if pacing.barrier_open and pacing.lockstep:
        pacing.barrier.add(member.answers())
    if not member.crew and pacing.measures_are_out:
        outbound.put_measures(service, agent)
    return _joined_reply(service, member, position, shows_key=not is_return(current, member))


def _check_real(service: ServiceState, robot: Robot) -> None:
    if robot.type == "real" and robot.hardware != "simulated" and not service.pacing.at_real_speed:
        raise RequestRefusedError(
            "real-in-lockstep",
            "Robot.Type: expected simulated, got real; real hardware can join only in real time at speed 1",
        )


def _give_body(service: ServiceState, member: Member, current: Member | None) -> Position:
    """Give a member its body and return its pose. A body that is here already is kept if possible."""
    agent, roster = member.agent, service.agents.roster
    model = service.run.state.body_set.models.get(agent)
    if current is not None and model is not None and same_body(current.robot, member.robot):
        if current.absent_since is not None or current.instance != member.instance:
            service.apply(Note(code="returned", agent=agent, text=role_text(member)))
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
    outcome = service.apply(body_join(service, member))
    if outcome.code != "ok":
        if current is not None:
            remove_member(service, current)
        raise RequestRefusedError(outcome.refused or "value", outcome.text)
    for mind in other_minds:  # they join the new body
        service.apply(Join(agent=agent, robot=named(mind.robot, agent)))
    return outcome.position or position_of(service.run.state, agent)


def _joined_reply(service: ServiceState, member: Member, position: Position, *, shows_key: bool) -> Joined:
    state, options = service.run.state, service.options
    model = state.body_set.models[member.agent]
    robot = msgspec.structs.replace(model.robot, crew=member.crew or None)
    return Joined(
        run=state.run,
        tick=state.tick,
        session=member.session,
        parameters=service.parameters(),
        # An agent that returns to a laboratory gets the start pose of its chair, not the true pose.
        position=model.start if options.hide_truth else position,
        robot=nominal(robot) if options.hide_truth else robot,
        # Once only: anybody can read the instance of a process in its token, and join in its name.
        key=member.key if member.key and shows_key else None,
    )


# ------------------------------------------------------------ what follows


def remove_member(service: ServiceState, *members: Member) -> None:
    """Remove members and, if the body of one is gone, everything that belonged to the body."""
    state, roster = service.run.state, service.agents.roster
    for member in members:
        agent = member.agent
        service.publisher.outlet.log_line(f"left agent={agent} role={member.role} tick={state.tick}")
        body_is_gone = agent not in state.body_set.models
        for each in roster.members(agent) if body_is_gone else (member,):
            for name, kind in each.answers():
                service.pacing.barrier.cancel(name, kind)
            roster.remove(each)
        if body_is_gone:
            forget_body(service, agent)
    _update_members(service, [member.agent for member in members])


def forget_body(service: ServiceState, agent: str) -> None:
    """Drop everything that belonged to a body which is gone."""
    service.pacing.barrier.forget(agent)
    service.latch.forget(agent)
    service.command_ages.forget(agent)
    service.travelled.forget(agent)
    service.agents.leases.forget(agent)
    service.agents.bridges.pop(agent, None)


def _update_members(service: ServiceState, changed: Sequence[str]) -> None:
    """Update what depends on the members of some agents: expected answers, publishers, the published bodies."""
    agents, outlet = service.agents, service.publisher.outlet
    service.pacing.answers = agents.expected_answers() if service.pacing.lockstep else frozenset()
    for agent in changed:
        mind, body = agents.roster.mind(agent), agents.roster.body(agent)
        reader = mind or body
        if (ended := agents.crews.place(agent, reader)) is not None:
            outlet.undeclare_crew(ended)
            service.error_limit.forget(f"crew/{ended}")
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
