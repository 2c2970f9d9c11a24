"""The loop with a service and a clock of its own: what it takes first, and that a flood makes no tick late."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest
import zenoh

from intellwheels_schemas.keys import Keys
from intellwheels_schemas.zenoh_inbox import KEY_SHARE, LOOKED_AT, Inbox
from intellwheels_server.service.arrival import Arrival, Put, Query
from intellwheels_server.service.arrival_reader import ArrivalReader
from intellwheels_server.service.main_loop import (
    AT_A_TIME,
    QUERY_TIME,
    RENEW_EVERY,
    REPORT_EVERY,
    DropReport,
    run_service,
)

KEYS = Keys("main")
PERIOD = 0.05


@dataclass
class Service:
    """A service with ticks of `PERIOD`, each of whose arrivals takes some time of a clock that nothing else moves."""

    cost: float
    ticks: int
    now: float = 0.0
    exit: int | None = None
    done: list[float] = field(default_factory=list)
    taken: list[str] = field(default_factory=list)
    on_tick: Callable[[], None] = lambda: None
    counts: bool = True

    @property
    def state(self) -> Service:
        return self

    @property
    def tick(self) -> int:
        return len(self.done) if self.counts else 0

    def take(self, arrival: Arrival, _now: float) -> None:
        self.now += self.cost
        self.taken.append(arrival.topic if isinstance(arrival, Query) else type(arrival).__name__)

    def due(self, _now: float) -> float:
        return PERIOD * (len(self.done) + 1)

    def work(self, now: float) -> None:
        if now >= self.due(now):
            self.done.append(now)
            self.on_tick()
        if len(self.done) >= self.ticks:
            self.exit = 0

    def spend(self, _seconds: float, _now: float) -> None:
        pass


class Message:
    """A put of actions or a query, as Zenoh delivers it."""

    kind = None
    encoding = "application/json"
    parameters = ""

    def __init__(self, key: str) -> None:
        self.key_expr, self.payload = key, self

    def __len__(self) -> int:
        return 2

    def to_bytes(self) -> bytes:
        return b"{}"

    def drop(self) -> None:
        pass


def run(service: Service, inbox: Inbox, monkeypatch: pytest.MonkeyPatch) -> None:
    def wait(seconds: float) -> bool:
        if some := Inbox.wait(inbox, 0.0):
            return some
        service.now += seconds
        return False

    monkeypatch.setattr(inbox, "wait", wait)
    parts: Any = service
    run_service(
        parts, ArrivalReader(KEYS), inbox, threading.Event(), lambda: None, lambda _now: None, lambda: service.now
    )


def put(inbox: Inbox, count: int) -> None:
    for _ in range(count):
        inbox._keep(Put("a", "actions", b"{}", ""), 1)  # type: ignore[arg-type]


def ask(inbox: Inbox, key: str, count: int) -> None:
    for _ in range(count):
        inbox.queries_of(key)(Message(key))  # type: ignore[arg-type]


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Messages arrive as what the reader would make of them."""
    real = ArrivalReader.read
    monkeypatch.setattr(ArrivalReader, "read", lambda self, one: one if isinstance(one, Put) else real(self, one))


@pytest.mark.usefixtures("reads")
def test_messages_come_before_queries_and_keys_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    inbox, service = Inbox(), Service(cost=0.0, ticks=1)
    ask(inbox, KEYS.map, 3)
    ask(inbox, KEYS.clock, 1)
    put(inbox, 2)
    run(service, inbox, monkeypatch)
    assert service.taken == ["Put", "Put", "map", "clock", "map", "map"]


@pytest.mark.usefixtures("reads")
def test_flood_of_queries_makes_no_tick_late_and_is_answered_between_them(monkeypatch: pytest.MonkeyPatch) -> None:
    inbox, service = Inbox(), Service(cost=0.001, ticks=20)
    ask(inbox, KEYS.map, 500)
    run(service, inbox, monkeypatch)
    late = [now - PERIOD * number for number, now in enumerate(service.done, 1)]
    assert max(late) < 2 * service.cost
    assert len(service.taken) == 500


@pytest.mark.usefixtures("reads")
def test_messages_are_taken_soon_in_a_flood_of_queries(monkeypatch: pytest.MonkeyPatch) -> None:
    inbox, service = Inbox(), Service(cost=0.001, ticks=2)
    ask(inbox, KEYS.map, 500)
    service.on_tick = lambda: put(inbox, 1)
    run(service, inbox, monkeypatch)
    rest = service.taken[service.taken.index("map") :]
    first = rest.index("Put")
    assert first * service.cost <= PERIOD + QUERY_TIME + 2 * service.cost


@pytest.mark.usefixtures("reads")
def test_flood_of_messages_delays_a_tick_and_a_query_by_some_of_them_only(monkeypatch: pytest.MonkeyPatch) -> None:
    inbox, service = Inbox(), Service(cost=0.00001, ticks=5)
    put(inbox, 16_000)
    ask(inbox, KEYS.clock, 1)
    run(service, inbox, monkeypatch)
    late = [now - PERIOD * number for number, now in enumerate(service.done, 1)]
    assert max(late) <= (AT_A_TIME + 1) * service.cost + 1e-9
    assert service.taken.index("clock") == AT_A_TIME
    assert service.taken.count("Put") == 16_000


@pytest.mark.usefixtures("reads")
@pytest.mark.parametrize("counts", [True, False], ids=["ticks go on", "no tick is counted"])
def test_agent_gets_its_share_again_at_each_tick_and_while_there_is_none(
    monkeypatch: pytest.MonkeyPatch, counts: bool
) -> None:
    inbox, service = Inbox(known={KEYS.actions("a")}), Service(cost=0.0, ticks=20, counts=counts)
    message: Any = Message(KEYS.actions("a"))
    message.kind = zenoh.SampleKind.PUT

    def flood() -> None:
        for _ in range(3 * KEY_SHARE):
            inbox.on_sample(message)

    service.on_tick = flood
    run(service, inbox, monkeypatch)
    shares, time = len(service.taken) / KEY_SHARE, 19 * PERIOD
    if counts:
        assert shares == 19
    else:
        # A renewal may wait for the next look, a period later.
        assert time / (RENEW_EVERY + PERIOD) - 1 <= shares <= time / RENEW_EVERY + 1


def test_drops_are_reported_at_most_once_a_second_with_their_keys() -> None:
    report = DropReport()
    assert report.lines(0, {}, 0.0) == []
    assert report.lines(2, {"map": 3}, 1.0) == [
        "dropped arrivals=2 why='more than can be read'",
        "dropped queries=3 key=map why='more than can be answered'",
    ]
    assert report.lines(9, {"map": 4}, 1.0 + REPORT_EVERY / 2) == []
    assert report.lines(2, {"map": 5, "clock": 1}, 1.0 + REPORT_EVERY) == [
        "dropped queries=2 key=map why='more than can be answered'",
        "dropped queries=1 key=clock why='more than can be answered'",
    ]


def test_full_ring_is_reported() -> None:
    report = DropReport()
    assert report.lines(0, {}, 0.0, 0) == []
    full = ["dropped arrivals=some why='a ring of messages was full; its oldest may be lost'"]
    assert report.lines(0, {}, 1.0, 2) == full
    assert report.lines(0, {}, 3.0, 2) == []


@pytest.mark.usefixtures("reads")
def test_messages_in_a_ring_are_taken_at_their_tick_within_the_share_of_their_key(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    inbox, service = Inbox(known={KEYS.actions("a")}), Service(cost=0.0, ticks=3)
    message: Any = Message(KEYS.actions("a"))
    message.kind = zenoh.SampleKind.PUT
    ring: deque[Any] = deque()
    inbox.add_ring(lambda: ring.popleft() if ring else None, 100_000)
    service.on_tick = lambda: ring.extend([message] * (LOOKED_AT + 5))
    run(service, inbox, monkeypatch)
    assert len(service.taken) == 2 * KEY_SHARE
