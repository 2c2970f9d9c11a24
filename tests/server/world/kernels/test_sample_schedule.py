"""A sensor's rate and latency follow from the tick alone."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_server.world.kernels.sample_schedule import depth, due_slot


def _row(every: int, latency: int, joined: int) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    return np.array([[0, every, latency, joined, 100, depth(every, latency), 0, 0]], dtype=np.int64)


def test_sensor_of_every_tick_without_latency_keeps_one_sample() -> None:
    row = _row(1, 0, joined=7)
    assert [due_slot(row, 0, tick, 3) for tick in (6, 7, 8, 1000)] == [-1, 100, 100, 100]


def test_sensor_samples_each_so_many_ticks_from_the_one_it_joined_at() -> None:
    row = _row(3, 0, joined=5)
    assert [tick for tick in range(20) if due_slot(row, 0, tick, 1) >= 0] == [5, 8, 11, 14, 17]


@pytest.mark.parametrize(("every", "latency"), [(1, 0), (1, 1), (1, 4), (2, 1), (3, 7), (5, 5), (4, 1)])
def test_newest_sample_as_old_as_the_latency_is_still_there(every: int, latency: int) -> None:
    row = _row(every, latency, joined=2)
    ring = np.full(100 + depth(every, latency), -1)
    for tick in range(2, 60):
        slot = due_slot(row, 0, tick, 1)
        if slot >= 0:
            ring[slot] = tick
        taken = list(range(2, tick - latency + 1, every))
        if taken:
            number = (tick - latency - 2) // every
            assert ring[100 + number % depth(every, latency)] == taken[-1]
