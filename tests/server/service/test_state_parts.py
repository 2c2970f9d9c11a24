from __future__ import annotations

from itertools import accumulate

import pytest

from intellwheels_schemas.codec import decode, encode
from intellwheels_schemas.messages import Entity, WorldState
from intellwheels_server.service.state_parts import PART_BYTES, split_state, split_written
from intellwheels_server.world.state_writer import WrittenState

RUN = "0" * 16


def entities(count: int) -> list[Entity]:
    return [
        Entity(name=f"a{k}", x=1.5 * k, y=0.123456, heading=3.0, mode="autonomous" * (k % 5 + 1)) for k in range(count)
    ]


@pytest.mark.parametrize("count", [0, 1, 100, 700, 1000, 5000])
def test_parts_hold_all_entities_in_order_and_none_is_too_long(count: int) -> None:
    everybody = entities(count)
    parts = split_state(RUN, 3, 0.15, everybody)
    assert [entity for part in parts for entity in part.entity] == everybody
    assert [part.part for part in parts] == list(range(len(parts)))
    assert all(part.parts == len(parts) for part in parts)
    assert all(len(encode(part)) <= PART_BYTES for part in parts)


def test_empty_world_is_one_part() -> None:
    assert len(split_state(RUN, 0, 0.0, [])) == 1


def test_there_are_at_most_twice_as_many_parts_as_needed() -> None:
    everybody = entities(5000)
    size = sum(len(encode(part)) for part in split_state(RUN, 3, 0.15, everybody))
    assert len(split_state(RUN, 3, 0.15, everybody)) <= 2 * size / PART_BYTES


@pytest.mark.parametrize("count", [0, 1, 100, 700, 5000])
def test_parts_of_bytes_hold_all_entities_in_order_and_none_is_too_long(count: int) -> None:
    everybody = entities(count)
    each = [encode(entity) + b"," for entity in everybody]
    ends = list(accumulate(map(len, each), initial=0))
    data = split_written(RUN, 3, 0.15, WrittenState(b"".join(each), ends))
    parts = [decode(WorldState, part) for part in data]
    assert [entity for part in parts for entity in part.entity] == everybody
    assert [part.part for part in parts] == list(range(len(parts)))
    assert all(part.parts == len(parts) for part in parts)
    assert max(map(len, data)) <= PART_BYTES
    assert len(data) <= 2 * sum(map(len, data)) / PART_BYTES + 1
    assert [encode(part) for part in parts] == data
