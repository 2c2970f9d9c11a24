from __future__ import annotations

from intellwheels_maps import floor
from intellwheels_schemas.codec import encode
from intellwheels_schemas.messages import Load
from intellwheels_server.service.floor_queue import MAX_LOADS, POLL_INTERVAL, WORK_SHARE, FloorQueue
from intellwheels_server.service.load_floor import LoadedFloor, LoadFault, LoadRequest, PackedFloor
from intellwheels_server.service.side_process import Outcome
from tests.server.stage import FloorsAtOnce

LIMIT = 4.5


class Answers:
    """A queue of floors whose worker answers when the test says so, and what it answered."""

    def __init__(self) -> None:
        self.worker = FloorsAtOnce()
        self.worker.holds = True
        self.queue = FloorQueue(self.worker, LIMIT / WORK_SHARE)
        self.found: list[LoadedFloor | LoadFault | str] = []

    def load(self, now: float = 0.0) -> bool:
        request = LoadRequest(encode(Load(name="corner")), "")
        return self.queue.add_load(request, lambda found, _now: self.found.append(found), now)

    def work(self, now: float = 0.0) -> int:
        """Work, make what is ready, and return how much was."""
        ready = self.queue.work(now)
        for request in ready:
            request(now)
        return len(ready)

    def fault(self, k: int = -1) -> str:
        found = self.found[k]
        assert isinstance(found, LoadFault)
        assert found.code == "failed"
        return found.text


def test_floor_comes_when_the_worker_has_it() -> None:
    answers = Answers()
    assert answers.load()
    assert answers.work() == 0
    assert answers.queue.due(1.0) == 1.0 + POLL_INTERVAL
    answers.worker.finish()
    assert answers.work(0.1) == 1
    found = answers.found[0]
    assert isinstance(found, LoadedFloor)
    assert found.floor == floor("corner")
    assert answers.queue.is_empty
    assert answers.queue.due(1.0) == float("inf")


def test_later_requests_keep_their_order_behind_a_load() -> None:
    answers = Answers()
    answers.load()
    answers.queue.add(lambda _now: answers.found.append("reset"))
    answers.load()
    answers.queue.add(lambda _now: answers.found.append("spawn"))
    assert answers.work() == 0
    answers.worker.finish()
    assert answers.work() == 2
    assert answers.found[1] == "reset"
    answers.worker.finish()
    assert answers.work() == 2
    assert answers.found[3] == "spawn"


def test_load_that_takes_too_long_is_answered_in_time_even_if_its_worker_is_silent() -> None:
    answers = Answers()
    answers.load(now=1.0)
    answers.work(1.5)
    assert answers.worker.begun[0][1] == LIMIT - 0.5
    assert answers.work(1.0 + LIMIT - 0.001) == 0
    assert answers.work(1.0 + LIMIT) == 1
    assert answers.fault() == "Load: expected a map that is ready within 4.5 s, got one that takes longer"


def test_worker_says_late_or_crashed() -> None:
    answers = Answers()
    for code, words in (("late", "takes longer"), ("crashed", "restart the simulator")):
        answers.load()
        answers.work()
        outcome: Outcome[PackedFloor | LoadFault] = Outcome("late" if code == "late" else "crashed")
        answers.worker.outcomes.append(outcome)
        assert answers.work() == 1
        assert words in answers.fault()


def test_late_outcome_of_one_load_is_not_taken_for_the_next_one() -> None:
    answers = Answers()
    answers.load(now=0.0)
    answers.work(0.0)
    answers.work(LIMIT)
    assert answers.load(now=LIMIT)
    assert answers.work(LIMIT) == 0
    assert len(answers.worker.begun) == 1  # the worker is still busy
    answers.worker.outcomes.append(Outcome("late"))
    assert answers.work(LIMIT + 1.0) == 0
    assert len(answers.worker.begun) == 2
    answers.worker.finish()
    assert answers.work(LIMIT + 1.1) == 1
    assert isinstance(answers.found[-1], LoadedFloor)


def test_load_whose_turn_never_comes_is_answered_in_time_too() -> None:
    answers = Answers()
    answers.load(now=0.0)
    answers.load(now=1.0)
    answers.work(1.0)
    assert answers.work(1.0 + LIMIT) == 2
    assert answers.fault() == "Load: other maps are being loaded; ask again"
    assert len(answers.worker.begun) == 1


def test_flood_of_loads_is_refused() -> None:
    answers = Answers()
    assert [answers.load() for _ in range(MAX_LOADS + 2)] == [True] * MAX_LOADS + [False] * 2


def test_loads_that_wait_at_the_end_are_answered() -> None:
    answers = Answers()
    answers.load()
    answers.work()
    answers.load()
    answers.queue.add(lambda _now: answers.found.append("reset"))
    for request in answers.queue.close():
        request(0.0)
    assert [answers.fault(k) for k in range(2)] == ["the simulator ends"] * 2
    assert len(answers.found) == 2
