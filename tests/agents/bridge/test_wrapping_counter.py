from __future__ import annotations

import random

import pytest

from intellwheels_agents.bridge.wrapping_counter import (
    MAX_SIGNED,
    MAX_UNSIGNED,
    MIN_SIGNED,
    WrappingCounter,
    to_signed,
    to_unsigned,
)


def test_an_unsigned_counter_goes_on_over_its_wrap() -> None:
    counter = WrappingCounter()
    values = [MAX_UNSIGNED - 1, MAX_UNSIGNED, 0, 3]
    assert [counter.extend(value) for value in values] == [2**32 - 2, 2**32 - 1, 2**32, 2**32 + 3]


@pytest.mark.parametrize("direction", [1, -1])
def test_a_signed_counter_goes_on_over_its_wrap_in_both_directions(direction: int) -> None:
    counter = WrappingCounter()
    edge = MAX_SIGNED if direction > 0 else MIN_SIGNED
    other = MIN_SIGNED if direction > 0 else MAX_SIGNED
    first = counter.extend(edge - direction)
    assert [counter.extend(value) - first for value in (edge, other, other + 5 * direction, edge)] == [
        direction, 2 * direction, 7 * direction, direction,
    ]  # fmt: skip


def test_any_walk_is_followed_whatever_the_width_shows() -> None:
    rng, count = random.Random(3), 2**31 - 5
    for show in (to_signed, to_unsigned):
        counter, total = WrappingCounter(), count
        offset = total - counter.extend(show(total))
        for _ in range(500):
            total += rng.randrange(-(2**31) + 1, 2**31)
            assert counter.extend(show(total)) + offset == total


def test_a_reset_counter_starts_at_the_next_value() -> None:
    counter = WrappingCounter()
    counter.extend(MAX_UNSIGNED)
    counter.reset()
    assert counter.extend(7) == 7


def test_a_value_before_the_last_one_is_behind() -> None:
    counter = WrappingCounter()
    assert not counter.is_behind(0)
    counter.extend(MAX_UNSIGNED)
    assert counter.is_behind(MAX_UNSIGNED - 1)
    assert not counter.is_behind(5)
