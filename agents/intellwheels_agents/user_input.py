"""What a person wants of a chair: a `UserInput` to forward and turn, and on to powers.

The simulator lets a silent user want nothing (dead-man), so what stands in `Measures` is what is wanted now. A voice
recogniser may send a word alone; a word counts only where forward and turn are both 0. A goal outlives the user's
silence, so a mind takes it once: when it is another than before.
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
"""Forward and turn that a word asks for, as signs."""


def wanted(user: UserInput | None, word_share: float) -> tuple[float, float]:
    """Return forward and turn, both in [-1, 1], turn positive to the left.

    Args:
        user: As it stands in `Measures`; None is nobody.
        word_share: How much of full forward or turn a word alone asks for, in [0, 1].
    """
    if user is None:
        return 0.0, 0.0
    if user.forward == 0.0 and user.turn == 0.0 and user.word in WORDS:
        forward, turn = WORDS[user.word]
        return forward * word_share, turn * word_share
    return user.forward, user.turn


def mixed(forward: float, turn: float) -> tuple[float, float]:
    """Return the left and right power of a wish, as the simulator itself obeys one under a lease.

    left = F - T and right = F + T, both divided by max(1, |left|, |right|).
    """
    left, right = forward - turn, forward + turn
    most = max(1.0, abs(left), abs(right))
    return left / most, right / most


def takes_goals(robot: Robot, options: Options) -> Robot:  # noqa: ARG001 - as `Equip` has it
    """Return the robot with goals of its user declared: a page then offers to send it somewhere."""
    return msgspec.structs.replace(robot, user_input=("goal",))


class Goals:
    """What a user says of where to go, as it stands in the measures of one tick after the other."""

    def __init__(self) -> None:
        self._told: Goal | None = None

    def news(self, user: UserInput | None) -> Goal | None:
        """Return a goal that was not told at the tick before, else None."""
        goal = None if user is None else user.goal
        if goal == self._told:
            return None
        self._told = goal
        return goal
