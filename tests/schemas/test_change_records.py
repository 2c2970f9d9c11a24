"""What goes into the world is what comes back from the input log."""

from __future__ import annotations

from typing import get_args

import msgspec
import pytest

from intellwheels_schemas.file_records import (
    Change,
    DeleteBody,
    Depart,
    GoOn,
    Inputs,
    Join,
    Note,
    Restart,
    RestoreState,
    Said,
    SaveState,
    SpawnBody,
    Speech,
    TakeBody,
    TeleportBody,
    Verdict,
)
from intellwheels_schemas.messages import Actions, Pose, Position, UserInput
from tests.every_case import every_case
from tests.server.worlds import RUN, cart

CHANGES: tuple[Change, ...] = (
    Join(agent="a", robot=cart()),
    Depart(agent="a", role="mind", lost=True),
    SpawnBody(robot=cart(), position=Position(x=1.0, y=2.0, heading=0.0)),
    DeleteBody(agent="a"),
    TeleportBody(agent="a", position=Position(x=1.0, y=2.0, heading=0.0), force=True),
    TakeBody(agent="a", on=False),
    Speech(text="stop", to="a"),
    Note(code="speed", speed=2.0),
    Restart(run=RUN, seed="2"),
    SaveState(slot="before"),
    RestoreState(slot="before", run=RUN),
    GoOn(),
)


def again(inputs: Inputs) -> Inputs:
    return msgspec.json.decode(msgspec.json.encode(inputs), type=Inputs)


def test_every_change_is_tried_here() -> None:
    assert {type(change) for change in CHANGES} == set(get_args(Change))


@every_case("change", CHANGES, ids=[type(change).__name__ for change in CHANGES])
def test_a_change_is_the_same_after_the_log(change: Change) -> None:
    assert again(Inputs(changes=(change,))).changes == (change,)


def test_the_order_of_changes_is_kept() -> None:
    assert again(Inputs(changes=CHANGES)).changes == CHANGES


def test_what_acts_on_a_step_is_the_same_after_the_log() -> None:
    inputs = Inputs(
        actions={"a": Actions(left_motor=0.1, right_motor=1 / 3)},
        says=(Said(agent="a", text="<&>", seq=7),),
        poses={"b": Pose(x=0.1, y=0.2, heading=0.3)},
        user_input={"a": UserInput(forward=0.1)},
        verdicts=(Verdict(agent="a", code="late"),),
    )
    assert again(inputs) == inputs


def test_a_step_on_which_nothing_acts_takes_two_bytes() -> None:
    assert msgspec.json.encode(Inputs()) == b"{}"


def test_a_change_that_nobody_knows_is_refused() -> None:
    with pytest.raises(msgspec.ValidationError, match="Invalid value 'Explode'"):
        msgspec.json.decode(b'{"Changes":[{"Do":"Explode"}]}', type=Inputs)
