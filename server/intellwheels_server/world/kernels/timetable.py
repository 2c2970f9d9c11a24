"""When a sensor samples and where its samples are kept.

Every kind of sensor has a rate and a latency of its own, in ticks. Both follow from the tick alone: a
sensor samples each `EVERY` ticks from the tick it joined at, and a reading is the newest sample that is at least
`LATENCY` ticks old. So the state holds nothing but the samples, in rings just deep enough.
"""

from __future__ import annotations

from numba import njit

from intellwheels_server.world.kernels.arrays import Ints

# Columns of a timetable, int64[sensors, 8]: index of the body; ticks from sample to sample, >= 1, and from
# sample to reading, >= 0; tick of the first sample; place of the first number in the samples; samples kept; noise
# key, the bits of two unsigned numbers.
BODY, EVERY, LATENCY, JOINED, FIRST, DEPTH, KEY0, KEY1 = 0, 1, 2, 3, 4, 5, 6, 7
COLUMNS = 8


def depth(every: int, latency: int) -> int:
    """Return how many samples must be kept so that a reading finds its own."""
    return -(-latency // every) + 1


@njit(cache=True, error_model="numpy")
def due_slot(timetable: Ints, sensor: int, tick: int, width: int) -> int:
    """Return the place in the samples of the sample a sensor takes at a tick, or -1 when none is due.

    Args:
        timetable: int64[sensors, 8].
        sensor: Row of the timetable.
        tick: The tick.
        width: Numbers in a sample.
    """
    age = tick - timetable[sensor, JOINED]
    every = timetable[sensor, EVERY]
    if age < 0:
        return -1
    if every != 1:
        if age % every != 0:
            return -1
        age //= every
    if timetable[sensor, DEPTH] == 1:
        return int(timetable[sensor, FIRST])
    return int(timetable[sensor, FIRST] + age % timetable[sensor, DEPTH] * width)
