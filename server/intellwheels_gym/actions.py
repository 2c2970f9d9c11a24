"""What a learner may do: a speed and a turn rate, the powers of its motors, or one of three words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

import numpy as np
from gymnasium import spaces

from intellwheels_agents.differential_drive import powers
from intellwheels_schemas.messages import Robot

ActionKind: TypeAlias = Literal["velocity", "powers", "words"]
KINDS: Final = ("velocity", "powers", "words")
WORDS: Final = ("forward", "left", "right")
"""The words, in the order of their numbers."""
WORD_SHARE: Final = 0.5
"""Share of the top speed that a word drives with. `left` and `right` turn on the spot."""
ROUNDING: Final = 1e-6
"""How far a number may exceed its limit: float32 has about seven digits."""


@dataclass(frozen=True)
class ActionSet:
    """The actions of a robot.

    Attributes:
        kind: `velocity` is float32 (v, omega): speed, forward positive, and turn rate, anticlockwise positive. Each is
            in [-1, 1], a share of the largest that the wheels can do (`limits`). If both together are more than the
            wheels can do, both are scaled down. `powers` is float32 (left, right), each in [-1, 1]. `words` is
            0 forward, 1 left, 2 right.
        robot: The body.
    """

    kind: ActionKind
    robot: Robot

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"action: expected one of {', '.join(KINDS)}, got {self.kind!r}")
        if self.robot.top_speed <= 0.0:
            raise ValueError("robot: expected motors (TopSpeed above 0), got none")

    def space(self) -> spaces.Space[Any]:
        """Return a new space of these actions."""
        if self.kind == "words":
            return spaces.Discrete(len(WORDS))
        return spaces.Box(-1.0, 1.0, (2,), dtype=np.float32)

    def limits(self) -> tuple[float, float]:
        """Return the speed in m/s and the turn rate in rad/s that a `velocity` of 1 stands for."""
        return self.robot.top_speed, 2.0 * self.robot.top_speed / self.robot.track

    def powers(self, action: Any) -> tuple[float, float]:
        """Return the left and right motor power of an action, each in [-1, 1].

        Raises:
            ValueError: It is none of these actions; the text says what was expected and what came.
        """
        if self.kind == "words":
            return self._word(action)
        try:
            numbers = np.asarray(action, dtype=np.float64)
        except (TypeError, ValueError):
            raise ValueError(f"action: expected two numbers, got {action!r}") from None
        if numbers.shape != (2,):
            raise ValueError(f"action: expected two numbers, got shape {numbers.shape}")
        names = ("v", "omega") if self.kind == "velocity" else ("left", "right")
        first, second = (_checked(name, number) for name, number in zip(names, numbers.tolist(), strict=True))
        if self.kind == "powers":
            return first, second
        speed, turn_rate = self.limits()
        return powers(self.robot, first * speed, second * turn_rate)

    def _word(self, action: Any) -> tuple[float, float]:
        listed = ", ".join(f"{i} {word}" for i, word in enumerate(WORDS))
        number = np.asarray(action)
        if number.shape != () or number.dtype.kind not in "iu" or not 0 <= int(number) < len(WORDS):
            raise ValueError(f"action: expected one of {listed}, got {action!r}")
        side = (0.0, -1.0, 1.0)[int(number)]
        return (WORD_SHARE, WORD_SHARE) if side == 0.0 else (WORD_SHARE * side, -WORD_SHARE * side)


def _checked(name: str, number: float) -> float:
    """Return a number in [-1, 1]."""
    if not abs(number) <= 1.0 + ROUNDING:
        raise ValueError(f"action: expected {name} in [-1, 1], got {number:g}")
    return min(max(number, -1.0), 1.0)
