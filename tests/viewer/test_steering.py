"""From a page's gestures to wishes: the lease, and all the ways of letting go."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any

import pytest

from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Goal, Pause, Record, Result, Resume, Take, UserInput
from intellwheels_viewer.steering import AGAIN, IDLE, LEASE, Driving, Refusal, Wishes

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

    def ask(self, verb: Verb, wish: Record) -> Result:
        self.asked.append((verb, wish))
        self.entered.set()
        if self.holds is not None:
            assert self.holds.wait(10.0)
        if self.refuses:
            raise Refusal(self.refuses)
        lease = wish.lease or next(self.leases) if isinstance(wish, Take) and wish.seconds else None
        return Result(code="ok", lease=lease)

    def put_user(self, agent: str, wish: UserInput) -> None:
        self.puts.append((agent, wish))

    @property
    def takes(self) -> list[Take]:
        return [wish for _, wish in self.asked if isinstance(wish, Take)]


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
        wish: Record,
        done: Callable[[Result], None] | None = None,
        failed: Callable[[str], None] | None = None,
    ) -> None:
        self.open.append((what, verb, wish, done, failed))

    def answer(self) -> None:
        """Answer all, and what they ask for in their turn."""
        while self.open:
            what, verb, wish, done, failed = self.open.pop(0)
            try:
                result = self.simulator.ask(verb, wish)
            except Refusal as refusal:
                if failed is not None:
                    failed(str(refusal))
                if what is not None:
                    self.told.append(f"{what}: {refusal}")
            else:
                if done is not None:
                    done(result)


class Hand:
    """A page that drives, with a clock of its own."""

    def __init__(self) -> None:
        self.time = 0.0
        self.simulator = Simulator()
        self.wishes = Waiting(self.simulator)
        self.driving = Driving(self.simulator, self.wishes, lambda: self.time)  # type: ignore[arg-type]

    def stick(self, forward: float, turn: float = 0.0, agent: str | None = "a") -> None:
        self.driving.stick(agent, forward, turn)

    def hold(self, seconds: float, forward: float = 0.5, agent: str = "a") -> None:
        """Hold the stick: ten messages a second, each wish answered before the next."""
        for _ in range(round(seconds * 10)):
            self.stick(forward, agent=agent)
            self.wishes.answer()
            self.time += 0.1

    def rest(self, seconds: float) -> None:
        """Nothing from the page; the drawing thread goes on."""
        for _ in range(round(seconds * 5)):
            self.time += 0.2
            self.driving.tick()
            self.wishes.answer()


@pytest.fixture
def hand() -> Hand:
    return Hand()


# ---------------------------------------------------------------- driving


def test_nothing_is_put_before_the_lease_and_the_first_move_asks_for_it(hand: Hand) -> None:
    hand.stick(0.5)
    assert hand.simulator.puts == []
    hand.wishes.answer()
    assert hand.simulator.takes == [Take(agent="a", seconds=LEASE)]
    hand.stick(0.5, -0.25)
    assert hand.simulator.puts == [("a", UserInput(lease=FIRST, seq=1, forward=0.5, turn=-0.25))]
    assert hand.driving.agent == "a"


def test_a_stick_that_rests_takes_nobody(hand: Hand) -> None:
    hand.stick(0.0)
    hand.rest(5.0)
    assert hand.simulator.asked == []
    hand.stick(0.7, agent=None)
    assert hand.wishes.open == []


def test_each_message_is_put_once_and_never_repeated(hand: Hand) -> None:
    hand.hold(1.0)
    count = len(hand.simulator.puts)
    assert count == 9  # the first asked for the lease
    hand.rest(1.0)
    assert len(hand.simulator.puts) == count
    assert [wish.seq for _, wish in hand.simulator.puts] == list(range(1, count + 1))


def test_the_lease_is_renewed_while_the_page_drives_and_never_runs_out(hand: Hand) -> None:
    hand.hold(30.0)
    takes = hand.simulator.takes
    assert len(takes) == pytest.approx(30.0 / (LEASE / 2), abs=1)
    assert all(take.lease == FIRST for take in takes[1:])
    assert {wish.lease for _, wish in hand.simulator.puts} == {FIRST}


def test_letting_go_is_a_zero_and_after_a_while_the_body_is_given_back(hand: Hand) -> None:
    hand.hold(1.0)
    hand.stick(0.0)
    assert hand.simulator.puts[-1][1].forward == 0.0
    hand.rest(IDLE - 0.2)
    assert hand.simulator.takes[-1].seconds == LEASE
    hand.rest(0.6)
    assert hand.simulator.takes[-1] == Take(agent="a", lease=FIRST, seconds=0.0)
    assert hand.simulator.puts[-1][1].forward == 0.0
    assert hand.driving.agent is None


def test_it_is_given_back_before_the_lease_is_over_by_itself(hand: Hand) -> None:
    # The last renewal is half a lease old at most when the stick is let go.
    assert IDLE + 0.5 < LEASE / 2


def test_a_lease_that_ran_out_is_taken_anew(hand: Hand) -> None:
    hand.hold(1.0)
    hand.time += LEASE  # the drawing thread was held up
    hand.stick(0.5)
    puts = len(hand.simulator.puts)
    hand.wishes.answer()
    assert hand.simulator.takes[-1].lease is None
    hand.stick(0.5)
    assert len(hand.simulator.puts) == puts + 1
    assert hand.simulator.puts[-1][1].lease != FIRST
    assert hand.wishes.told == []


def test_another_selection_lets_go_of_the_first_at_once(hand: Hand) -> None:
    hand.hold(1.0)
    hand.stick(0.5, agent="b")
    assert hand.simulator.puts[-1] == ("a", UserInput(lease=FIRST, seq=10))
    hand.wishes.answer()
    assert hand.simulator.takes[-2:] == [Take(agent="a", lease=FIRST, seconds=0.0), Take(agent="b", seconds=LEASE)]
    hand.stick(0.5, agent="b")
    assert hand.simulator.puts[-1][0] == "b"


def test_a_lease_that_comes_after_the_selection_changed_is_given_back(hand: Hand) -> None:
    hand.stick(0.5)
    hand.stick(0.0, agent=None)
    hand.wishes.answer()
    assert hand.simulator.takes == [Take(agent="a", seconds=LEASE), Take(agent="a", lease=FIRST, seconds=0.0)]
    assert hand.simulator.puts == []


def test_a_lease_asked_for_before_the_same_was_selected_again_is_not_used(hand: Hand) -> None:
    hand.hold(LEASE / 2)
    hand.stick(0.5)  # a renewal is on its way
    assert hand.wishes.open
    hand.stick(0.0, agent=None)
    hand.stick(0.5)
    hand.wishes.answer()
    hand.stick(0.5)
    hand.wishes.answer()
    hand.stick(0.5)
    assert hand.simulator.puts[-1][1].lease != FIRST  # that one was given back


def test_a_page_that_closes_stops_and_gives_back(hand: Hand) -> None:
    hand.hold(1.0)
    hand.driving.close()
    hand.wishes.answer()
    assert hand.simulator.puts[-1] == ("a", UserInput(lease=FIRST, seq=10))
    assert hand.simulator.takes[-1].seconds == 0.0
    puts = len(hand.simulator.puts)
    hand.stick(1.0)
    hand.driving.tick()
    assert len(hand.simulator.puts) == puts
    assert hand.wishes.open == []


def test_a_page_that_closes_while_it_asks_gives_back_what_it_then_gets(hand: Hand) -> None:
    hand.stick(0.5)
    hand.driving.close()
    hand.wishes.answer()
    assert hand.simulator.takes[-1] == Take(agent="a", lease=FIRST, seconds=0.0)
    assert hand.simulator.puts == []


def test_a_refusal_is_told_and_asked_again_once_a_second_not_with_each_message(hand: Hand) -> None:
    hand.simulator.refuses = "agent 'a' is taken by somebody else"
    hand.hold(5.0)
    assert hand.simulator.puts == []
    assert len(hand.simulator.takes) == pytest.approx(5.0 / AGAIN, abs=1)
    assert hand.wishes.told[0] == "Not driven: agent 'a' is taken by somebody else"
    hand.simulator.refuses = ""
    hand.hold(1.5)
    assert hand.simulator.puts


def test_nobody_is_told_that_giving_back_was_refused(hand: Hand) -> None:
    hand.hold(1.0)
    hand.simulator.refuses = "no such agent"
    hand.driving.close()
    hand.wishes.answer()
    assert hand.wishes.told == []


def test_a_goal_lets_go_of_what_was_driven_and_is_put_after_the_body_was_given_back(hand: Hand) -> None:
    hand.stick(0.5)
    hand.wishes.answer()
    hand.stick(0.5)
    hand.driving.go("b", Goal(x=1.0, y=2.0))
    assert hand.simulator.puts[-1][1].forward == 0.0
    hand.wishes.answer()
    assert [(take.agent, take.seconds) for take in hand.simulator.takes[-3:]] == [("a", 0.0), ("b", LEASE), ("b", 0.0)]
    assert hand.simulator.puts[-1] == ("b", UserInput(goal=Goal(x=1.0, y=2.0)))


def test_a_goal_that_is_refused_is_not_put(hand: Hand) -> None:
    hand.simulator.refuses = "taken by somebody else"
    hand.driving.go("a", Goal(x=1.0, y=2.0))
    hand.wishes.answer()
    assert hand.simulator.puts == []
    assert hand.wishes.told == ["No goal set: taken by somebody else"]


@pytest.mark.parametrize("bad", [(math.nan, 0.5), (0.5, math.nan), (math.inf, 0.0), (0.0, -math.inf)])
def test_what_is_no_number_is_a_release(hand: Hand, bad: tuple[float, float]) -> None:
    hand.hold(0.5)
    hand.stick(*bad)
    assert (hand.simulator.puts[-1][1].forward, hand.simulator.puts[-1][1].turn) == (0.0, 0.0)


def test_no_stick_is_pulled_farther_than_it_goes(hand: Hand) -> None:
    hand.hold(0.5)
    hand.stick(1e9, -1e9)
    assert (hand.simulator.puts[-1][1].forward, hand.simulator.puts[-1][1].turn) == (1.0, -1.0)


# ---------------------------------------------------------------- the worker


def told(simulator: Any) -> tuple[Wishes, list[tuple[str, str]]]:
    notices: list[tuple[str, str]] = []
    return Wishes(simulator, lambda what, why: notices.append((what, why))), notices


def test_wishes_are_asked_one_after_the_other_and_all_before_the_end() -> None:
    simulator = Simulator()
    wishes, notices = told(simulator)
    granted: list[Result] = []
    for wish in (Pause(), Resume(), Pause()):
        wishes.ask("Not done", "pause", wish, granted.append)
    wishes.close()
    wishes.join(10.0)
    assert [wish for _, wish in simulator.asked] == [Pause(), Resume(), Pause()]
    assert len(granted) == 3
    assert notices == []


def test_asking_does_not_wait_for_the_answer() -> None:
    simulator = Simulator()
    simulator.holds = threading.Event()
    wishes, _ = told(simulator)
    wishes.ask("Not paused", "pause", Pause())
    assert simulator.entered.wait(10.0)
    wishes.ask("Not resumed", "resume", Resume())
    assert len(simulator.asked) == 1
    simulator.holds.set()
    wishes.close()
    wishes.join(10.0)
    assert len(simulator.asked) == 2


def test_who_asked_hears_why_it_was_refused_and_then_the_user() -> None:
    simulator = Simulator()
    simulator.refuses = "overlaps a wall"
    wishes, notices = told(simulator)
    reasons: list[str] = []
    wishes.ask("Not placed", "spawn", Pause(), lambda _: reasons.append("granted"), reasons.append)
    wishes.ask(None, "spawn", Pause())
    wishes.close()
    wishes.join(10.0)
    assert reasons == ["overlaps a wall"]
    assert notices == [("Not placed", "overlaps a wall")]


def test_what_an_answer_asks_for_in_its_turn_is_still_said_after_the_close() -> None:
    simulator = Simulator()
    simulator.holds = threading.Event()
    wishes, _ = told(simulator)
    wishes.ask("Not driven", "take", Take(agent="a"), lambda _: wishes.ask(None, "take", Take(agent="a", seconds=0.0)))
    wishes.close()
    simulator.holds.set()
    wishes.join(10.0)
    assert [take.seconds for take in simulator.takes] == [2.0, 0.0]


def test_a_simulator_that_does_not_answer_holds_nobody() -> None:
    simulator = Simulator()
    simulator.holds = threading.Event()
    wishes, _ = told(simulator)
    wishes.ask("Not paused", "pause", Pause())
    assert simulator.entered.wait(10.0)
    wishes.close()
    wishes.join(0.05)
    assert wishes._worker.daemon
    simulator.holds.set()
    wishes.join(10.0)
    assert not wishes._worker.is_alive()
