"""Takes the messages of crews apart, so that a recording has those of each agent as if it were in none. Pure."""

from __future__ import annotations

from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.crew_messages import alone
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import CrewActions, CrewMeasures, Measures


def each_alone(keys: Keys, key: str, data: bytes, encoding: str) -> list[tuple[str, bytes]]:
    """Return the messages of the agents in a message of a crew, each with its own key; else the message itself."""
    try:
        if keys.parse_crew_measures(key) is not None:
            found = encoding_of(encoding, data)
            measures = decode(CrewMeasures, data, found, strict=False).measures
            names = Measures.__struct_fields__
            return [
                (keys.measures(one.agent), encode(Measures(**{name: getattr(one, name) for name in names}), found))
                for one in measures
            ]
        if keys.parse_crew(key) is not None:
            found = encoding_of(encoding, data)
            actions = decode(CrewActions, data, found, strict=False).actions
            return [(keys.actions(one.agent), encode(alone(one), found)) for one in actions]
    except WireError:
        return []  # any peer can publish in a world; what cannot be decoded is ignored
    return [(key, data)]
