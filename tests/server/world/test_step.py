"""One step: times that are whole numbers of steps, and what a step tells of itself."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from intellwheels_maps import robot
from intellwheels_schemas.file_records import Inputs, TakeBody
from intellwheels_schemas.messages import Actions, End, Position, Timeout, UserInput
from intellwheels_server.world import measures
from intellwheels_server.world.kernels.rows import LEFT_POWER, RIGHT_POWER, SPEED
from intellwheels_server.world.step import USER_SILENCE, staleness, step, steps_in
from tests.every_case import every_case
from tests.server.worlds import cart, do, floor_of, run, world

README = Path(__file__).parents[3] / "README.md"


@pytest.mark.parametrize(
    ("seconds", "period", "steps"),
    [(0.0, 0.05, 0), (0.05, 0.05, 1), (0.3, 0.1, 3), (0.31, 0.1, 4), (0.3, 0.05, 6), (1.0, 0.3, 4)],
)
def test_a_time_is_over_after_whole_steps(seconds: float, period: float, steps: int) -> None:
    assert steps_in(seconds, period) == steps


@pytest.mark.parametrize(("period", "seconds"), [(0.01, 0.3), (0.1, 0.3), (0.2, 0.6), (1.0, 3.0)])
def test_a_real_body_is_stale_after_three_periods_and_never_before_0_3_s(period: float, seconds: float) -> None:
    assert staleness(period) == pytest.approx(seconds)


def test_a_step_is_one_tick_and_leaves_the_state_before_alone() -> None:
    state = world({"a": cart()})
    after, events, ended = step(state, Inputs(actions={"a": Actions(left_motor=1.0, right_motor=1.0)}))
    assert (state.tick, after.tick, events, ended) == (0, 1, (), False)
    assert float(state.numbers[SPEED, 0]) == 0.0
    assert float(after.numbers[SPEED, 0]) == pytest.approx(1.0)


def test_a_command_that_is_not_renewed_counts_no_longer_and_that_is_an_event() -> None:
    state = world({"a": cart()}, command_timeout=0.2)
    state, _ = run(state, 1, {"a": (1.0, 1.0)})
    state, events = run(state, 6)
    assert [(event.code, event.agent) for event in events] == [("timeout", "a")]
    assert float(state.numbers[SPEED, 0]) == 0.0


def test_in_simulated_time_a_user_who_says_nothing_for_0_3_s_lets_go() -> None:
    state = world({"a": cart(user_input=("drive",))}, strict=True)
    state, _, _ = do(state, TakeBody(agent="a"))
    state, _ = run(state, 1, inputs=Inputs(user_input={"a": UserInput(forward=1.0)}))
    state, _ = run(state, steps_in(USER_SILENCE, 0.05) - 1)
    assert state.user["a"].forward == 1.0
    state, _ = run(state, 2)
    assert state.user["a"].forward == 0.0


def test_the_last_step_ends_the_run_with_an_event_that_carries_its_hash() -> None:
    state = world({"a": cart()}, floor=floor_of(), end=End(timeout=Timeout(seconds=0.1)))
    state, events, ended = step(state, Inputs())
    assert (events, ended, state.ended) == ((), False, False)
    count = state.event_count
    state, (event,), ended = step(state, Inputs())
    assert (ended, state.ended, event.code, event.tick, state.event_count) == (True, True, "ended", 2, count + 1)
    assert event.text is not None
    assert ", hash " in event.text


def test_a_run_whose_end_is_waived_goes_on() -> None:
    state = world({"a": cart()}, end=End(timeout=Timeout(seconds=0.1)))
    state = msgspec.structs.replace(state, end_waived=True)
    state, events = run(state, 5)
    assert (state.tick, state.ended, events) == (5, False, [])


CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels", "corridor-chair")
NO_POWER, STANDS = 0.4, 1.1
"""README promises these times after the last input of a user, s."""


@every_case("taken", [True, False], ids=["taken", "mind"])
@every_case("name", CHAIRS)
def test_chair_that_has_lost_its_user_stands_when_readme_says(name: str, taken: bool) -> None:
    chair = msgspec.structs.replace(robot(name), position=Position(x=0.0, y=0.0, heading=0.0), user_input=("drive",))
    state = world({"a": chair}, strict=True)
    if taken:
        state, _, _ = do(state, TakeBody(agent="a", on=True))
    wish = UserInput(forward=1.0, turn=0.0)
    last, powerless, standing = 60, None, None
    while standing is None and state.tick < 1000:
        heard = measures(state, "a").user_input
        forward = heard.forward if heard is not None else 0.0
        told = {} if taken else {"a": Actions(left_motor=forward, right_motor=forward)}
        state, _, _ = step(state, Inputs(actions=told, user_input={"a": wish} if state.tick <= last else {}))
        if state.tick == last:
            assert float(state.numbers[SPEED, 0]) > 0.8
        if state.tick > last + 1:
            if powerless is None and state.numbers[LEFT_POWER, 0] == state.numbers[RIGHT_POWER, 0] == 0.0:
                powerless = state.tick - 1 - last
            if abs(float(state.numbers[SPEED, 0])) < 0.01:
                standing = state.tick - last
    period = state.setup.period
    assert powerless is not None
    assert standing is not None
    assert 0.3 <= powerless * period <= NO_POWER
    assert standing * period <= STANDS
    words = " ".join(README.read_text(encoding="utf-8").split())
    assert f"lose power within {NO_POWER:g} s" in words
    assert f"at rest within {STANDS:g} s" in words
