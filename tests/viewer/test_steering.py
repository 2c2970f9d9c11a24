"""From a page's gestures to wishes: the lease, and all the ways of letting go."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any

import pytest

from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Goal, Pause, Record, Result, Resume, Take, UserInput
from intellwheels_viewer.steering import HELD, IDLE, LEASE, RETRY_AFTER, Driving, Refusal, RequestQueue

FIRST = "00000000000000a1"


class Simulator:
    """Grants or refuses what a test says, and keeps all it got, in order."""

    def __init__(self) -> None:
        self.asked: list[tuple[Verb, Record]] = []
        self.puts: list[tuple[str, UserInput]] = []
        self.refuses = ""
        self.holds: threading.Event | None = None
        self.entered = threading.Event()
        self.leases = iter(f"{number:016x}" for number in range(0xA1, 0xFF))

    def ask(self, verb: Verb, request: Record) -> Result:
        self.asked.append((verb, request))
        self.entered.set()
        if self.holds is not None:
            assert self.holds.wait(10.0)
        if self.refuses:
            raise Refusal(self.refuses)
        lease = request.lease or next(self.leases) if isinstance(request, Take) and request.seconds else None
        return Result(code="ok", lease=lease)

    def put_user(self, agent: str, request: UserInput) -> None:
        self.puts.append((agent, request))

    @property
    def takes(self) -> list[Take]:
        return [request for _, request in self.asked if isinstance(request, Take)]


class Waiting:
    """Wishes that are answered when the test says so."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator
        self.open: list[tuple[str | None, Verb, Record, Callable[[Result], None] | None, Callable[[str], None] | None]]
        self.open = []
        self.told: list[str] = []

    def ask(
        self,
        what: str | None,
        verb: Verb,
        request: Record,
        done: Callable[[Result], None] | None = None,
        failed: Callable[[str], None] | None = None,
    ) -> None:
        self.open.append((what, verb, request, done, failed))

    def answer(self) -> None:
        """Answer all, and what they ask for in their turn."""
        while self.open:
            what, verb, request, done, failed = self.open.pop(0)
            try:
                result = self.simulator.ask(verb, request)
            except Refusal as refusal:
                if failed is not None:
                    failed(str(refusal))
                if what is not None:
                    self.told.append(f"{what}: {refusal}")
            else:
                if done is not None:
                    done(result)


class Driver:
    """A page that drives, with a clock of its own."""

    def __init__(self) -> None:
        self.time = 0.0
        self.simulator = Simulator()
        self.requests = Waiting(self.simulator)
        self.driving = Driving(self.simulator, self.requests, lambda: self.time)  # type: ignore[arg-type]

    def stick(self, forward: float, turn: float = 0.0, agent: str | None = "a") -> None:
        self.driving.stick(agent, forward, turn)

    def hold(self, seconds: float, forward: float = 0.5, agent: str = "a") -> None:
        """Hold the stick: ten messages a second, each wish answered before the next."""
        for _ in range(round(seconds * 10)):
            self.stick(forward, agent=agent)
            self.requests.answer()
            self.time += 0.1

    def rest(self, seconds: float) -> None:
        """Nothing from the page; the drawing thread goes on."""
        for _ in range(round(seconds * 5)):
            self.time += 0.2
            self.driving.tick()
            self.requests.answer()


@pytest.fixture
def driver() -> Driver:
    return Driver()


# ---------------------------------------------------------------- driving


def test_nothing_is_put_before_the_lease_and_the_first_move_asks_for_it(driver: Driver) -> None:
    driver.stick(0.5)
    assert driver.simulator.puts == []
    driver.requests.answer()
    assert driver.simulator.takes == [Take(agent="a", seconds=LEASE)]
    driver.stick(0.5, -0.25)
    assert driver.simulator.puts == [("a", UserInput(lease=FIRST, seq=1, forward=0.5, turn=-0.25))]
    assert driver.driving.agent == "a"


def test_a_stick_that_rests_takes_nobody(driver: Driver) -> None:
    driver.stick(0.0)
    driver.rest(5.0)
    assert driver.simulator.asked == []
    driver.stick(0.7, agent=None)
    assert driver.requests.open == []


def test_each_message_is_put_once_and_never_repeated(driver: Driver) -> None:
    driver.hold(1.0)
    count = len(driver.simulator.puts)
    assert count == 9  # the first asked for the lease
    driver.rest(1.0)
    assert len(driver.simulator.puts) == count
    assert [request.seq for _, request in driver.simulator.puts] == list(range(1, count + 1))


def test_the_lease_is_renewed_while_the_page_drives_and_never_runs_out(driver: Driver) -> None:
    driver.hold(30.0)
    takes = driver.simulator.takes
    assert len(takes) == pytest.approx(30.0 / (LEASE / 2), abs=1)
    assert all(take.lease == FIRST for take in takes[1:])
    assert {request.lease for _, request in driver.simulator.puts} == {FIRST}


def test_letting_go_is_a_zero_and_after_a_while_the_body_is_given_back(driver: Driver) -> None:
    driver.hold(1.0)
    driver.stick(0.0)
    assert driver.simulator.puts[-1][1].forward == 0.0
    driver.rest(IDLE - 0.2)
    assert driver.simulator.takes[-1].seconds == LEASE
    driver.rest(0.6)
    assert driver.simulator.takes[-1] == Take(agent="a", lease=FIRST, seconds=0.0)
    assert driver.simulator.puts[-1][1].forward == 0.0
    assert driver.driving.agent is None


def test_it_is_given_back_before_the_lease_is_over_by_itself(driver: Driver) -> None:
    # The last renewal is half a lease old at most when the stick is let go.
    assert IDLE + 0.5 < LEASE / 2


def test_one_drives_from_the_first_move_under_a_lease_until_the_stick_rests(driver: Driver) -> None:
    assert driver.driving.driven is None
    driver.stick(0.0)
    assert driver.driving.driven is None
    driver.stick(0.5)
    assert driver.driving.driven is None
    driver.requests.answer()
    driver.stick(0.5)
    assert driver.driving.driven == "a"
    driver.stick(0.0)
    driver.rest(HELD + 0.1)
    assert driver.driving.driven is None
    driver.stick(0.5)
    assert driver.driving.driven == "a"


def test_a_lease_that_ran_out_is_taken_anew(driver: Driver) -> None:
    driver.hold(1.0)
    driver.time += LEASE  # the drawing thread was held up
    driver.stick(0.5)
    puts = len(driver.simulator.puts)
    driver.requests.answer()
    assert driver.simulator.takes[-1].lease is None
    driver.stick(0.5)
    assert len(driver.simulator.puts) == puts + 1
    assert driver.simulator.puts[-1][1].lease != FIRST
    assert driver.requests.told == []


def test_another_selection_lets_go_of_the_first_at_once(driver: Driver) -> None:
    driver.hold(1.0)
    driver.stick(0.5, agent="b")
    assert driver.simulator.puts[-1] == ("a", UserInput(lease=FIRST, seq=10))
    driver.requests.answer()
    assert driver.simulator.takes[-2:] == [
        Take(agent="a", lease=FIRST, seconds=0.0),
        Take(agent="b", seconds=LEASE),
    ]
    driver.stick(0.5, agent="b")
    assert driver.simulator.puts[-1][0] == "b"


def test_a_lease_that_comes_after_the_selection_changed_is_given_back(driver: Driver) -> None:
    driver.stick(0.5)
    driver.stick(0.0, agent=None)
    driver.requests.answer()
    assert driver.simulator.takes == [Take(agent="a", seconds=LEASE), Take(agent="a", lease=FIRST, seconds=0.0)]
    assert driver.simulator.puts == []


def test_a_lease_asked_for_before_the_same_was_selected_again_is_not_used(driver: Driver) -> None:
    driver.hold(LEASE / 2)
    driver.stick(0.5)  # a renewal is on its way
    assert driver.requests.open
    driver.stick(0.0, agent=None)
    driver.stick(0.5)
    driver.requests.answer()
    driver.stick(0.5)
    driver.requests.answer()
    driver.stick(0.5)
    assert driver.simulator.puts[-1][1].lease != FIRST  # that one was given back


def test_a_page_that_closes_stops_and_gives_back(driver: Driver) -> None:
    driver.hold(1.0)
    driver.driving.close()
    driver.requests.answer()
    assert driver.simulator.puts[-1] == ("a", UserInput(lease=FIRST, seq=10))
    assert driver.simulator.takes[-1].seconds == 0.0
    puts = len(driver.simulator.puts)
    driver.stick(1.0)
    driver.driving.tick()
    assert len(driver.simulator.puts) == puts
    assert driver.requests.open == []


def test_a_page_that_closes_while_it_asks_gives_back_what_it_then_gets(driver: Driver) -> None:
    driver.stick(0.5)
    driver.driving.close()
    driver.requests.answer()
    assert driver.simulator.takes[-1] == Take(agent="a", lease=FIRST, seconds=0.0)
    assert driver.simulator.puts == []


def test_a_refusal_is_told_and_asked_again_once_a_second_not_with_each_message(driver: Driver) -> None:
    driver.simulator.refuses = "agent 'a' is taken by somebody else"
    driver.hold(5.0)
    assert driver.simulator.puts == []
    assert len(driver.simulator.takes) == pytest.approx(5.0 / RETRY_AFTER, abs=1)
    assert driver.requests.told[0] == "Cannot drive: agent 'a' is taken by somebody else"
    driver.simulator.refuses = ""
    driver.hold(1.5)
    assert driver.simulator.puts


def test_nobody_is_told_that_giving_back_was_refused(driver: Driver) -> None:
    driver.hold(1.0)
    driver.simulator.refuses = "no such agent"
    driver.driving.close()
    driver.requests.answer()
    assert driver.requests.told == []


def test_a_goal_lets_go_of_what_was_driven_and_is_put_after_the_body_was_given_back(driver: Driver) -> None:
    driver.stick(0.5)
    driver.requests.answer()
    driver.stick(0.5)
    driver.driving.go("b", Goal(x=1.0, y=2.0))
    assert driver.simulator.puts[-1][1].forward == 0.0
    driver.requests.answer()
    assert [(take.agent, take.seconds) for take in driver.simulator.takes[-3:]] == [
        ("a", 0.0),
        ("b", LEASE),
        ("b", 0.0),
    ]
    assert driver.simulator.puts[-1] == ("b", UserInput(goal=Goal(x=1.0, y=2.0)))


def test_a_goal_that_is_refused_is_not_put(driver: Driver) -> None:
    driver.simulator.refuses = "taken by somebody else"
    driver.driving.go("a", Goal(x=1.0, y=2.0))
    driver.requests.answer()
    assert driver.simulator.puts == []
    assert driver.requests.told == ["No goal set: taken by somebody else"]


@pytest.mark.parametrize("bad", [(math.nan, 0.5), (0.5, math.nan), (math.inf, 0.0), (0.0, -math.inf)])
def test_what_is_no_number_is_a_release(driver: Driver, bad: tuple[float, float]) -> None:
    driver.hold(0.5)
    driver.stick(*bad)
    assert (driver.simulator.puts[-1][1].forward, driver.simulator.puts[-1][1].turn) == (0.0, 0.0)


def test_no_stick_is_pulled_farther_than_it_goes(driver: Driver) -> None:
    driver.hold(0.5)
    driver.stick(1e9, -1e9)
    assert (driver.simulator.puts[-1][1].forward, driver.simulator.puts[-1][1].turn) == (1.0, -1.0)


# ---------------------------------------------------------------- the worker


def told(simulator: Any) -> tuple[RequestQueue, list[tuple[str, str]]]:
    notices: list[tuple[str, str]] = []
    return RequestQueue(simulator, lambda what, why: notices.append((what, why))), notices


def test_wishes_are_asked_one_after_the_other_and_all_before_the_end() -> None:
    simulator = Simulator()
    requests, notices = told(simulator)
    granted: list[Result] = []
    for request in (Pause(), Resume(), Pause()):
        requests.ask("Not done", "pause", request, granted.append)
    requests.close()
    requests.join(10.0)
    assert [request for _, request in simulator.asked] == [Pause(), Resume(), Pause()]
    assert len(granted) == 3
    assert notices == []


def test_asking_does_not_wait_for_the_answer() -> None:
    simulator = Simulator()
    simulator.holds = threading.Event()
    requests, _ = told(simulator)
    requests.ask("Not paused", "pause", Pause())
    assert simulator.entered.wait(10.0)
    requests.ask("Not resumed", "resume", Resume())
    assert len(simulator.asked) == 1
    simulator.holds.set()
    requests.close()
    requests.join(10.0)
    assert len(simulator.asked) == 2


def test_who_asked_hears_why_it_was_refused_and_then_the_user() -> None:
    simulator = Simulator()
    simulator.refuses = "overlaps a wall"
    requests, notices = told(simulator)
    reasons: list[str] = []
    requests.ask("Not placed", "spawn", Pause(), lambda _: reasons.append("granted"), reasons.append)
    requests.ask(None, "spawn", Pause())
    requests.close()
    requests.join(10.0)
    assert reasons == ["overlaps a wall"]
    assert notices == [("Not placed", "overlaps a wall")]


def test_what_an_answer_asks_for_in_its_turn_is_still_said_after_the_close() -> None:
    simulator = Simulator()
    simulator.holds = threading.Event()
    requests, _ = told(simulator)
    requests.ask(
        "Cannot drive", "take", Take(agent="a"), lambda _: requests.ask(None, "take", Take(agent="a", seconds=0.0))
    )
    requests.close()
    simulator.holds.set()
    requests.join(10.0)
    assert [take.seconds for take in simulator.takes] == [2.0, 0.0]


def test_a_simulator_that_does_not_answer_holds_nobody() -> None:
    simulator = Simulator()
    simulator.holds = threading.Event()
    requests, _ = told(simulator)
    requests.ask("Not paused", "pause", Pause())
    assert simulator.entered.wait(10.0)
    requests.close()
    requests.join(0.05)
    assert requests._worker.daemon
    simulator.holds.set()
    requests.join(10.0)
    assert not requests._worker.is_alive()
