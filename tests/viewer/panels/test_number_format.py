"""Numbers as people read them."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from intellwheels_viewer.panels import number_format
from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.panels import made_up


@pytest.mark.parametrize(
    ("value", "places", "text"),
    [(0.456, 2, "0.46"), (-0.08, 2, "\u22120.08"), (-0.001, 2, "0.00"), (-12.0, 0, "\u221212"), (-0.4, 0, "0")],
)
def test_decimals_have_a_true_minus_and_no_negative_zero(value: float, places: int, text: str) -> None:
    assert number_format.decimal(value, places) == text


def test_factor_has_no_idle_zeros() -> None:
    assert [number_format.factor(value) for value in (1.0, 0.5, 10.0)] == ["1", "0.5", "10"]


def test_angle_is_in_whole_degrees() -> None:
    assert number_format.degrees(-math.pi / 2) == "\u221290"


def test_time_of_a_tick_follows_the_clock() -> None:
    assert number_format.moment(20, made_up.snapshot()) == "1.00"


def test_time_of_a_tick_is_unknown_before_the_first_but_for_the_start() -> None:
    assert [number_format.moment(tick, Snapshot()) for tick in (0, 3)] == ["0.00", "?"]


def test_time_of_a_tick_follows_the_state_while_there_is_no_clock() -> None:
    assert number_format.moment(2, replace(Snapshot(), tick=10, time=1.0)) == "0.20"
