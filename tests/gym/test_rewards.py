"""Rewards and ends have names, and functions of your own replace them."""

from __future__ import annotations

from typing import Any

import pytest

from intellwheels_gym.rewards import DEFAULT_ENDS, DEFAULT_REWARD, ENDS, REWARDS, End, Step, ends_of, reward_of

STEP = Step(
    before=2.0, after=1.5, reached=False, contacts=1, seconds=0.1, time=3.0, limit=3.0, powers=(0.5, 0.5)
)  # fmt: skip


def test_each_reward_has_its_worth() -> None:
    assert {name: one(STEP) for name, one in REWARDS.items()} == {
        "progress": 0.5, "reached": 0.0, "contact": -1.0, "time": -0.1,
    }  # fmt: skip


def test_reward_is_a_name_weights_or_a_function() -> None:
    assert reward_of("progress")(STEP) == 0.5
    assert reward_of({"progress": 2.0, "contact": 3})(STEP) == -2.0
    assert reward_of(lambda step: step.powers[0])(STEP) == 0.5
    assert reward_of(DEFAULT_REWARD)(STEP) == pytest.approx(0.5 - 10.0 - 0.01)


def test_ends_are_names_or_ends() -> None:
    mine = End("half", lambda step: step.after < 1.0)
    assert [end.name for end in ends_of(["reached", mine])] == ["reached", "half"]
    assert [end.met(STEP) for end in ends_of(DEFAULT_ENDS)] == [False, True, True]
    assert [name for name, end in ENDS.items() if end.truncates] == ["timeout"]


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("progres", "expected one of progress, .* got 'progres'; did you mean 'progress'"),
        ({"speed": 1.0}, "expected one of progress, .* got 'speed'"),
        ({"time": float("nan")}, "expected a finite number as the weight of 'time', got nan"),
        ({"time": "1"}, "expected a finite number as the weight of 'time', got '1'"),
        (3.0, "expected a name, a function or weights by name, got 3.0"),
    ],
)
def test_what_is_no_reward_is_refused(given: Any, text: str) -> None:
    with pytest.raises((ValueError, TypeError), match=f"reward: {text}"):
        reward_of(given)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("reached", "expected a list of names or ends, got 'reached'"),
        (None, "expected a list of names or ends, got None"),
        (["reach"], "expected one of reached, contact, timeout or an End, got 'reach'"),
        ([3], "expected one of reached, contact, timeout or an End, got 3"),
    ],
)
def test_what_is_no_end_is_refused(given: Any, text: str) -> None:
    with pytest.raises((ValueError, TypeError), match=f"ends: {text}"):
        ends_of(given)
