"""Readings, and a driver that is told what it reads."""

from __future__ import annotations

import threading
from typing import Any

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_schemas.messages import Pace


def reading(seq: int, left: int = 0, right: int = 0, **more: Any) -> Reading:
    given = {"era": "a", "taken": 0.05 * seq, "arrived": 0.05 * seq, **more}
    return Reading(seq=seq, left=left, right=right, **given)


class Told:
    """A driver whose readings are put into it, and that keeps what it is told."""

    returns = False
    failure: str | None = None

    def __init__(self) -> None:
        self.heard = threading.Event()
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

    def enter(self, run: str) -> None:
        self.runs.append(run)

    def meet(self, run: str, tick: int, pace: Pace) -> bool:
        return self.paired

    def powered(self, run: str, tick: int) -> None:
        self.ticks.append((run, tick))

    def faults(self) -> dict[str, int]:
        return {}

    def close(self) -> None: ...
