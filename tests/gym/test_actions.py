"""Actions become motor powers, and what is no action gets a clear error."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from intellwheels_gym.actions import ActionSet
from intellwheels_maps import robot
from tests.every_case import every_case

CHAIR = robot("rear-wheel")


def test_velocity_is_a_share_of_what_the_wheels_can_do() -> None:
    actions = ActionSet("velocity", CHAIR)
    assert actions.limits() == pytest.approx((1.0, 2.0 / 0.54))
    assert actions.powers([0.5, 0.0]) == (0.5, 0.5)
    assert actions.powers([0.0, 1.0]) == pytest.approx((-1.0, 1.0))
    # Both at once are more than a wheel can do: scaled down, the curvature stays.
    assert actions.powers([1.0, 1.0]) == pytest.approx((0.0, 1.0))
    assert actions.space().contains(np.array([1.0, -1.0], dtype=np.float32))


def test_powers_are_taken_as_they_are_up_to_rounding() -> None:
    assert ActionSet("powers", CHAIR).powers(np.array([-0.25, 1.0 + 1e-7])) == (-0.25, 1.0)


def test_words_drive_and_turn_on_the_spot() -> None:
    actions = ActionSet("words", CHAIR)
    assert [actions.powers(word) for word in (0, np.int64(1), 2)] == [(0.5, 0.5), (-0.5, 0.5), (0.5, -0.5)]
    assert actions.space().contains(np.int64(2))


@every_case(
    ("kind", "action", "text"),
    [
        ("velocity", [np.nan, 0.0], r"expected v in \[-1, 1\], got nan"),
        ("velocity", [0.0, np.inf], r"expected omega in \[-1, 1\], got inf"),
        ("powers", [0.0, 1.5], r"expected right in \[-1, 1\], got 1.5"),
        ("powers", [0.0], r"expected two numbers, got shape \(1,\)"),
        ("powers", [[0.0, 0.0]], r"expected two numbers, got shape \(1, 2\)"),
        ("powers", "fast", "expected two numbers, got 'fast'"),
        ("powers", None, "expected two numbers, got"),
        ("powers", [0.0, [1.0, 2.0]], "expected two numbers, got"),
        ("words", 3, "expected one of 0 forward, 1 left, 2 right, got 3"),
        ("words", -1, "expected one of 0 forward"),
        ("words", 1.0, "expected one of 0 forward"),
        ("words", True, "expected one of 0 forward"),
        ("words", "left", "expected one of 0 forward, 1 left, 2 right, got 'left'"),
        ("words", [0, 1], "expected one of 0 forward"),
    ],
)
def test_what_is_no_action_is_refused(kind: Any, action: Any, text: str) -> None:
    with pytest.raises(ValueError, match=f"action: {text}"):
        ActionSet(kind, CHAIR).powers(action)


def test_kind_and_robot_are_checked() -> None:
    with pytest.raises(ValueError, match="expected one of velocity, powers, words, got 'wheels'"):
        ActionSet("wheels", CHAIR)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="expected motors"):
        ActionSet("powers", robot("crate"))
