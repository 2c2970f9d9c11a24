from __future__ import annotations

import msgspec
import numpy as np

from intellwheels_schemas.messages import Position
from intellwheels_server.world import digest
from intellwheels_server.world.body_set import body_model_of
from intellwheels_server.world.draft import Draft
from intellwheels_server.world.kernels.rows import SPEED, X
from tests.server.worlds import cart, run, world


def test_draft_without_changes_is_the_state() -> None:
    state, _ = run(world({"a": cart(), "b": cart(3.0)}), 5, {"a": (1.0, 0.5)})
    assert digest(Draft(state).finish()) == digest(state)


def test_bodies_are_sorted_by_name_whatever_the_order_of_arrival() -> None:
    draft = Draft(world({"b": cart(3.0)}))
    for name, x in (("c", 6.0), ("a", 0.0)):
        draft.put(name, body_model_of(name, cart(), draft.state.setup), Position(x=x, y=0.0, heading=0.0))
    state = draft.finish()
    assert state.names == ("a", "b", "c")
    assert state.numbers[X].tolist() == [0.0, 3.0, 6.0]


def test_body_is_put_at_rest() -> None:
    state, _ = run(world({"a": cart()}), 10, {"a": (1.0, 1.0)})
    assert state.numbers[SPEED, 0] > 0.0
    draft = Draft(state)
    draft.put("a", draft.models["a"], Position(x=1.0, y=0.0, heading=0.0))
    assert draft.finish().numbers[SPEED, 0] == 0.0


def test_removed_body_leaves_nothing_and_its_space_is_free() -> None:
    state = world({"a": cart(), "b": cart(3.0)})
    draft = Draft(msgspec.structs.replace(state, statuses={"a": object()}))
    model = draft.models["a"]
    assert draft.space.overlap_at(model, Position(x=3.0, y=0.0, heading=0.0)) == "agent 'b'"
    draft.remove("b")
    assert draft.space.overlap_at(model, Position(x=3.0, y=0.0, heading=0.0)) is None
    draft.remove("a")
    state = draft.finish()
    assert (state.names, state.statuses) == ((), {})


def test_events_are_numbered_on_from_the_state() -> None:
    draft = Draft(world({"a": cart()}))
    first = draft.state.event_count
    draft.event("paused")
    draft.event("speed", speed=2.0)
    assert [(event.code, event.number) for event in draft.events] == [("paused", first), ("speed", first + 1)]
    assert draft.finish().event_count == first + 2


def test_draft_leaves_the_state_alone() -> None:
    state = world({"a": cart()})
    before = state.numbers.copy()
    draft = Draft(state)
    draft.numbers["a"][X] = 5.0
    draft.finish()
    assert np.array_equal(state.numbers, before)
