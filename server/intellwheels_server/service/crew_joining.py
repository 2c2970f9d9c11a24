"""Joins and leaves of crews: many agents of one process with one query. Each is accepted or refused by itself."""

from __future__ import annotations

from collections.abc import Collection
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
    Record,
    Refused,
    Robot,
)
from intellwheels_schemas.rules import MAX_CREW
from intellwheels_server.service import joining, leaving, outbound
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
    found = joining.read_join(query, CrewJoin, "crew/<crew>/join")
    if found is None:
        return
    join, encoding = found
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
    replies = _Replies(service, query, join)
    group = joining.JoinGroup(service)
    names = set(crew.members) if crew is not None else set()
    for robot in join.robot:
        agent = robot.name or ""
        one = Query("crew-join", agent, b"", encoding.value, partial(replies.take, agent), lambda: None)
        try:
            group.joins.append((one, _checked(join, robot, names), encoding))
            names.add(agent)
        except RequestRefusedError as refusal:
            joining.refuse(service, one, robot, refusal)
    group(now)
    replies.send()


class _Replies:
    """The replies to the agents of a crew, which get one together."""

    def __init__(self, service: ServiceState, query: Query, join: CrewJoin) -> None:
        self._service, self._query, self._join = service, query, join
        self._joined: list[AgentJoined] = []
        self._refused: list[AgentRefused] = []

    def take(self, agent: str, message: Record, _encoding: Encoding, _ok: bool, _name: str | None) -> None:
        """Take the reply to one agent."""
        if isinstance(message, Joined):
            self._joined.append(
                AgentJoined(agent=agent, session=message.session, position=message.position, robot=message.robot)
            )
        elif isinstance(message, Refused):
            self._refused.append(AgentRefused(agent=agent, code=message.code, text=message.text))

    def send(self) -> None:
        """Send them, and then the first measures."""
        service, crew, state = self._service, self._join.crew, self._service.run.state
        joined = CrewJoined(
            crew=crew, run=state.run, tick=state.tick, parameters=service.parameters(), joined=tuple(self._joined),
            refused=tuple(self._refused),
        )  # fmt: skip
        self._query.reply(joined)
        if self._joined and service.pacing.measures_are_out:
            outbound.put_crew_measures(service, crew, [each.agent for each in self._joined])


def _checked(join: CrewJoin, robot: Robot, names: Collection[str]) -> Robot:
    """Return the robot of an agent that may be of a crew, with what it has in common with the others.

    Args:
        join: The request of the crew.
        robot: The robot in it.
        names: The agents that are in the crew, or will be.

    Raises:
        RequestRefusedError: It may not.
    """
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
    if robot.name not in names and len(names) >= MAX_CREW:
        raise RequestRefusedError(
            "limit", f"CrewJoin.Robot: expected at most {MAX_CREW} agents in a crew, got one more"
        )
    return msgspec.structs.replace(robot, crew=join.crew, instance=join.instance)


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
    if crew_leave.crew != query.name:
        text = f"CrewLeave.Crew: expected '{query.name}' as in the key, got '{crew_leave.crew}'"
        query.refuse(service.result("failed", text))
        return
    crew = service.agents.crews.named.get(query.name)
    members = crew.members if crew is not None else {}
    going = [
        members[leave.agent] for leave in crew_leave.leave
        if leave.agent in members and members[leave.agent].session == leave.session
    ]  # fmt: skip
    for member in going:
        leaving.queue_leave(service, member)
    lacks = len(crew_leave.leave) - len(going)
    text = f"crew '{query.name}': expected its agents, each with the session of its last join; got {lacks} others"
    service.queue_change(lambda _now: query.reply(service.result("not-found", text) if lacks else service.result("ok")))
