"""The members: their roles, instances, sessions and presence. Pure: time is passed in.

A member is one role of one agent. It belongs to one instance of a program, whose messages carry its session. When its
token disappears, the member stays for a grace time, in which the instance may return or a successor may replace it.

    the role that a join asks for is             decision
    free                                         a new member with a new session
    taken by the same instance                   the same session: its reply or its connection was lost
    taken, and the join shows the session of it  a new session; the old one is void (not of a real robot)
    taken, but the token of its member is gone   a new session; the old one is void
    taken, and its member is present             refused: already-here
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from typing import Final

import msgspec

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Robot, Role
from intellwheels_server.service.barrier import Answer
from intellwheels_server.service.error_replies import Fault

OPERATOR: Final = "operator"
"""The sender name of operators. No agent may have this name."""
MAX_BODIES: Final = 10_000
"""Largest number of bodies in a world."""
MAX_TOKENS: Final = 40_000
"""Largest number of tokens remembered. A further one takes the place of the oldest that belongs to no member."""
MAX_INSTANCES: Final = 64
"""Largest number of tokens remembered for one role of one agent. Further ones are ignored."""


def new_hex() -> str:
    """Return 16 random hex digits, for the name of a run, a session or a lease."""
    return secrets.token_hex(8)


def presence_of(instance: str, crew: str) -> str:
    """Return what the end of a token says: the instance, and the crew if there is one. A crew needs tokens of its own.

    By the key of a token a router knows that the agent's owner lets this crew act for it.
    """
    return f"{instance}/{crew}" if crew else instance


@dataclass(slots=True, eq=False)
class Member:
    """A role of an agent that has joined.

    Attributes:
        agent: The agent.
        role: The role.
        instance: The process that has the role.
        session: Its messages carry this to prove that they are its own.
        encoding: The encoding of its join, which the simulator uses too.
        robot: The robot as sent. A successor with the same robot keeps the body.
        real: Whether the body is a real chair.
        simulated_hardware: Whether that chair is itself simulated.
        barrier: Whether lockstep waits for it.
        key: What makes the codes of its poses and powers, if its body is real; else empty.
        crew: The crew whose keys carry its actions and measures, or empty.
        absent_since: When its token disappeared, s, or None.
    """

    agent: str
    role: Role
    instance: str
    session: str
    encoding: Encoding
    robot: Robot
    real: bool = False
    simulated_hardware: bool = False
    barrier: bool = True
    key: str = ""
    crew: str = ""
    absent_since: float | None = None

    @property
    def presence(self) -> str:
        """What its token says besides agent and role."""
        return presence_of(self.instance, self.crew)

    @property
    def is_mind(self) -> bool:
        """Whether it writes actions."""
        return self.role != "body"

    @property
    def has_body(self) -> bool:
        """Whether it owns the body."""
        return self.role != "mind"

    def answers(self) -> tuple[Answer, ...]:
        """Return what lockstep expects of it at each tick: actions of a mind, the pose of a real body."""
        if not self.barrier:
            return ()
        found: list[Answer] = []
        if self.is_mind:
            found.append((self.agent, "actions"))
        if self.has_body and self.real:
            found.append((self.agent, "pose"))
        return tuple(found)


@dataclass(slots=True, eq=False)
class _Roles:
    """The members of one agent."""

    by_role: dict[Role, Member] = field(default_factory=dict)

    @property
    def mind(self) -> Member | None:
        """The member that writes actions."""
        return self.by_role.get("both") or self.by_role.get("mind")

    @property
    def body(self) -> Member | None:
        """The member that owns the body."""
        return self.by_role.get("both") or self.by_role.get("body")


class Roster:
    """All members, and the tokens that are present."""

    def __init__(self) -> None:
        self._agents: dict[str, _Roles] = {}
        self._tokens: dict[tuple[str, Role], set[str]] = {}
        self._ages: dict[tuple[str, Role, str], None] = {}  # all tokens, the oldest first
        self._absent: set[Member] = set()

    # ------------------------------------------------------------ queries

    def __contains__(self, agent: str) -> bool:
        return agent in self._agents

    @property
    def agents(self) -> tuple[str, ...]:
        """The names of the agents that have joined, sorted."""
        return tuple(sorted(self._agents))

    def members(self, agent: str) -> tuple[Member, ...]:
        """Return the members of an agent."""
        found = self._agents.get(agent)
        return tuple(found.by_role.values()) if found else ()

    def all_members(self) -> list[Member]:
        """Return all members, sorted by the names of their agents."""
        return [member for agent in self.agents for member in self._agents[agent].by_role.values()]

    def mind(self, agent: str) -> Member | None:
        """Return the member that writes the agent's actions."""
        found = self._agents.get(agent)
        return found.mind if found else None

    def body(self, agent: str) -> Member | None:
        """Return the member that owns the agent's body."""
        found = self._agents.get(agent)
        return found.body if found else None

    def has_token(self, agent: str, role: Role, presence: str) -> bool:
        """Return whether the token of this instance is present; `presence` is what `presence_of` returns."""
        return presence in self._tokens.get((agent, role), ())

    # ------------------------------------------------------------ presence

    def token(self, agent: str, role: Role, presence: str, present: bool, now: float) -> Member | None:
        """Note a token that appeared or disappeared; return the member whose presence this changes, if any.

        `presence` is what `presence_of` returns.
        """
        if present:
            self._remember(agent, role, presence)
        else:
            self._forget(agent, role, presence)
        member = self._member(agent, role)
        if member is None or member.presence != presence or present == (member.absent_since is None):
            return None
        member.absent_since = None if present else now
        (self._absent.discard if present else self._absent.add)(member)
        return member

    def _remember(self, agent: str, role: Role, presence: str) -> None:
        presences = self._tokens.get((agent, role), set())
        if presence in presences or (len(presences) >= MAX_INSTANCES and not self._is_member(agent, role, presence)):
            return
        # Members are fewer, so this ends.
        while len(self._ages) >= MAX_TOKENS:
            oldest = next(iter(self._ages))
            self._forget(*oldest)
            if self._is_member(*oldest):
                self._note(*oldest)
        self._note(agent, role, presence)

    def _note(self, agent: str, role: Role, presence: str) -> None:
        self._tokens.setdefault((agent, role), set()).add(presence)
        self._ages[agent, role, presence] = None

    def _forget(self, agent: str, role: Role, presence: str) -> None:
        if (agent, role, presence) not in self._ages:
            return
        del self._ages[agent, role, presence]
        presences = self._tokens[agent, role]
        presences.discard(presence)
        if not presences:
            del self._tokens[agent, role]

    def lost(self, now: float, grace: float) -> list[Member]:
        """Return the members whose token has been gone for the grace time or longer."""
        return [m for m in self._absent if m.absent_since is not None and now - m.absent_since >= grace]

    def due(self, grace: float) -> float:
        """Return when the next grace time ends."""
        return min((m.absent_since + grace for m in self._absent if m.absent_since is not None), default=float("inf"))

    # ------------------------------------------------------------ joining and leaving

    def predecessor(self, agent: str, robot: Robot, session: str | None, crew: str = "") -> Member | None:
        """Return the member that a join would replace, or None if the role is free.

        Args:
            agent: The agent in the key.
            robot: What it sent; `instance` must be known by now.
            session: The earlier session that the join shows, or None.
            crew: The crew that it joins with, if any.

        Raises:
            RequestRefusedError: `already-here`, `name`, `no-token`, `full`.
        """
        role = robot.role
        if agent == OPERATOR:
            raise RequestRefusedError("name", f"the name '{OPERATOR}' is reserved for people; take another")
        if robot.name is not None and robot.name != agent:
            raise RequestRefusedError("name", f"Robot.Name: expected '{agent}' as in the key, got '{robot.name}'")
        if robot.instance is None or not self.has_token(agent, role, presence_of(robot.instance, crew)):
            token = f"in/{agent}/alive/{role}/{presence_of(robot.instance or '<Robot.Instance>', crew)}"
            raise RequestRefusedError("no-token", f"expected a liveliness token {token} before the join, got none")
        current = self._member(agent, role)
        if current is None:
            conflicting = [m for m in self.members(agent) if "both" in (role, m.role)]
            if conflicting:
                raise RequestRefusedError("already-here", f"agent '{agent}' is already here, as {conflicting[0].role}")
            if role != "mind" and len(self._agents) >= MAX_BODIES:
                raise RequestRefusedError("full", f"expected at most {MAX_BODIES} bodies, got one more")
            return None
        # The session of a real robot is in its poses, which anybody can read in an open world.
        shows_session = session == current.session and not current.key
        same_process = robot.instance == current.instance or shows_session
        if same_process or not self.has_token(agent, role, current.presence):
            return current
        raise RequestRefusedError("already-here", f"agent '{agent}' is already here")

    def only_instance(self, agent: str, role: Role) -> str | None:
        """Return the instance of an agent that did not name one: the instance with a token, if there is exactly one."""
        instances = [each for each in self._tokens.get((agent, role), ()) if "/" not in each]
        return instances[0] if len(instances) == 1 else None

    def add(self, member: Member) -> None:
        """Add a member, in place of the one that had its role."""
        roles = self._agents.setdefault(member.agent, _Roles())
        old = roles.by_role.get(member.role)
        if old is not None:
            self._absent.discard(old)
        roles.by_role[member.role] = member

    def remove(self, member: Member) -> None:
        """Remove a member."""
        self._absent.discard(member)
        roles = self._agents.get(member.agent)
        if roles is not None and roles.by_role.get(member.role) is member:
            del roles.by_role[member.role]
            if not roles.by_role:
                del self._agents[member.agent]

    def _is_member(self, agent: str, role: Role, presence: str) -> bool:
        member = self._member(agent, role)
        return member is not None and member.presence == presence

    def _member(self, agent: str, role: Role) -> Member | None:
        roles = self._agents.get(agent)
        return roles.by_role.get(role) if roles else None


def role_text(member: Member) -> str | None:
    """Return the role of a member as notes name it, or None if it has both."""
    return None if member.role == "both" else member.role


def is_return(current: Member | None, member: Member) -> bool:
    """Return whether a member is the same process as the one that it replaces."""
    return current is not None and current.instance == member.instance


def same_body(old: Robot, new: Robot) -> bool:
    """Return whether two robots are the same body, apart from name, instance, crew and start."""
    return _anonymous(old) == _anonymous(new)


def _anonymous(robot: Robot) -> Robot:
    return msgspec.structs.replace(robot, name=None, instance=None, crew=None, place=None, position=None)


def check_session(
    member: Member | None, all_roles: tuple[Member, ...], session: str | None, where: str
) -> Fault | None:
    """Return what is wrong with the session of a message, or None.

    Args:
        member: The member that may send this message, or None if there is none.
        all_roles: All members of the agent.
        session: The session in the message.
        where: The message's class.
    """
    if member is None:
        if not all_roles:
            return Fault("not-joined", f"{where}: expected an agent that has joined, got one that has not", where)
        return Fault("role", f"{where}: not for the role {all_roles[0].role}", where)
    if session == member.session:
        return None
    if any(other.session == session for other in all_roles):
        return Fault("role", f"{where}: not for the role this session has", where)
    return Fault("session", f"{where}.Session: expected the session of the last join, got another", f"{where}.Session")
