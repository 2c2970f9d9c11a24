from __future__ import annotations

import pytest

from intellwheels_agents.record_gateway.crew_records import each_alone
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import (
    Actions,
    AgentActions,
    AgentMeasures,
    CrewActions,
    CrewMeasures,
    Measures,
)

KEYS, RUN, SESSION = Keys("main"), "a" * 16, "b" * 16


@pytest.mark.parametrize("encoding", list(Encoding))
def test_messages_of_a_crew_become_those_of_its_agents(encoding: Encoding) -> None:
    of_crew = CrewMeasures(
        crew="c", measures=tuple(AgentMeasures(agent=name, run=RUN, tick=1, time=0.05) for name in ("a1", "a2"))
    )
    found = each_alone(KEYS, KEYS.crew_measures("c"), encode(of_crew, encoding), encoding.value)
    assert [key for key, _ in found] == [KEYS.measures("a1"), KEYS.measures("a2")]
    assert decode(Measures, found[0][1], encoding) == Measures(run=RUN, tick=1, time=0.05)
    acts = CrewActions(crew="c", actions=(AgentActions(agent="a1", session=SESSION, left_motor=0.5),))
    ((key, data),) = each_alone(KEYS, KEYS.crew_actions("c"), encode(acts, encoding), encoding.value)
    assert (key, decode(Actions, data, encoding)) == (KEYS.actions("a1"), Actions(session=SESSION, left_motor=0.5))


def test_other_messages_stay_as_they_are_and_wrong_ones_are_ignored() -> None:
    assert each_alone(KEYS, KEYS.clock, b"?", "") == [(KEYS.clock, b"?")]
    assert each_alone(KEYS, KEYS.crew_measures("c"), b"?", "") == []
    assert each_alone(KEYS, KEYS.crew_actions("c"), b"{}", "") == []
