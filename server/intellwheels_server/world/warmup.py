"""Compiling the kernels before the first tick, with progress on standard error."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import structs
from numba.core import event

from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.file_records import Inputs, Join, TeleportBody
from intellwheels_schemas.messages import Actions, Position, Robot
from intellwheels_schemas.process import PYTHON
from intellwheels_server.kernel_cache import is_cold
from intellwheels_server.world import Setup, State, advance, apply, begin, digest, entities, measures
from intellwheels_server.world.measures_writer import MeasuresWriter
from intellwheels_server.world.sensors.catalogue import example_sensors
from intellwheels_server.world.state_writer import StateWriter

HELPER_TIMEOUT = 120.0
"""Seconds that the second process may take to compile its half."""


def warm() -> None:
    """Run a small world, so that every kernel is compiled or loaded from the cache.

    If numba compiles one, lines on standard error report it and show the time taken every few seconds. The cache may
    have files and still be of no use: of another Python, another version of numba or another processor.
    """
    announcer = Announcer()
    with event.install_listener("numba:compile", announcer):
        try:
            if is_cold(Path(os.environ["NUMBA_CACHE_DIR"])):
                announcer.begin()
                _compile_in_two()
            _exercise()
        finally:
            announcer.end()


class Announcer(event.Listener):
    """Says on standard error that kernels are compiled, from the first one that numba compiles on."""

    def __init__(self) -> None:
        self._began: float | None = None
        self._done = threading.Event()
        self._watcher = threading.Thread(target=self._show, name="warming", daemon=True)

    def on_start(self, _event: object) -> None:
        """Note that numba compiles a function."""
        self.begin()

    def on_end(self, _event: object) -> None:
        """Do nothing: the next function follows."""

    def begin(self) -> None:
        """Say it, and show the time from now on; only once."""
        if self._began is None:
            self._began = time.monotonic()
            _say("compiling kernels: only at the first start, about a minute")
            self._watcher.start()

    def end(self) -> None:
        """Say how long it took, if anything was compiled."""
        if self._began is not None:
            self._done.set()
            self._watcher.join()
            _say(f"compiled kernels seconds={time.monotonic() - self._began:.1f}")

    def _show(self) -> None:
        while not self._done.wait(3.0):
            _say(f"compiling kernels: {time.monotonic() - (self._began or 0.0):.0f} s so far")


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)  # noqa: T201 - a person waits for it


def _compile_in_two() -> None:
    """Compile the two largest kernels in two processes, as numba uses one core in each.

    If the second process fails, its kernels are compiled afterwards.
    """
    program = "from intellwheels_server.world import warmup; warmup.join()"
    helper = subprocess.Popen(
        [*PYTHON, "-c", program],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        advance(begin(Setup(floor=floor("room")), run="0" * 16), Inputs())
        helper.wait(HELPER_TIMEOUT)
    except subprocess.TimeoutExpired:
        pass
    finally:
        helper.kill()
        helper.wait()


def join() -> State:
    """Return a world that a chair has just joined. This compiles placing and sensing, but not stepping."""
    state = begin(Setup(floor=floor("room"), truth=True), run="0" * 16)
    return apply(state, [Join(agent="one", robot=_perceptive())])[0]


def _perceptive() -> Robot:
    """Return a chair with the sensors that together need every kernel of every kind."""
    sensors: dict[str, Any] = dict(example_sensors(floor("room")))
    return structs.replace(robot("rear-wheel"), **sensors)


def _exercise() -> None:
    """Run two chairs and a table for a few ticks: motion, sensing, contact of bodies and walls, episodes, digest."""
    state = begin(Setup(floor=floor("room"), truth=True, say_walls=True, say_loss=0.01), run="0" * 16)
    chair = _perceptive()
    joins = [Join(agent=name, robot=chair) for name in ("one", "two")]
    state, _ = apply(state, [*joins, Join(agent="three", robot=robot("table"))])
    drive = {name: Actions(left_motor=1.0, right_motor=0.9, say="warm") for name in ("one", "two")}
    for _ in range(3):
        state, _ = advance(state, Inputs(actions=drive))
    at = state.body_set.models["two"].start
    # Into the other chair and beyond the wall: only a forced teleport leads there.
    into = TeleportBody(agent="one", position=Position(x=at.x + 0.5, y=at.y, heading=0.5), force=True)
    beyond = TeleportBody(agent="two", position=Position(x=0.0, y=at.y, heading=3.0), force=True)
    for change in (into, beyond):
        state, _ = apply(state, [change])
        for _ in range(12):
            state, _ = advance(state, Inputs(actions=drive))
    for encoding in Encoding:
        MeasuresWriter(encoding).write(state, state.names)
    for name in state.names:
        measures(state, name)
    entities(state)
    StateWriter().write(state, {}, np.zeros((2, len(state.names))))
    digest(state)
