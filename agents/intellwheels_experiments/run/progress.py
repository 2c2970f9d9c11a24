"""Progress of a run: one line that is updated on a terminal, a plain line every few seconds elsewhere."""

from __future__ import annotations

import math
import time
from types import TracebackType
from typing import Final, Self

from rich.console import Console
from rich.status import Status
from rich.text import Text

from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.messages import Map, Scene

PLAIN_EVERY: Final = 5.0
"""Seconds of wall time between plain lines."""


class Progress:
    """Shows how far a run is.

    Args:
        console: A console on standard error, as standard output is for the result.
        scene: The scene.
        floor: Its map, for the places that agents must reach.
    """

    def __init__(self, console: Console, scene: Scene, floor: Map) -> None:
        self._console = console
        self._scene = scene
        places = {place.name: (place.x, place.y) for place in floor.grid.position} if floor.grid else {}
        reaches = scene.end.reach if scene.end else ()
        self._goals = {reach.agent: (*places[reach.place], reach.within) for reach in reaches}
        self._status: Status | None = None
        self._next = time.monotonic() + PLAIN_EVERY
        self._said = ""

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._status = self._console.status(f"{self._scene.name}: starting")
            self._status.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._status is not None:
            self._status.stop()
            self._status = None

    def say(self, text: str) -> None:
        """Print a line."""
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)

    def doing(self, text: str) -> None:
        """Show what is going on now; on a terminal only."""
        if self._status is not None:
            self._status.update(Text(f"{self._scene.name}: {text}"))

    def follow(self, record: RunRecord) -> None:
        """Show how far the run is; off a terminal only what is new.

        It is cheap enough to be called ten times a second.
        """
        if self._status is not None:
            self.doing(describe(record, self._goals))
        elif record.clock is not None and time.monotonic() >= self._next:
            self._next = time.monotonic() + PLAIN_EVERY
            # While a run is paused, or waits for its page, every line would be the same.
            text = describe(record, self._goals)
            if text != self._said:
                self._said = text
                self.say(f"progress {text}")


def describe(record: RunRecord, goals: dict[str, tuple[float, float, float]]) -> str:
    """Return how far a run is, as one line.

    Args:
        record: What was seen of the run.
        goals: By agent that must reach a place: the place's x and y, and the distance that counts as reached, in m.
    """
    clock = record.clock
    if clock is None:
        return "nothing received yet"
    words = [f"{clock.state} {clock.time:.1f} s, {clock.factor:.1f} times real time"]
    if clock.waiting:
        words.append(f"waiting for {', '.join(clock.waiting)}")
    positions, distances = record.positions(), []
    for agent, (x, y, within) in goals.items():
        if agent in positions:
            distance = math.dist(positions[agent], (x, y))
            distances.append(f"{agent} {'at its goal' if distance <= within else f'{distance:.1f} m to go'}")
    return "; ".join(words + ([", ".join(distances)] if distances else []))
