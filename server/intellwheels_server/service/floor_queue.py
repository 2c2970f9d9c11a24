"""The requests to load a floor, and those that must not overtake them.

Loading goes on in a side process. Its result is a change like any other: it acts at the tick at which it is known.
Pure: time is passed in.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from intellwheels_schemas import defaults
from intellwheels_server.service.load_floor import FloorWorker, LoadedFloor, LoadFault, LoadRequest, unpack

POLL_INTERVAL: Final = 0.01
"""Seconds between two looks at the side process."""
WORK_SHARE: Final = 0.9
"""Share of the time for an answer after which the work is given up, so that the answer still comes in time."""
MAX_LOADS: Final = 8
"""Loads that may wait. Further ones are refused at once; they can be asked for again."""

CRASHED: Final = (
    "Load: this map could not be loaded, and the simulator's error output says why; "
    "if no map can be loaded any more, restart the simulator"
)

Answer = Callable[[LoadedFloor | LoadFault, float], None]
"""Takes the floor, or why there is none, and the time."""
Request = Callable[[float], None]
"""Makes a change; it takes the time."""


@dataclass(slots=True)
class _Load:
    request: LoadRequest
    answer: Answer
    until: float
    begun: bool = False


class FloorQueue:
    """Loads one floor after another, and keeps later requests in their order.

    Args:
        worker: Loads the floors.
        limit: Seconds in which a load is answered.
    """

    def __init__(self, worker: FloorWorker, limit: float = defaults.LOAD_TIME) -> None:
        self._worker = worker
        self._limit = WORK_SHARE * limit
        self._waiting: deque[_Load | Request] = deque()
        self._loading: _Load | None = None
        # Whether the worker still owes an outcome.
        self._is_busy = False

    @property
    def is_empty(self) -> bool:
        """Whether no request waits."""
        return self._loading is None and not self._waiting

    def add_load(self, request: LoadRequest, answer: Answer, now: float) -> bool:
        """Load a floor in its turn, and then call `answer`. Return whether there is room for it."""
        if sum(isinstance(one, _Load) for one in self._waiting) >= MAX_LOADS:
            return False
        self._waiting.append(_Load(request, answer, now + self._limit))
        return True

    def add(self, request: Request) -> None:
        """Keep a request until the loads before it are answered."""
        self._waiting.append(request)

    def work(self, now: float) -> list[Request]:
        """Begin what can begin. Return the requests whose turn has come, in order."""
        ready: list[Request] = []
        while True:
            found = self._result(now)
            if found is not None:
                ready.append(found)
            elif self._loading is not None or not self._waiting:
                return ready
            elif isinstance(first := self._waiting[0], _Load):
                if not self._begin(first, now):
                    return ready
            else:
                ready.append(first)
                self._waiting.popleft()

    def due(self, now: float) -> float:
        """Return when to call `work` next."""
        return float("inf") if self.is_empty else now + POLL_INTERVAL

    def close(self) -> list[Request]:
        """Return the answers to the loads that wait, for the end of the service. All other requests are dropped."""
        loads = [one for one in (self._loading, *self._waiting) if isinstance(one, _Load)]
        self._loading = None
        self._waiting.clear()
        return [_answering(load, LoadFault("failed", "the simulator ends")) for load in loads]

    def _begin(self, load: _Load, now: float) -> bool:
        """Begin a load; return whether its turn has come. The worker may still be busy with one that was answered."""
        if self._is_busy and self._worker.take() is not None:
            self._is_busy = False
        if self._is_busy and now < load.until:
            return False
        self._waiting.popleft()
        self._loading = load
        if now < load.until:
            self._worker.begin(load.request, load.until - now)
            load.begun = self._is_busy = True
        return True

    def _result(self, now: float) -> Request | None:
        """Return the answer to the load under way, if there is one."""
        load = self._loading
        if load is None:
            return None
        outcome = self._worker.take() if load.begun else None
        if outcome is None and now < load.until:
            return None
        self._loading = None
        if outcome is not None:
            self._is_busy = False
        if not load.begun:
            return _answering(load, LoadFault("failed", "Load: other maps are being loaded; ask again"))
        if outcome is None or outcome.code == "late":
            text = f"Load: expected a map that is ready within {self._limit:g} s, got one that takes longer"
            return _answering(load, LoadFault("failed", text))
        if outcome.result is None:
            return _answering(load, LoadFault("failed", CRASHED))
        found = outcome.result
        return _answering(load, found if isinstance(found, LoadFault) else unpack(found))


def _answering(load: _Load, found: LoadedFloor | LoadFault) -> Request:
    return lambda now: load.answer(found, now)
