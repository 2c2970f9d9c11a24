"""Wheel encoders: whole ticks, forward positive, from joining on."""

from __future__ import annotations

import math
import statistics
from typing import Any

from intellwheels_schemas.codec import decode, encode
from intellwheels_schemas.messages import Encoders, Measures
from intellwheels_server.world import State, measures
from tests.server.worlds import cart, run, world

# 1000 ticks a metre.
_WHEELS: dict[str, Any] = {
    "wheel_diameter": 0.5,
    "encoder_ticks": round(500 * math.pi),
    "encoders": (Encoders(id="w"),),
}
_PER_METRE = round(500 * math.pi) / (0.5 * math.pi)


def _counts(state: State) -> tuple[int, int]:
    sensors = measures(state, "a").sensors
    assert sensors is not None
    return sensors.encoders[0].left, sensors.encoders[0].right


def test_encoders_begin_at_zero_and_count_forward_and_back() -> None:
    state = world({"a": cart(**_WHEELS)})
    assert _counts(state) == (0, 0)
    state, _ = run(state, 20, {"a": (1.0, 1.0)})
    assert _counts(state) == (round(_PER_METRE), round(_PER_METRE))
    state, _ = run(state, 40, {"a": (-1.0, -1.0)})
    assert _counts(state) == (-round(_PER_METRE), -round(_PER_METRE))
    state, _ = run(state, 20, {"a": (1.0, 1.0)})
    assert _counts(state) == (0, 0)


def test_turning_left_rolls_the_left_wheel_back_and_the_right_one_forward() -> None:
    state, _ = run(world({"a": cart(**_WHEELS)}), 10, {"a": (-0.5, 0.5)})
    left, right = _counts(state)
    assert left == -right
    assert right == round(0.25 * _PER_METRE)


def test_counts_stay_within_what_the_wire_can_carry_whatever_the_wheel() -> None:
    for diameter in (1e-9, 1e-300, 5e-324):
        state = world({"a": cart(wheel_diameter=diameter, encoder_ticks=1_000_000, encoders=(Encoders(id="w"),))})
        for power in (-1.0, 1.0):
            state, _ = run(state, 40, {"a": (power, power)})
            told = measures(state, "a")
            assert decode(Measures, encode(told)) == told


def test_wheel_that_is_larger_than_it_should_be_counts_less_for_the_same_way() -> None:
    # The right wheel is larger by 2 %, both motors turn alike: so do the counts, and the chair goes to the left.
    state, _ = run(world({"a": cart(wheel_ratio=1.02, **_WHEELS)}), 100, {"a": (1.0, 1.0)})
    assert _counts(state) == (round(5 * _PER_METRE), round(5 * _PER_METRE))
    assert abs(state.numbers[2, 0] - 5.0 * (2.0 * 0.02 / 2.02) / 0.5) < 1e-12
    state, _ = run(world({"a": cart(wheel_scale=0.9, **_WHEELS)}), 100, {"a": (1.0, 1.0)})
    assert _counts(state) == (round(5 * _PER_METRE), round(5 * _PER_METRE))
    assert abs(state.numbers[0, 0] - 4.5) < 1e-12


def test_track_that_is_wider_turns_less() -> None:
    state, _ = run(world({"a": cart(track_ratio=1.25, **_WHEELS)}), 20, {"a": (-0.25, 0.25)})
    assert abs(state.numbers[2, 0] - 0.5 / (0.5 * 1.25)) < 1e-12
    assert _counts(state)[1] == round(0.25 * _PER_METRE)


def test_drift_has_its_variance_a_metre_and_adds_up_over_ways_back() -> None:
    drifting = {
        **_WHEELS,
        "encoder_ticks": 1_000_000,
        "encoders": tuple(Encoders(id=f"w{k}", drift=1e-4) for k in range(60)),
    }
    state = world({"a": cart(**drifting)})
    found = []
    for _ in range(10):
        before = _all(state)
        for power in (1.0, -1.0):
            state, _ = run(state, 20, {"a": (power, power)})
        found += [(now - then) * 0.5 * math.pi / 1e6 for now, then in zip(_all(state), before, strict=True)]
    # Two metres there and back; four standard errors of 1200 draws.
    assert abs(statistics.pstdev(found) / math.sqrt(1e-4 * 2) - 1.0) < 0.085


def _all(state: State) -> list[int]:
    sensors = measures(state, "a").sensors
    assert sensors is not None
    return [count for one in sensors.encoders for count in (one.left, one.right)]


def test_chair_at_rest_does_not_drift() -> None:
    state = world({"a": cart(**{**_WHEELS, "encoders": (Encoders(id="w", drift=1.0),)})})
    state, _ = run(state, 50)
    assert _counts(state) == (0, 0)
