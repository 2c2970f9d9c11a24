"""When a sensor samples, and where its samples are stored.

Every sensor has its own rate and latency, in ticks. Both follow from the tick alone: a sensor samples every
`EVERY` ticks from the tick of its first sample, and a reading is the newest sample at least `LATENCY` ticks old.
So the state holds only the samples, in ring buffers that are just deep enough.
"""

from __future__ import annotations

from numba import njit

from intellwheels_server.world.kernels.arrays import Ints

# Columns of a schedule, int64[sensors, 8]: index of the body; ticks from sample to sample, >= 1, and from
# sample to reading, >= 0; tick of the first sample; place of the first number in the samples; samples kept; noise
# key, the bits of two unsigned numbers.
BODY, EVERY, LATENCY, JOINED, FIRST_SAMPLE, DEPTH, KEY0, KEY1 = 0, 1, 2, 3, 4, 5, 6, 7
SCHEDULE_COLUMNS = 8


def depth(every: int, latency: int) -> int:
    """Return how many samples must be kept for the oldest one that a reading can need."""
    return -(-latency // every) + 1


@njit(cache=True, error_model="numpy")
def due_slot(schedule: Ints, sensor: int, tick: int, width: int) -> int:
    """Return the place in the samples of the sample a sensor takes at a tick, or -1 when none is due.

    Args:
        schedule: int64[sensors, 8].
        sensor: Row of the schedule.
        tick: The tick.
        width: Numbers in a sample.
    """
    age = tick - schedule[sensor, JOINED]
    every = schedule[sensor, EVERY]
    if age < 0:
        return -1
    if every != 1:
        if age % every != 0:
            return -1
        age //= every
    if schedule[sensor, DEPTH] == 1:
        return int(schedule[sensor, FIRST_SAMPLE])
    return int(schedule[sensor, FIRST_SAMPLE] + age % schedule[sensor, DEPTH] * width)
