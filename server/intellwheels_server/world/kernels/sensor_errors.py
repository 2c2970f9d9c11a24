"""Errors that simple sensors share: value = quantise(clip(true + bias + noise)).

A bias is a random walk: each tick adds a normal number times sqrt(T). So after t seconds its standard deviation is the
declared one times sqrt(t), for any period T. It begins at 0.

Draws of a sensor and tick: axis 0 and 1 noise, 2 and 3 the steps of their biases.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.noise import normal
from intellwheels_server.world.kernels.sample_schedule import DEPTH, FIRST_SAMPLE, KEY0, KEY1

BIAS_MEMORY = 3
"""Numbers stored for a random walk of up to two axes: the tick of its last step, from 1, and the biases."""


@njit(cache=True, error_model="numpy")
def memory_of(schedule: Ints, sensor: int, width: int) -> int:
    """Return the index of the first number in the memory of a sensor, behind its samples of `width` numbers."""
    return int(schedule[sensor, FIRST_SAMPLE] + schedule[sensor, DEPTH] * width)


@njit(cache=True, error_model="numpy")
def walk(
    schedule: Ints,
    sensor: int,
    tick: int,
    width: int,
    axes: int,
    first: float,
    second: float,
    period: float,
    samples: Floats,
) -> None:
    """Step the biases of a sensor. Further calls in the same tick change nothing.

    Args:
        schedule: int64[sensors, 8].
        sensor: Row of the schedule.
        tick: The tick.
        width: Numbers in a sample.
        axes: 1 or 2.
        first: Standard deviation that the first axis' bias gains in a second.
        second: That of the second axis.
        period: Simulated time of a tick, s.
        samples: float64[...], in and out.
    """
    place = memory_of(schedule, sensor, width)
    before = samples[place]
    if before == tick + 1.0:
        return
    samples[place] = tick + 1.0
    if before == 0.0:
        return
    key0, key1 = np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1])
    root = math.sqrt(period)
    for axis in range(axes):
        gain = first if axis == 0 else second
        samples[place + 1 + axis] += gain * root * normal(key0, key1, tick, 2 + axis)


@njit(cache=True, error_model="numpy")
def spoilt(
    true: float,
    schedule: Ints,
    sensor: int,
    tick: int,
    width: int,
    axis: int,
    walks: bool,
    sigma: float,
    step: float,
    most: float,
    samples: Floats,
) -> float:
    """Return a value with the errors of a sensor.

    Args:
        true: The value.
        schedule: int64[sensors, 8].
        sensor: Row of the schedule.
        tick: The tick.
        width: Numbers in a sample.
        axis: 0 or 1.
        walks: Whether there is a bias.
        sigma: Standard deviation of the noise.
        step: Quantisation step, 0 for none.
        most: Bound on either side.
        samples: float64[...].
    """
    value = true
    if walks:
        value += samples[memory_of(schedule, sensor, width) + 1 + axis]
    if sigma > 0.0:
        value += sigma * normal(np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1]), tick, axis)
    value = min(max(value, -most), most)
    if step > 0.0:
        # Clipped to the bound, since no message can carry a larger value.
        value = step * np.floor(value / step + 0.5)
        if abs(value) > most:
            value -= step if value > 0.0 else -step
    return value
