"""Which keys carry the measures of agents, some of which may be in crews, and their measures there. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from intellwheels_schemas.codec import encoding_of
from intellwheels_schemas.crew_messages import split_measures
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Body


def subscriptions(keys: Keys, bodies: Mapping[str, Body], agents: Collection[str], most: int) -> dict[str, str]:
    """Return the key expressions to subscribe to for the measures of agents, by a short name.

    Args:
        keys: The keys of the world.
        bodies: All known bodies. An agent without one is taken to be in no crew.
        agents: The agents.
        most: Above this many agents, all measures are subscribed to at once.
    """
    crews = {agent: body.robot.crew for agent in agents if (body := bodies.get(agent)) is not None and body.robot.crew}
    if len(agents) > most:
        return {"*": f"{keys.prefix}out/*/measures"} | ({"crew/*": keys.every_crew_measures} if crews else {})
    found = {agent: keys.measures(agent) for agent in agents if agent not in crews}
    return found | {f"crew/{crew}": keys.crew_measures(crew) for crew in crews.values()}


def measures_in(data: bytes, encoding: str, agents: Collection[str]) -> Iterator[tuple[str, bytes]]:
    """Yield the names of some agents and their `AgentMeasures`, still encoded, of those in the measures of a crew."""
    try:
        part = split_measures(data, encoding_of(encoding, data))
    except WireError:
        return  # any peer can publish in a world; what cannot be decoded is ignored
    for agent, own in part.measures.items():
        if agent in agents:
            yield agent, own
