"""Compiling the kernels before anybody waits for them, and showing it while it happens."""

from __future__ import annotations

import os
import sys
import threading
import time
from pathlib import Path

from intellwheels_maps import floor, robot
from intellwheels_schemas.messages import Actions
from intellwheels_server.inputs import Inputs, Join
from intellwheels_server.kernel_cache import is_cold
from intellwheels_server.world import Setup, advance, apply, begin, digest, entities, measures


def warm() -> None:
    """Run a small world, so that every kernel is compiled or read from the cache.

    When the cache is empty, standard error says so and how long it has taken, every few seconds.
    """
    if not is_cold(Path(os.environ["NUMBA_CACHE_DIR"])):
        _exercise()
        return
    print("compiling kernels: once, about 20 s", file=sys.stderr, flush=True)  # noqa: T201 - what a person waits for
    began = time.monotonic()
    done = threading.Event()
    watcher = threading.Thread(target=_show, args=(began, done), name="warming", daemon=True)
    watcher.start()
    try:
        _exercise()
    finally:
        done.set()
        watcher.join()
    print(f"compiled kernels seconds={time.monotonic() - began:.1f}", file=sys.stderr, flush=True)  # noqa: T201


def _show(began: float, done: threading.Event) -> None:
    while not done.wait(3.0):
        print(f"compiling kernels: {time.monotonic() - began:.0f} s so far", file=sys.stderr, flush=True)  # noqa: T201


def _exercise() -> None:
    """Two chairs side by side for a few ticks: motion, contact, sensing, digest."""
    state = begin(Setup(floor=floor("room")), run="0" * 16)
    chair = robot("rear-wheel")
    state, _ = apply(state, [Join(agent=name, robot=chair) for name in ("one", "two")])
    for _ in range(3):
        drive = {name: Actions(left_motor=0.5, right_motor=0.25) for name in state.names}
        state, _ = advance(state, Inputs(actions=drive))
    for name in state.names:
        measures(state, name)
    entities(state)
    digest(state)
