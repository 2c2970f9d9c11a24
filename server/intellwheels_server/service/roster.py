"""Who is here: roles, instances, sessions and presence. Pure: time is passed in.

A seat is one role of one agent, held by one instance of a program that shows its session. A seat whose token is gone
is kept for a grace time, in which its holder may return or a successor take it over.

    asks for a seat that is      decision
    free                         a new seat and session
    held by the same instance    the same session (its reply was lost, or it lost its way)
    held, old session shown      a new session; the old one counts no more
    held, token gone             a new session; the old one counts no more
    held, token there            refused: already-here
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
"""The name operators speak under; no agent's."""
MAX_BODIES: Final = 10_000
"""Bodies in a world."""
MAX_TOKENS: Final = 40_000
"""Tokens remembered; more are not looked at."""


def new_hex() -> str:
    """Return 16 new random hex digits: a run, a session, a lease."""
    return secrets.token_hex(8)


@dataclass(slots=True, eq=False)
class Seat:
    """A role of an agent that is here.

    Attributes:
        agent: Whose.
        role: Which.
        instance: The process that holds it.
        session: What its messages show.
        encoding: How it joined, and so how it is answered.
        robot: As it was sent, compared when somebody takes over.
        real: Whether the body is a real chair.
        simulated_hardware: Whether that chair is itself a simulation.
        barrier: Whether lockstep waits for it.
        absent_since: When its token was lost, in the caller's seconds, or None.
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
    absent_since: float | None = None

    @property
    def thinks(self) -> bool:
        """Whether it writes actions."""
        return self.role != "body"

    @property
    def embodies(self) -> bool:
        """Whether it owns the body."""
        return self.role != "mind"

    def answers(self) -> tuple[Answer, ...]:
        """Return what lockstep awaits of it each tick: actions of a mind, the pose of a real body."""
        if not self.barrier:
            return ()
        found: list[Answer] = []
        if self.thinks:
            found.append((self.agent, "actions"))
        if self.embodies and self.real:
            found.append((self.agent, "pose"))
        return tuple(found)


@dataclass(slots=True, eq=False)
class Seats:
    """The seats of one agent."""

    by_role: dict[Role, Seat] = field(default_factory=dict)

    @property
    def mind(self) -> Seat | None:
        """The seat that writes actions."""
        return self.by_role.get("both") or self.by_role.get("mind")

    @property
    def body(self) -> Seat | None:
        """The seat that owns the body."""
        return self.by_role.get("both") or self.by_role.get("body")


class Roster:
    """All seats, and whose tokens are there."""

    def __init__(self) -> None:
        self._agents: dict[str, Seats] = {}
        self._tokens: dict[tuple[str, Role], set[str]] = {}
        self._token_count = 0
        self._absent: set[Seat] = set()

    # ------------------------------------------------------------ looking

    def __contains__(self, agent: str) -> bool:
        return agent in self._agents

    @property
    def agents(self) -> tuple[str, ...]:
        """The names of those with a seat, sorted."""
        return tuple(sorted(self._agents))

    def seats(self, agent: str) -> tuple[Seat, ...]:
        """Return an agent's seats."""
        found = self._agents.get(agent)
        return tuple(found.by_role.values()) if found else ()

    def every_seat(self) -> list[Seat]:
        """Return all seats, by agents' names."""
        return [seat for agent in self.agents for seat in self._agents[agent].by_role.values()]

    def mind(self, agent: str) -> Seat | None:
        """Return the seat that writes the agent's actions."""
        found = self._agents.get(agent)
        return found.mind if found else None

    def body(self, agent: str) -> Seat | None:
        """Return the seat that owns the agent's body."""
        found = self._agents.get(agent)
        return found.body if found else None

    def has_token(self, agent: str, role: Role, instance: str) -> bool:
        """Return whether a token of this instance is there."""
        return instance in self._tokens.get((agent, role), ())

    # ------------------------------------------------------------ presence

    def token(self, agent: str, role: Role, instance: str, present: bool, now: float) -> Seat | None:
        """Note a token that came or went and return the seat whose presence this changed, if any."""
        instances = self._tokens.get((agent, role))
        if present:
            if instances is None:
                if self._token_count >= MAX_TOKENS:
                    return None
                instances = self._tokens[agent, role] = set()
            if instance not in instances and self._token_count < MAX_TOKENS:
                instances.add(instance)
                self._token_count += 1
        elif instances is not None and instance in instances:
            instances.discard(instance)
            self._token_count -= 1
            if not instances:
                del self._tokens[agent, role]
        seat = self._seat(agent, role)
        if seat is None or seat.instance != instance or present == (seat.absent_since is None):
            return None
        seat.absent_since = None if present else now
        (self._absent.discard if present else self._absent.add)(seat)
        return seat

    def lost(self, now: float, grace: float) -> list[Seat]:
        """Return the seats whose token has been gone for longer than the grace time."""
        return [s for s in self._absent if s.absent_since is not None and now - s.absent_since >= grace]

    def due(self, grace: float) -> float:
        """Return when the next grace time ends."""
        return min((s.absent_since + grace for s in self._absent if s.absent_since is not None), default=float("inf"))

    # ------------------------------------------------------------ coming and going

    def holder(self, agent: str, robot: Robot, shown: str | None) -> Seat | None:
        """Return the seat that a join would take over, or None when it needs a new one.

        Args:
            agent: Who joins.
            robot: What it sent; `instance` must be known by now.
            shown: The old session it shows, or None.

        Raises:
            RequestRefusedError: `already-here`, `name`, `no-token`, `full`.
        """
        role = robot.role
        if agent == OPERATOR:
            raise RequestRefusedError("name", f"the name '{OPERATOR}' is reserved for people; take another")
        if robot.name is not None and robot.name != agent:
            raise RequestRefusedError("name", f"Robot.Name: expected '{agent}' as in the key, got '{robot.name}'")
        if robot.instance is None or not self.has_token(agent, role, robot.instance):
            instance = robot.instance or "<Robot.Instance>"
            raise RequestRefusedError(
                "no-token", f"expected a liveliness token in/{agent}/alive/{role}/{instance} before the join, got none"
            )
        held = self._seat(agent, role)
        if held is None:
            rivals = [s for s in self.seats(agent) if "both" in (role, s.role)]
            if rivals:
                raise RequestRefusedError("already-here", f"agent '{agent}' is already here, as {rivals[0].role}")
            if role != "mind" and len(self._agents) >= MAX_BODIES:
                raise RequestRefusedError("full", f"expected at most {MAX_BODIES} bodies, got one more")
            return None
        if robot.instance == held.instance or shown == held.session or not self.has_token(agent, role, held.instance):
            return held
        raise RequestRefusedError("already-here", f"agent '{agent}' is already here")

    def only_instance(self, agent: str, role: Role) -> str | None:
        """Return the instance of an agent that did not say it: the one with a token, if it is one only."""
        instances = self._tokens.get((agent, role), set())
        return next(iter(instances)) if len(instances) == 1 else None

    def sit(self, seat: Seat) -> None:
        """Give a seat to its holder, instead of who had it."""
        seats = self._agents.setdefault(seat.agent, Seats())
        old = seats.by_role.get(seat.role)
        if old is not None:
            self._absent.discard(old)
        seats.by_role[seat.role] = seat

    def rise(self, seat: Seat) -> None:
        """Take a seat away."""
        self._absent.discard(seat)
        seats = self._agents.get(seat.agent)
        if seats is not None and seats.by_role.get(seat.role) is seat:
            del seats.by_role[seat.role]
            if not seats.by_role:
                del self._agents[seat.agent]

    def _seat(self, agent: str, role: Role) -> Seat | None:
        seats = self._agents.get(agent)
        return seats.by_role.get(role) if seats else None


def same_body(old: Robot, new: Robot) -> bool:
    """Return whether a successor asks for the very body that is here, wherever it wants to start."""
    return _anonymous(old) == _anonymous(new)


def _anonymous(robot: Robot) -> Robot:
    return msgspec.structs.replace(robot, name=None, instance=None, place=None, position=None)


def check_session(seat: Seat | None, others: tuple[Seat, ...], session: str | None, where: str) -> Fault | None:
    """Return what is wrong with the session a message shows, or None.

    Args:
        seat: Whose message it must be, or None when there is no such seat.
        others: All seats of the agent.
        session: What the message shows; without one it is whoever writes the key, but for a real chair.
        where: The message's class.
    """
    if seat is None:
        if not others:
            return Fault("not-joined", f"{where}: expected an agent that has joined, got one that has not", where)
        return Fault("role", f"{where}: not for the role {others[0].role}", where)
    if session is None:
        if seat.real:
            return Fault(
                "session", f"{where}.Session: expected one, as the robot is real; got none", f"{where}.Session"
            )
        return None
    if session == seat.session:
        return None
    if any(other.session == session for other in others):
        return Fault("role", f"{where}: not for the role this session has", where)
    return Fault("session", f"{where}.Session: expected the session of the last join, got another", f"{where}.Session")
