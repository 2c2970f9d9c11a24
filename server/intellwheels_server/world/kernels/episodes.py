"""Episodes of contact: which pairs began to touch, and which have parted.

An episode lasts until the pair has not touched for the hold time.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Ints

FIRST_KEY, SECOND_KEY, LAST_TOUCH = 0, 1, 2
"""Columns of episodes, int64[e, 3]: keys of both, the tick of the last touch."""


@njit(cache=True, error_model="numpy")
def _before(a0: int, a1: int, b0: int, b1: int) -> bool:
    return a0 < b0 or (a0 == b0 and a1 < b1)


@njit(cache=True, error_model="numpy")
def merge_episodes(episodes: Ints, pairs: Ints, tick: int, hold: int) -> tuple[Ints, Ints, Ints]:
    """Return the episodes after a tick, and those that began and ended in it.

    Args:
        episodes: int64[e, 3], sorted by (FIRST_KEY, SECOND_KEY), each pair once.
        pairs: int64[p, 3]: keys of both and a number of the caller, sorted by the keys; a pair may
            occur several times.
        tick: This tick.
        hold: Ticks without touch after which an episode is over, >= 1.

    Returns:
        The episodes, sorted; for each pair that began the first of the caller's numbers; and int64[k, 2], the keys of
        the pairs that ended.
    """
    kept = np.empty((episodes.shape[0] + pairs.shape[0], 3), dtype=np.int64)
    began = np.empty(pairs.shape[0], dtype=np.int64)
    ended = np.empty((episodes.shape[0], 2), dtype=np.int64)
    count = starts = ends = 0
    i = j = 0
    while i < episodes.shape[0] or j < pairs.shape[0]:
        old_first = j >= pairs.shape[0] or (
            i < episodes.shape[0] and _before(episodes[i, 0], episodes[i, 1], pairs[j, 0], pairs[j, 1])
        )
        if old_first:  # not touching now
            if tick - episodes[i, LAST_TOUCH] >= hold:
                ended[ends, 0] = episodes[i, FIRST_KEY]
                ended[ends, 1] = episodes[i, SECOND_KEY]
                ends += 1
            else:
                kept[count] = episodes[i]
                count += 1
            i += 1
            continue
        first = pairs[j, 0]
        second = pairs[j, 1]
        if i < episodes.shape[0] and episodes[i, FIRST_KEY] == first and episodes[i, SECOND_KEY] == second:
            i += 1
        else:
            began[starts] = pairs[j, 2]
            starts += 1
        kept[count, FIRST_KEY] = first
        kept[count, SECOND_KEY] = second
        kept[count, LAST_TOUCH] = tick
        count += 1
        while j < pairs.shape[0] and pairs[j, 0] == first and pairs[j, 1] == second:
            j += 1
    return kept[:count].copy(), began[:starts].copy(), ended[:ends].copy()
