"""The crews: agents of one process that share a key for actions and one for measures. Pure.

A crew is there while it has members. It acts for them only, and it belongs to one instance of a program at a time.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from intellwheels_schemas.codec import Encoding
from intellwheels_server.service.roster import Member


@dataclass(slots=True, eq=False)
class Crew:
    """A crew.

    Attributes:
        name: Its name.
        instance: The process that acts for it.
        encoding: How it gets its measures.
        members: The agents that joined with it, by name.
    """

    name: str
    instance: str
    encoding: Encoding
    members: dict[str, Member] = field(default_factory=dict)

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
            del self._crew_of[agent], crew.members[agent]
            if not crew.members:
                del self.named[crew.name]
                ended = crew.name
        if reader is not None and wanted:
            crew = self.named.get(wanted)
            if crew is None or crew.members.get(agent) is not reader:
                crew = crew or self.named.setdefault(wanted, Crew(wanted, reader.instance, reader.encoding))
                crew.instance, crew.encoding = reader.instance, reader.encoding
            crew.members[agent] = reader
            self._crew_of[agent] = crew
        return ended
