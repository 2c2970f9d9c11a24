"""The best that a body can do alone in a sub-step, with all others where they are."""

from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.geometry import arc
from intellwheels_server.world.kernels.penetration import (
    OF_ANCHORED,
    SPOT_C,
    SPOT_H,
    SPOT_S,
    SPOT_X,
    SPOT_Y,
    copy_spot,
    set_spot,
    slide,
)

# Bisections that find the largest allowed share of a motion.
_HALVINGS = 12


@njit(cache=True, error_model="numpy")
def best_alone(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats, ref: Floats,
    i: int, proposal: Floats, travel: float, turn: float, most: float, result: Floats,
) -> tuple[bool, float, float]:  # fmt: skip
    """Find the best pose of body i in this sub-step with all others at `ref`, and put it in `result`.

    It tries, in this order: its proposal; its proposal moved out along the normals; its travel without the turn, moved
    out; its turn without the travel; the largest share of its arc.

    Args:
        parts: As in `penetration`, as the next seven.
        pieces: As in `penetration`.
        links: As in `penetration`.
        edges: As in `penetration`.
        index: As in `penetration`.
        around: As in `penetration`.
        old: As in `penetration`.
        ref: As in `penetration`.
        i: The body.
        proposal: Spots proposed.
        travel: Of the sub-step, m.
        turn: Of the sub-step, rad.
        most: m of the sub-step, the farthest it may be moved out.
        result: Spots, out.

    Returns:
        Whether the result equals its proposal to the bit; forward travel, m, and turn, rad, achieved.
    """
    copy_spot(result, old, i)
    low, high = 0.0, 1.0
    for attempt in range(4 + _HALVINGS):
        share, d, a, allowed = 1.0, travel, turn, 0.0
        if attempt == 1:
            allowed = most
        elif attempt == 2:
            a, allowed = 0.0, abs(travel)
        elif attempt == 3:
            d = 0.0
        elif attempt > 3:
            share = 0.5 * (low + high)
            d, a = share * travel, share * turn
        # A body on a hinge does not slide. Straight on without travel, and a turn without turn, are no motion.
        if 0 < attempt <= 3 and (index[i, OF_ANCHORED] != 0 or (d == 0.0 and a == 0.0)):
            continue
        if attempt == 0:
            x, y, h = proposal[i, SPOT_X], proposal[i, SPOT_Y], proposal[i, SPOT_H]
            c, s = proposal[i, SPOT_C], proposal[i, SPOT_S]
        else:
            x, y, h, c, s = arc(old[i, SPOT_X], old[i, SPOT_Y], old[i, SPOT_H], d, a)
        found, px, py = slide(parts, pieces, links, edges, index, around, old, ref, i, x, y, c, s, allowed)
        if found:
            low = share
            set_spot(result, i, px, py, h, c, s)
            if attempt <= 3:
                return attempt == 0, d + ((px - x) * c + (py - y) * s), a
        elif attempt > 3:
            high = share
    return False, low * travel, low * turn
