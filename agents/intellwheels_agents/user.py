"""What a person wants of a chair: a `UserInput` to forward and turn, and on to powers.

The simulator lets a silent user want nothing (dead-man), so what stands in `Measures` is what is wanted now. A voice
recogniser may send a word alone; a word counts only where forward and turn are both 0.
"""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.messages import UserInput

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
