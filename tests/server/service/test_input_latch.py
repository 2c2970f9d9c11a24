from __future__ import annotations

import pytest

from intellwheels_schemas.messages import Actions, Pose, Say
from intellwheels_server.service.input_latch import InputLatch, check_time

RUN = "0" * 16


def test_missing_run_and_tick_mean_the_current_ones() -> None:
    assert check_time(None, None, RUN, 5, "Actions") is None


def test_older_tick_is_late_and_future_tick_is_early() -> None:
    late, early = check_time(RUN, 4, RUN, 5, "Actions"), check_time(RUN, 6, RUN, 5, "Actions")
    assert late is not None
    assert (late.code, late.text, late.where) == ("late", "Actions.Tick: expected 5, got 4", "Actions.Tick")
    assert early is not None
    assert early.code == "early"


def test_another_run_is_late_whatever_the_tick() -> None:
    fault = check_time("1" * 16, 5, RUN, 5, "Pose")
    assert fault is not None
    assert (fault.code, fault.where) == ("late", "Pose.Run")


def test_largest_sequence_number_wins_in_any_order() -> None:
    latch = InputLatch()
    latch.act("one", Actions(seq=2, left_motor=0.2))
    latch.act("one", Actions(seq=1, left_motor=0.1))
    assert latch.collect((), []).actions["one"].left_motor == 0.2


def test_without_numbers_the_last_wins_and_keeps_fields_it_leaves_out() -> None:
    latch = InputLatch()
    latch.act("one", Actions(left_motor=0.2, say="hello"))
    latch.act("one", Actions(right_motor=0.1, leave=True))
    latch.act("one", Actions())
    assert latch.collect((), []).actions["one"] == Actions(left_motor=0.2, right_motor=0.1, say="hello", leave=True)


def test_newest_pose_wins() -> None:
    latch = InputLatch()
    latch.set_pose("one", Pose(seq=2, x=2.0, y=0.0, heading=0.0))
    latch.set_pose("one", Pose(seq=1, x=1.0, y=0.0, heading=0.0))
    assert latch.collect((), []).poses["one"].x == 2.0


@pytest.mark.parametrize("first", ["say", "actions"])
def test_say_beside_actions_with_a_say_is_refused(first: str) -> None:
    latch = InputLatch()
    if first == "say":
        assert latch.say("one", Say(text="a", seq=3)) is None
        fault = latch.act("one", Actions(say="b"))
    else:
        assert latch.act("one", Actions(say="b")) is None
        fault = latch.say("one", Say(text="a", seq=3))
    assert fault is not None
    assert (fault.code, fault.where, fault.seq) == ("too-many", "Say", 3)
    inputs = latch.collect((), [])
    assert (inputs.says, inputs.actions["one"].say) == ((), "b")


def test_say_beside_actions_without_a_say_is_kept() -> None:
    latch = InputLatch()
    assert latch.say("one", Say(text="a")) is None
    assert latch.act("one", Actions(left_motor=0.1)) is None
    assert [said.text for said in latch.collect((), []).says] == ["a"]


def test_only_one_say_per_tick_is_kept() -> None:
    latch = InputLatch()
    assert latch.say("one", Say(text="a")) is None
    fault = latch.say("one", Say(text="b", seq=3))
    assert fault is not None
    assert (fault.code, fault.seq) == ("too-many", 3)
    assert [said.text for said in latch.collect((), []).says] == ["a"]
    assert latch.say("one", Say(text="c")) is None


def test_collected_inputs_are_sorted_by_name_and_removed() -> None:
    latch = InputLatch()
    for agent in ("b", "c", "a"):
        latch.act(agent, Actions())
    assert list(latch.collect((), []).actions) == ["a", "b", "c"]
    assert latch.collect((), []).actions == {}
