"""What the sub-steps of contact work on: the motions wanted, the spots of the bodies, and what is noted of each body.

`contact` makes these once a tick, and `contact_steps` unpacks them.
"""

from typing import NamedTuple

from intellwheels_server.world.kernels.arrays import Floats, Ints

# Rows of a status, int64[5, n].
FREE = 0
"""1 while the body was granted every proposed motion so far this tick."""
STAYS = 1
"""1 if its proposal is not granted in this sub-step, or if it does not move at all."""
IN_CONFLICT = 2
"""1 if its proposal was found to conflict in this sub-step."""
GOT_PROPOSAL = 3
"""1 if it was granted its proposal after all, once the others' places were known."""
GOES_BACK = 4
"""1 if it stays where it was in this sub-step, because what it found conflicts with what another found."""
STATUS_ROWS = 5


class Motions(NamedTuple):
    """What the bodies want in the tick.

    Attributes:
        pose: float64[3, n], at its start.
        twist: float64[2, n], travel, m, and turn, rad.
        motion: float64[n], bound m of the motion of any point of the body, m.
    """

    pose: Floats
    twist: Floats
    motion: Floats


class Spots(NamedTuple):
    """Where bodies are in a sub-step, spot blocks of `penetration`.

    Attributes:
        old: float64[n, 7], at its start.
        ref: float64[n, 7], where the others see them: at their proposals, or at `old` if they stay.
        proposal: float64[n, 5], where they want to be.
        result: float64[n, 5], the best that those who stay find alone.
    """

    old: Floats
    ref: Floats
    proposal: Floats
    result: Floats


class Work(NamedTuple):
    """What a sub-step notes of each body.

    Attributes:
        status: int64[STATUS_ROWS, n], rows `FREE` to `GOES_BACK`.
        gain: float64[2, n], forward travel, m, and turn, rad, of the result.
        queue: int64[n], those who stay, in the order found.
    """

    status: Ints
    gain: Floats
    queue: Ints
