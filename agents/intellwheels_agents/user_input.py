"""Converts a `UserInput` to forward and turn, and these to motor powers.

The simulator clears the input of a silent user (dead-man), so `Measures` hold what the user wants now. A voice
recogniser may send a word alone; a word counts only if forward and turn are both 0. A goal is not cleared by silence,
so a mind acts on it once, when it changes.
"""

from __future__ import annotations

from typing import Final

import msgspec

from intellwheels_agents.options import Options
from intellwheels_schemas.messages import Goal, Robot, UserInput

WORDS: Final[dict[str, tuple[float, float]]] = {
    "forward": (1.0, 0.0),
    "back": (-1.0, 0.0),
    "left": (0.0, 1.0),
    "right": (0.0, -1.0),
    "stop": (0.0, 0.0),
}
"""The signs of forward and turn for each word."""


def wanted(user: UserInput | None, word_share: float) -> tuple[float, float]:
    """Return forward and turn, both in [-1, 1], turn positive to the left.

    Args:
        user: The user input of `Measures`; None without a user.
        word_share: The deflection that a word counts as, in [0, 1].
    """
    if user is None:
        return 0.0, 0.0
    if user.forward == 0.0 and user.turn == 0.0 and user.word in WORDS:
        forward, turn = WORDS[user.word]
        return forward * word_share, turn * word_share
    return user.forward, user.turn


def mixed(forward: float, turn: float) -> tuple[float, float]:
    """Return the left and right motor power, in [-1, 1], for forward and turn.

    left = F - T and right = F + T, both divided by max(1, |left|, |right|). The simulator mixes the input of a user who
    holds the chair's lease in the same way.
    """
    left, right = forward - turn, forward + turn
    largest = max(1.0, abs(left), abs(right))
    return left / largest, right / largest


def unmixed(left: float, right: float) -> tuple[float, float]:
    """Return forward and turn, in [-1, 1], for motor powers: the inverse of `mixed`."""
    return (left + right) / 2.0, (right - left) / 2.0


def takes_drive(robot: Robot, options: Options) -> Robot:  # noqa: ARG001 - the signature of `Equip`
    """Return the robot with driving and words declared as user input."""
    return msgspec.structs.replace(robot, user_input=("drive", "words"))


def takes_goals(robot: Robot, options: Options) -> Robot:  # noqa: ARG001 - the signature of `Equip`
    """Return the robot with goals declared as user input, so that the viewer offers to set one."""
    return msgspec.structs.replace(robot, user_input=("goal",))


class Goals:
    """Notices when the goal in the user input changes from one tick to the next."""

    def __init__(self) -> None:
        self._last: Goal | None = None

    def changed(self, user: UserInput | None) -> Goal | None:
        """Return the goal if it differs from the one at the last call, else None."""
        goal = None if user is None else user.goal
        if goal == self._last:
            return None
        self._last = goal
        return goal
