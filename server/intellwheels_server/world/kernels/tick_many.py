"""One step of the bodies of many worlds, in one call: `tick_kernel` for one world after the other.

The worlds share the map and the number of parts of each body. Everything else is stacked: the first axis is the world.
Threads may step different worlds at once, as no world reads another's numbers.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.tick_kernel import tick_all

# Rows of the summary of a step, int64[3, worlds]: the bits of `motor_power.powers`; the first hit of the world and the
# end of its hits.
FOUND, FIRST_HIT, END_HIT = 0, 1, 2

_ROOM = 16


@njit(cache=True, error_model="numpy")
def _grown(hits: Ints, hit_numbers: Floats, used: int, more: int) -> tuple[Ints, Floats]:
    """Return copies of the hits with room for more."""
    room = 2 * (used + more) + _ROOM
    wider, wider_numbers = np.empty((room, 6), dtype=np.int64), np.empty((room, 6))
    for k in range(used):
        for column in range(6):
            wider[k, column], wider_numbers[k, column] = hits[k, column], hit_numbers[k, column]
    return wider, wider_numbers


@njit(cache=True, error_model="numpy", nogil=True)
def tick_many(
    parts: Floats,
    part_start: Ints,
    shape: Floats,
    marks: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    motors: Floats,
    flaws: Floats,
    noise: Ints,
    limits: Ints,
    numbers: Floats,
    flags: Ints,
    reported: Ints,
    ticks: Ints,
    period: float,
    silence: int,
    staleness: int,
    summary: Ints,
    first: int,
    end: int,
) -> tuple[Ints, Floats]:
    """Move the bodies of some worlds by one tick.

    Args:
        parts: float64[worlds, parts, 6].
        part_start: int64[n + 1], the same in all worlds.
        shape: float64[worlds, 4, n].
        marks: int64[worlds, 3, n].
        pieces: Of the walls, as the next four: the same in all worlds.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
        motors: float64[worlds, MOTOR_ROWS, n].
        flaws: float64[worlds, FLAW_ROWS, n].
        noise: int64[worlds, 2, n].
        limits: int64[worlds, 2, n].
        numbers: float64[worlds, NUMBER_ROWS, n], in and out.
        flags: int64[worlds, FLAG_ROWS, n], in and out.
        reported: int64[0]: no pose is reported.
        ticks: int64[worlds], the tick that each world starts from.
        period: s.
        silence: As in `tick_all`.
        staleness: As in `tick_all`.
        summary: int64[3, worlds], out, rows `FOUND` to `END_HIT`.
        first: The first world to step.
        end: One past the last.

    Returns:
        The hits of these worlds and their numbers, world by world.
    """
    hits, hit_numbers = np.empty((_ROOM, 6), dtype=np.int64), np.empty((_ROOM, 6))
    used = 0
    for world in range(first, end):
        found, touched, touched_numbers = tick_all(
            parts[world], part_start, shape[world], marks[world], pieces, links, edges, cells, frame, motors[world],
            flaws[world], noise[world], limits[world], numbers[world], flags[world], reported, ticks[world], period,
            silence, staleness,
        )  # fmt: skip
        count = touched.shape[0]
        if used + count > hits.shape[0]:
            hits, hit_numbers = _grown(hits, hit_numbers, used, count)
        summary[FOUND, world], summary[FIRST_HIT, world], summary[END_HIT, world] = found, used, used + count
        for k in range(count):
            for column in range(6):
                hits[used + k, column] = touched[k, column]
                hit_numbers[used + k, column] = touched_numbers[k, column]
        used += count
    return hits[:used], hit_numbers[:used]
