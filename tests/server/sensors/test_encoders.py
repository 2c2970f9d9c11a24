"""Wheel encoders: whole ticks, forward positive, from joining on."""

from __future__ import annotations

import math
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
