"""The agents that have joined, and what the service keeps for each of them."""

from __future__ import annotations

from dataclasses import dataclass

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import CrewJoin, Robot, Role
from intellwheels_server.service.arrival import Query
from intellwheels_server.service.barrier import Answer
from intellwheels_server.service.crews import Crews
from intellwheels_server.service.lease import Leases
from intellwheels_server.service.roster import Roster


@dataclass(slots=True)
class WaitingJoin:
    """A join whose liveliness token has not arrived yet; it is refused after `until`."""

    query: Query
    robot: Robot
    encoding: Encoding
    until: float


@dataclass(slots=True, eq=False)
class WaitingCrew:
    """A join of a crew of which tokens have not arrived yet; at `until` it is answered without them."""

    query: Query
    join: CrewJoin
    encoding: Encoding
    until: float
    missing: set[tuple[str, Role, str]]


@dataclass(slots=True)
class BridgeStatus:
    """The reports of a real body.

    Attributes:
        reported_at: When its last pose arrived; minus infinity after a missed one in lockstep.
        stale: Whether the world got the verdict that its pose is old.
        halted: Whether the world got the verdict that its motors get 0.
    """

    reported_at: float
    stale: bool = False
    halted: bool = False


class ConnectedAgents:
    """The agents of the service.

    Attributes:
        roster: The members: which process has which role.
        leases: Which users may steer which body.
        bridges: The reports of each real body.
        encodings: How each agent gets its measures; `set_encoding` changes it.
        crews: The crews, and the agents in each.
        waiting_joins: Joins that wait for their token, the oldest first.
        waiting_crews: Joins of crews that wait for tokens, the oldest first.
        deleted: The session of each agent whose body an operator deleted, until the agent joins again.
    """

    def __init__(self) -> None:
        self.roster = Roster()
        self.leases = Leases()
        self.bridges: dict[str, BridgeStatus] = {}
        self.encodings: dict[str, Encoding] = {}
        self._by_encoding: dict[Encoding, tuple[str, ...]] | None = None
        self.crews = Crews()
        self.waiting_joins: list[WaitingJoin] = []
        self.waiting_crews: list[WaitingCrew] = []
        self.deleted: dict[str, str] = {}

    def set_encoding(self, agent: str, encoding: Encoding | None) -> None:
        """Note how an agent gets its measures; None if it gets none."""
        if encoding is None:
            self.encodings.pop(agent, None)
        else:
            self.encodings[agent] = encoding
        self._by_encoding = None

    def by_encoding(self) -> dict[Encoding, tuple[str, ...]]:
        """Return the agents that get measures in each encoding, the same objects until one comes or goes."""
        if self._by_encoding is None:
            found: dict[Encoding, list[str]] = {}
            for agent, encoding in self.encodings.items():
                found.setdefault(encoding, []).append(agent)
            self._by_encoding = {encoding: tuple(agents) for encoding, agents in found.items()}
        return self._by_encoding

    def count_silence_from(self, now: float) -> None:
        """Forget the silence of real bodies while no tick was made: they report only when they are asked.

        A body that is stale already stays so until it reports.
        """
        for bridge in self.bridges.values():
            if not bridge.stale:
                bridge.reported_at = max(bridge.reported_at, now)

    def expected_answers(self) -> frozenset[Answer]:
        """Return what lockstep expects of all members at each tick."""
        return frozenset(answer for member in self.roster.all_members() for answer in member.answers())
