from __future__ import annotations

from collections.abc import Iterator

import pytest

from intellwheels_maps import turning
from intellwheels_schemas.messages import Map, Position
from tests.server.stage import Stage


def test_an_agent_that_joins_where_it_cannot_turn_is_in_the_log() -> None:
    stage = Stage()
    stage.join_two(position=Position(x=0.7, y=4.6, heading=0.0))
    assert [line for line in stage.notes if line.startswith("narrow ")] == [
        "narrow agent=chair2 why='it needs 0.905 m to turn on the spot, got 0.700 m to Wall[0]'"
    ]


def test_walls_are_cut_once_for_all_that_join(monkeypatch: pytest.MonkeyPatch) -> None:
    cut: list[Map] = []
    solids = turning._solids

    def counted(floor: Map) -> Iterator[turning.Solid]:
        cut.append(floor)
        return solids(floor)

    monkeypatch.setattr(turning, "_solids", counted)
    Stage().join_two()
    assert len(cut) == 1
