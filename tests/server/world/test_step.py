"""One step: times that are whole numbers of steps, and what a step tells of itself."""

from __future__ import annotations

import msgspec
import pytest

from intellwheels_schemas.file_records import Inputs, TakeBody
from intellwheels_schemas.messages import Actions, End, Timeout, UserInput
from intellwheels_server.world.kernels.rows import SPEED
from intellwheels_server.world.step import USER_SILENCE, staleness, step, steps_in
from tests.server.worlds import cart, do, floor_of, run, world


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
