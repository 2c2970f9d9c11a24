"""Input states from held keys, by name, and from axes and buttons, by number. Knows no device.

up, w, i / down, s, k       forward / back
left, a, j / right, d, l    turn
q, u / e, o                 forward and left / forward and right
shift                       full power; without it a key gives `GENTLE` of it
0 to 9                      buttons
space                       neutral, even if other keys are held
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Final

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState

DEAD_ZONE: Final = 0.12
"""Share of an axis that counts as centred: worn sticks rest up to 0.1 off the centre."""
GENTLE: Final = 0.6
"""Share of full power that a key gives without shift: as on the page."""
FORWARD_KEYS: Final = ("up", "w", "i", "q", "u", "e", "o"), ("down", "s", "k")
TURN_KEYS: Final = ("left", "a", "j", "q", "u"), ("right", "d", "l", "e", "o")


def from_keys(held: Collection[str], forward: float, turn: float) -> InputState:
    """Return the state of the held keys.

    Args:
        held: Their names, as above; others are ignored.
        forward: Share of full forward for a key with shift, in [0, 1].
        turn: The same share of full turn.
    """
    if "space" in held:
        return NEUTRAL
    factor = 1.0 if "shift" in held else GENTLE
    return InputState(
        factor * forward * _axis(held, *FORWARD_KEYS),
        factor * turn * _axis(held, *TURN_KEYS),
        tuple(sorted(int(name) for name in held if len(name) == 1 and name.isascii() and name.isdigit())),
    )


class DrivingKeys:
    """The keys that drive, as a `KeyReader`.

    Args:
        forward: Share of full forward for a key with shift, in [0, 1].
        turn: The same share of full turn.
    """

    keys = frozenset({"space"}.union(*FORWARD_KEYS, *TURN_KEYS))
    help = (
        "arrows, W A S D or I J K L drive, Q E or U O for bends",
        "shift for full power, space stops, 0-9 are buttons, escape ends",
    )
    caption = ""

    def __init__(self, forward: float, turn: float) -> None:
        self._shares = forward, turn

    def read(self, held: Collection[str], now: float) -> InputState:  # noqa: ARG002 - as `KeyReader` has it
        """Return the state of the held keys."""
        return from_keys(held, *self._shares)

    def lost(self) -> None:
        """Do nothing: without a held key nothing drives."""


def _axis(held: Collection[str], positive: tuple[str, ...], negative: tuple[str, ...]) -> int:
    def is_held(names: tuple[str, ...]) -> bool:
        return any(name in held for name in names)

    return is_held(positive) - is_held(negative)


def from_stick(axis: Callable[[int], float], buttons: Collection[int], forward: float, turn: float) -> InputState:
    """Return the state of a gamepad's first stick and buttons.

    Args:
        axis: Returns the value in [-1, 1] of an axis: 0 is positive to the right, 1 positive towards the user.
        buttons: The numbers of the pressed ones.
        forward: Share of full forward at full deflection, in [0, 1].
        turn: Share of full turn, in [0, 1].
    """
    return InputState(
        -forward * without_dead_zone(axis(1)),
        -turn * without_dead_zone(axis(0)),
        tuple(sorted(b for b in buttons if 0 <= b <= 63)),
    )


def without_dead_zone(value: float, dead_zone: float = DEAD_ZONE) -> float:
    """Return an axis value without its dead zone, rounded so that a trembling stick does not change the state."""
    size = min(abs(value), 1.0)
    if size <= dead_zone:
        return 0.0
    share = round((size - dead_zone) / (1.0 - dead_zone), 2)
    return share if value > 0.0 else -share
