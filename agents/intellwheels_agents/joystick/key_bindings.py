"""Wishes from what is held: keys by name, axes and buttons by number. Knows no device.

up, w / down, s       forward / back
left, a / right, d    turn
shift                 half of all that
0 to 9                buttons
space                 nothing, whatever else is held
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Final

from intellwheels_agents.joystick.wish import NOTHING, Wish

DEAD_ZONE: Final = 0.12
"""Share of an axis around its middle that counts as the middle: worn sticks rest up to 0.1 off it."""
FORWARD_KEYS: Final = ("up", "w"), ("down", "s")
TURN_KEYS: Final = ("left", "a"), ("right", "d")


def of_keys(held: Collection[str], forward: float, turn: float) -> Wish:
    """Return what held keys want.

    Args:
        held: Their names, as above; others do not matter.
        forward: Share of full forward that a key asks for, in [0, 1].
        turn: Share of full turn, in [0, 1].
    """
    if "space" in held:
        return NOTHING
    half = 0.5 if "shift" in held else 1.0
    return Wish(
        half * forward * _pair(held, *FORWARD_KEYS),
        half * turn * _pair(held, *TURN_KEYS),
        tuple(sorted(int(name) for name in held if len(name) == 1 and name.isascii() and name.isdigit())),
    )


def _pair(held: Collection[str], more: tuple[str, ...], less: tuple[str, ...]) -> int:
    def is_held(names: tuple[str, ...]) -> bool:
        return any(name in held for name in names)

    return is_held(more) - is_held(less)


def of_stick(axis: Callable[[int], float], buttons: Collection[int], forward: float, turn: float) -> Wish:
    """Return what a gamepad's first stick and buttons want.

    Args:
        axis: An axis' value in [-1, 1] by its number: 0 positive to the right, 1 positive to the user.
        buttons: The numbers of those held.
        forward: Share of full forward that a stick quite ahead asks for, in [0, 1].
        turn: Share of full turn, in [0, 1].
    """
    return Wish(-forward * eased(axis(1)), -turn * eased(axis(0)), tuple(sorted(b for b in buttons if 0 <= b <= 63)))


def eased(value: float) -> float:
    """Return an axis' value with its dead zone taken out, rounded so that a trembling stick is one wish."""
    size = min(abs(value), 1.0)
    if size <= DEAD_ZONE:
        return 0.0
    share = round((size - DEAD_ZONE) / (1.0 - DEAD_ZONE), 2)
    return share if value > 0.0 else -share
