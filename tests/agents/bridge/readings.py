"""Readings for tests, and a driver that returns them."""

from __future__ import annotations

import threading
from typing import Any

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_schemas.messages import Pace


def reading(seq: int, left: int = 0, right: int = 0, **more: Any) -> Reading:
    given = {"epoch": "a", "stamp": 0.05 * seq, "received": 0.05 * seq, **more}
    return Reading(seq=seq, left=left, right=right, **given)


class FakeDriver:
    """A driver that returns the readings put into `waiting` and records its calls."""

    restarts_at_start = False
    failure: str | None = None

    def __init__(self) -> None:
        self.connected = threading.Event()
        self.waiting: list[Reading] = []
        self.written: list[tuple[float, float]] = []
        self.ticks: list[tuple[str, int]] = []
        self.runs: list[str] = []
        self.paired = False

    def start(self) -> None: ...

    def read(self) -> list[Reading]:
        found, self.waiting = self.waiting, []
        return found

    def write(self, left: float, right: float) -> None:
        self.written.append((left, right))

    def begin_run(self, run: str) -> None:
        self.runs.append(run)

    def sync_tick(self, run: str, tick: int, pace: Pace) -> bool:
        return self.paired

    def power_received(self, run: str, tick: int) -> None:
        self.ticks.append((run, tick))

    def faults(self) -> dict[str, int]:
        return {}

    def close(self) -> None: ...
