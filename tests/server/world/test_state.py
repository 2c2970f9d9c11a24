"""A state is plain data that nobody changes: names in the order of the columns, simulated time from the tick."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from intellwheels_schemas.messages import Actions
from intellwheels_server.world import advance, digest
from intellwheels_server.world.inputs import Inputs
from intellwheels_server.world.state import State, no_episodes
from tests.server.worlds import cart, run, world


def test_columns_are_in_the_order_of_the_names_whoever_came_first() -> None:
    state = world({"b": cart(3.0), "a": cart()})
    assert state.names == ("a", "b")
    assert state.numbers.shape[1] == state.flags.shape[1] == 2


def test_time_is_the_tick_times_the_period() -> None:
    state, _ = run(world(period=0.02), 5)
    assert state.tick == 5
    assert state.time == pytest.approx(0.1)


def test_a_state_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        world().tick = 1  # type: ignore[misc]


def test_a_world_in_which_nothing_touches_has_no_episodes() -> None:
    assert no_episodes().shape == (0, 3)
    assert no_episodes().dtype == np.int64
    assert world({"a": cart()}).episodes.shape == (0, 3)


def test_run_and_saved_states_are_no_part_of_the_hash() -> None:
    state = world({"a": cart()})
    assert digest(msgspec.structs.replace(state, run="f" * 16)) == digest(state)


def test_a_step_carries_over_what_it_does_not_make() -> None:
    def same(one: State, other: State) -> list[str]:
        return [name for name in State.__struct_fields__ if getattr(one, name) is getattr(other, name)]

    state = msgspec.structs.replace(world({"a": cart()}), revision=3, end_waived=True)
    after, _ = advance(state, Inputs(actions={"a": Actions(left_motor=0.5, right_motor=0.5)}))
    assert {"run", "setup", "walls", "fleet", "revision", "end_waived", "kept"} <= set(same(state, after))
