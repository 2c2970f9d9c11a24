"""No field of a state or a setup is lost when a changed copy is made, not even one that is added later."""

from __future__ import annotations

import msgspec
import pytest

from intellwheels_schemas.file_records import (
    Change,
    DeleteBody,
    GoOn,
    Inputs,
    Join,
    Note,
    Restart,
    RestoreState,
    SaveState,
    Speech,
    TakeBody,
)
from intellwheels_schemas.messages import Actions, End, Timeout
from intellwheels_server.world import Setup, State, advance, apply, begin
from tests.server.worlds import RUN, box_wall, cart, floor_of, unusual_setup

OTHER_RUN = "f" * 16


class LaterState(State, frozen=True, kw_only=True):
    """The state of a later version, with one more field."""

    added: str = "default"


class LaterSetup(Setup, frozen=True, kw_only=True):
    """The setup of a later version, with one more field."""

    added: str = "default"


def later_state(added: str = "changed", setup: Setup | None = None) -> State:
    """Return a state with a body and the added field."""
    state = begin(setup or Setup(floor=floor_of()), RUN)
    state, _ = apply(state, [Join(agent="a", robot=cart())])
    fields = {name: getattr(state, name) for name in State.__struct_fields__}
    return LaterState(**fields, added=added)


def added_of(value: State | Setup) -> str:
    assert isinstance(value, LaterState | LaterSetup)
    return value.added


def test_step_keeps_every_field_that_it_does_not_set() -> None:
    state, _ = advance(later_state(), Inputs(actions={"a": Actions(left_motor=1.0, say="hello")}))
    assert (state.tick, added_of(state)) == (1, "changed")


def test_end_of_the_run_keeps_every_field_that_it_does_not_set() -> None:
    state, outputs = advance(
        later_state(setup=Setup(floor=floor_of(), end=End(timeout=Timeout(seconds=0.05)))), Inputs()
    )
    assert (outputs.ended, state.ended, added_of(state)) == (True, True, "changed")


@pytest.mark.parametrize(
    "change",
    [
        Join(agent="b", robot=cart(5.0)),
        DeleteBody(agent="a"),
        TakeBody(agent="a"),
        Speech(text="hello"),
        Note(code="paused"),
        GoOn(),
        SaveState(slot="s1"),
    ],
)
def test_change_keeps_every_field_that_it_does_not_set(change: Change) -> None:
    state, outputs = apply(later_state(), [change])
    assert outputs.outcomes[0].code == "ok"
    assert added_of(state) == "changed"


def test_restore_brings_every_field_back() -> None:
    state, _ = apply(later_state("saved"), [SaveState(slot="s1")])
    state = msgspec.structs.replace(state, added="changed")
    state, outputs = apply(state, [RestoreState(slot="s1", run=OTHER_RUN)])
    assert outputs.outcomes[0].code == "ok"
    assert (state.run, added_of(state)) == (OTHER_RUN, "saved")
    assert [added_of(saved.state) for saved in state.saved] == ["saved"]


@pytest.mark.parametrize("floor", [None, floor_of([box_wall(7.0, 7.0, 8.0, 8.0)])], ids=["reset", "load"])
def test_new_run_keeps_every_field_of_the_setup_that_it_does_not_set(floor: object) -> None:
    usual = unusual_setup()
    setup = LaterSetup(**{name: getattr(usual, name) for name in Setup.__struct_fields__}, added="changed")
    restart = Restart(run=OTHER_RUN, seed="another", map=floor, end=End(timeout=Timeout(seconds=5.0)))  # type: ignore[arg-type]
    state, outputs = apply(begin(setup, RUN), [restart])
    assert outputs.outcomes[0].code == "ok"
    changed = {name for name in LaterSetup.__struct_fields__ if getattr(state.setup, name) != getattr(setup, name)}
    assert changed == {"seed", "end"} | ({"floor"} if floor is not None else set())


def test_new_run_begins_as_a_new_world_but_for_revision_and_saved_states() -> None:
    state = later_state()
    state, _ = apply(state, [SaveState(slot="s1"), TakeBody(agent="a"), Speech(text="hello")])
    state, _ = advance(state, Inputs(actions={"a": Actions(left_motor=1.0, mode="driving", say="hello")}))
    state, _ = apply(state, [Restart(run=OTHER_RUN, seed="1", map=floor_of([box_wall(7.0, 7.0, 8.0, 8.0)]))])
    fresh = begin(state.setup, OTHER_RUN)
    arrays = {"walls", "body_set", "numbers", "flags", "samples", "episodes"}
    differs = {
        name for name in State.__struct_fields__ if name not in arrays and getattr(state, name) != getattr(fresh, name)
    }
    assert differs == {"revision", "saved", "event_count"}
    assert (state.revision, state.event_count, len(state.saved)) == (1, 1, 1)
