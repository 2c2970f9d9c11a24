"""The crews: agents of one process that share a key for actions and one for measures. Pure.

A crew is there while it has members. It acts for them only, and it belongs to one instance of a program at a time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from intellwheels_schemas.codec import encode
from intellwheels_schemas.crew_messages import for_crew
from intellwheels_server.service.roster import Member
from intellwheels_server.world import State, measures
from intellwheels_server.world.measures_writer import MeasuresWriter


class Crew:
    """A crew.

    Attributes:
        name: Its name.
        instance: The process that acts for it.
        encoding: How it gets its measures.
        members: The agents that joined with it, by name.
    """

    def __init__(self, name: str, reader: Member) -> None:
        """Begin with one agent and no members yet."""
        self.name, self.instance, self.encoding = name, reader.instance, reader.encoding
        self.members: dict[str, Member] = {}
        self._names: tuple[str, ...] | None = None
        self._sessions: dict[str, str] | None = None
        self._writer = MeasuresWriter(self.encoding, named=True)

    def add(self, agent: str, reader: Member) -> None:
        """Note who acts for an agent; the crew is that process's from now on."""
        self.instance = reader.instance
        if self.encoding is not reader.encoding:
            self.encoding = reader.encoding
            self._writer = MeasuresWriter(self.encoding, named=True)
        self.members[agent] = reader
        self._names = self._sessions = None

    def remove(self, agent: str) -> None:
        """Forget an agent."""
        del self.members[agent]
        self._names = self._sessions = None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its agents, the same object until one comes or goes."""
        if self._names is None:
            self._names = tuple(self.members)
        return self._names

    @property
    def sessions(self) -> Mapping[str, str]:
        """The session of each of its agents."""
        if self._sessions is None:
            self._sessions = {agent: member.session for agent, member in self.members.items()}
        return self._sessions

    def write(self, state: State, agents: Sequence[str]) -> list[bytes]:
        """Return the encoded measures of some of its agents, as elements of `CrewMeasures`."""
        if agents is self._names:
            return self._writer.write(state, agents)
        # The writer is prepared for all of them. Some are wanted seldom: when they join, and when they did not answer.
        encoding = self.encoding
        return [for_crew(encode(measures(state, agent), encoding), agent, encoding) for agent in agents]

    @property
    def is_present(self) -> bool:
        """Whether the token of a member of its instance is there."""
        return any(member.absent_since is None for member in self.members.values() if member.instance == self.instance)


class Crews:
    """All crews.

    Attributes:
        named: The crews by their names.
    """

    def __init__(self) -> None:
        self.named: dict[str, Crew] = {}
        self._crew_of: dict[str, Crew] = {}

    def of(self, agent: str) -> Crew | None:
        """Return the crew of an agent, or None."""
        return self._crew_of.get(agent)

    def place(self, agent: str, reader: Member | None) -> str | None:
        """Note who gets the measures of an agent, if anybody; return the name of the crew that ends by that, or None.

        Args:
            agent: The agent.
            reader: Its mind or, without one, its body.
        """
        crew = self._crew_of.get(agent)
        wanted = reader.crew if reader is not None else ""
        ended = None
        if crew is not None and crew.name != wanted:
            del self._crew_of[agent]
            crew.remove(agent)
            if not crew.members:
                del self.named[crew.name]
                ended = crew.name
        if reader is not None and wanted:
            crew = self.named.get(wanted)
            if crew is None or crew.members.get(agent) is not reader:
                crew = crew or self.named.setdefault(wanted, Crew(wanted, reader))
                crew.add(agent, reader)
            self._crew_of[agent] = crew
        return ended
