"""What the sub-steps of contact work on: the motions wanted, the spots of the bodies, and what is noted of each body.

`contact` makes these once a tick, and `contact_steps` unpacks them.
"""

from typing import NamedTuple

from intellwheels_server.world.kernels.arrays import Floats, Ints

# Rows of a status, int64[5, n].
FREE = 0
"""1 while the body was granted every proposed motion so far this tick."""
STAYS = 1
"""1 if its proposal is not granted in this sub-step, or if it does not move at all: the body stays."""
IN_CONFLICT = 2
"""1 if its proposal was found to conflict in this sub-step."""
GOT_PROPOSAL = 3
"""1 if it was granted its proposal after all, once the poses of the others were known."""
GOES_BACK = 4
"""1 if it returns to its pose at the start of the sub-step, because its result conflicts with that of another."""
STATUS_ROWS = 5


class Motions(NamedTuple):
    """The motions that the bodies want in the tick.

    Attributes:
        pose: float64[3, n], at its start.
        twist: float64[2, n], travel, m, and turn, rad.
        motion: float64[n], bound m of the motion of any point of the body, m.
    """

    pose: Floats
    twist: Floats
    motion: Floats


class Spots(NamedTuple):
    """Poses of bodies in a sub-step, spot blocks of `penetration`.

    Attributes:
        old: float64[n, 7], at its start.
        ref: float64[n, 7], as the others see them: the proposal, or `old` if the body stays.
        proposal: float64[n, 5], the proposals.
        result: float64[n, 5], the best poses that the bodies that stay find.
    """

    old: Floats
    ref: Floats
    proposal: Floats
    result: Floats


class Work(NamedTuple):
    """Notes of a sub-step on each body.

    Attributes:
        status: int64[STATUS_ROWS, n], rows `FREE` to `GOES_BACK`.
        gain: float64[2, n], forward travel, m, and turn, rad, of the result.
        queue: int64[n], the bodies that stay, in the order in which they were found.
    """

    status: Ints
    gain: Floats
    queue: Ints
