from __future__ import annotations

from intellwheels_schemas.messages import Position
from tests.server.stage import Stage


def test_an_agent_that_joins_where_it_cannot_turn_is_in_the_log() -> None:
    stage = Stage()
    stage.join_two(position=Position(x=0.7, y=4.6, heading=0.0))
    assert [line for line in stage.notes if line.startswith("narrow ")] == [
        "narrow agent=chair2 why='it needs 0.905 m to turn on the spot, got 0.700 m to Wall[0]'"
    ]
