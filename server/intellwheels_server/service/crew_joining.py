"""Joins and leaves of crews: many agents of one process with one query. Each is accepted or refused by itself."""

from __future__ import annotations

from functools import partial
from typing import Final

import msgspec

from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import RequestRefusedError, WireError
from intellwheels_schemas.messages import (
    AgentJoined,
    AgentRefused,
    CrewJoin,
    CrewJoined,
    CrewLeave,
    Joined,
    Refused,
    Robot,
)
from intellwheels_schemas.rules import MAX_CREW
from intellwheels_server.service import joining, outbound
from intellwheels_server.service.arrival import Query, Token
from intellwheels_server.service.connected_agents import WaitingCrew
from intellwheels_server.service.roster import presence_of
from intellwheels_server.service.service_state import ServiceState

TOKENS_WAIT: Final = 1.0
"""Seconds a join of a crew waits for its tokens, which travel separately."""
MAX_WAITING: Final = 64
"""Joins of crews that may wait for their tokens. Further ones are answered at once; their agents can try again."""


# ------------------------------------------------------------ tokens and deadlines


def take_crew_token(service: ServiceState, token: Token) -> None:
    """Note for the joins that wait that a token appeared; those that have all tokens go on."""
    agents = service.agents
    if not token.present or not agents.waiting_crews:
        return
    for waiting in agents.waiting_crews:
        waiting.missing.discard((token.agent, token.role, token.presence))
    for waiting in [each for each in agents.waiting_crews if not each.missing]:
        agents.waiting_crews.remove(waiting)
        _queue(service, waiting)


def handle_crew_deadlines(service: ServiceState, now: float) -> None:
    """Let the joins go on whose tokens did not all come in time; agents without a token are refused."""
    agents = service.agents
    for waiting in [each for each in agents.waiting_crews if each.until <= now]:
        agents.waiting_crews.remove(waiting)
        _queue(service, waiting)


# ------------------------------------------------------------ joins


def handle_crew_join(service: ServiceState, query: Query, now: float) -> None:
    """Take a request of a crew to join; it is answered when changes may act."""
    if not query.name:
        if not query.has_wildcards:
            query.refuse(Refused(code="name", text=f"crew/<crew>/join: {joining.NAME_EXPECTED}"))
        else:
            query.close()
        return
    try:
        encoding = encoding_of(query.encoding, query.data)
        join = decode(CrewJoin, query.data, encoding)
    except WireError as error:
        query.refuse(Refused(code=joining.REFUSED.get(error.code, "value"), text=error.text[:1000]))
        return
    if join.crew != query.name:
        text = f"CrewJoin.Crew: expected '{query.name}' as in the key, got '{join.crew}'"
        query.refuse(Refused(code="name", text=text))
        return
    roster = service.agents.roster
    presence = presence_of(join.instance, join.crew)
    missing = {
        (robot.name or "", robot.role, presence) for robot in join.robot
        if not roster.has_token(robot.name or "", robot.role, presence)
    }  # fmt: skip
    waiting = WaitingCrew(query, join, encoding, now + TOKENS_WAIT, missing)
    if missing and len(service.agents.waiting_crews) < MAX_WAITING:
        service.agents.waiting_crews.append(waiting)
    else:
        _queue(service, waiting)


def _queue(service: ServiceState, waiting: WaitingCrew) -> None:
    service.queue_change(partial(_join, service, waiting.query, waiting.join, waiting.encoding))


def _join(service: ServiceState, query: Query, join: CrewJoin, encoding: Encoding, now: float) -> None:
    crew = service.agents.crews.named.get(join.crew)
    if crew is not None and crew.instance != join.instance and crew.is_present:
        service.publisher.outlet.log_line(f"refused crew={join.crew} code=already-here")
        query.refuse(Refused(code="already-here", text=f"crew '{join.crew}' is already here, of another process"))
        return
    joined: dict[str, Joined] = {}
    refused: list[AgentRefused] = []
    for robot in join.robot:
        agent = robot.name or ""
        try:
            joined[agent] = _admit(service, join, robot, encoding, now)
        except RequestRefusedError as refusal:
            service.publisher.outlet.log_line(
                f"refused agent={agent} role={robot.role} crew={join.crew} code={refusal.code}"
            )
            refused.append(AgentRefused(agent=agent, code=refusal.code, text=refusal.text[:1000]))
    state = service.run.state
    query.reply(
        CrewJoined(
            crew=join.crew,
            run=state.run,
            tick=state.tick,
            parameters=service.parameters(),
            joined=tuple(
                AgentJoined(agent=agent, session=each.session, position=each.position, robot=each.robot)
                for agent, each in joined.items()
            ),
            refused=tuple(refused),
        )
    )
    if joined and service.pacing.measures_are_out:
        outbound.put_crew_measures(service, join.crew, list(joined))


def _admit(service: ServiceState, join: CrewJoin, robot: Robot, encoding: Encoding, now: float) -> Joined:
    """Let an agent join with its crew.

    Raises:
        RequestRefusedError: It may not.
    """
    agent = robot.name or ""
    if robot.role == "body":
        raise RequestRefusedError("value", "Robot.Role: expected both or mind in a crew, got body; join it by itself")
    if robot.type == "real":
        raise RequestRefusedError("value", "Robot.Type: expected simulated in a crew, got real; join it by itself")
    if robot.crew not in (None, join.crew):
        raise RequestRefusedError("value", f"Robot.Crew: expected '{join.crew}' as in the key, got '{robot.crew}'")
    if robot.instance not in (None, join.instance):
        raise RequestRefusedError(
            "value", f"Robot.Instance: expected {join.instance} as in the CrewJoin, got {robot.instance}"
        )
    crew = service.agents.crews.named.get(join.crew)
    if crew is not None and agent not in crew.members and len(crew.members) >= MAX_CREW:
        raise RequestRefusedError(
            "limit", f"CrewJoin.Robot: expected at most {MAX_CREW} agents in a crew, got one more"
        )
    robot = msgspec.structs.replace(robot, crew=join.crew, instance=join.instance)
    return joining.admit(service, agent, robot, encoding, None, now, join.crew)


# ------------------------------------------------------------ leaves


def handle_crew_leave(service: ServiceState, query: Query) -> None:
    """Take a request of a crew to leave; it is answered when all its agents that could be found have left."""
    if not query.name:
        if not query.has_wildcards:
            query.refuse(service.result("failed", f"crew/<crew>/leave: {joining.NAME_EXPECTED}"))
        else:
            query.close()
        return
    try:
        crew_leave = decode(CrewLeave, query.data, encoding_of(query.encoding, query.data))
    except WireError as error:
        query.refuse(service.result("failed", error.text))
        return
    crew = service.agents.crews.named.get(query.name)
    members = crew.members if crew is not None else {}
    leaving = [
        members[leave.agent] for leave in crew_leave.leave
        if leave.agent in members and members[leave.agent].session == leave.session
    ]  # fmt: skip
    for member in leaving:
        joining.queue_leave(service, member)
    lacks = len(crew_leave.leave) - len(leaving)
    text = f"crew '{query.name}': expected its agents, each with the session of its last join; got {lacks} others"
    service.queue_change(lambda _now: query.reply(service.result("not-found", text) if lacks else service.result("ok")))
