from __future__ import annotations

import pytest

from intellwheels_schemas.messages import Actions, Pose, Say
from intellwheels_server.tray import Tray, check_time

RUN = "0" * 16


def test_absent_run_and_tick_mean_now() -> None:
    assert check_time(None, None, RUN, 5, "Actions") is None


def test_an_older_tick_is_late_and_a_future_one_early() -> None:
    late, early = check_time(RUN, 4, RUN, 5, "Actions"), check_time(RUN, 6, RUN, 5, "Actions")
    assert late is not None
    assert (late.code, late.text, late.where) == ("late", "Actions.Tick: expected 5, got 4", "Actions.Tick")
    assert early is not None
    assert early.code == "early"


def test_another_run_is_late_whatever_its_tick() -> None:
    fault = check_time("1" * 16, 5, RUN, 5, "Pose")
    assert fault is not None
    assert (fault.code, fault.where) == ("late", "Pose.Run")


def test_the_largest_number_wins_whatever_comes_last() -> None:
    tray = Tray()
    tray.act("one", Actions(seq=2, left_motor=0.2))
    tray.act("one", Actions(seq=1, left_motor=0.1))
    assert tray.collect((), []).actions["one"].left_motor == 0.2


def test_without_numbers_the_last_wins_and_keeps_what_it_does_not_say() -> None:
    tray = Tray()
    tray.act("one", Actions(left_motor=0.2, say="hello"))
    tray.act("one", Actions(right_motor=0.1, leave=True))
    tray.act("one", Actions())
    assert tray.collect((), []).actions["one"] == Actions(left_motor=0.2, right_motor=0.1, say="hello", leave=True)


def test_the_newest_pose_wins() -> None:
    tray = Tray()
    tray.report("one", Pose(seq=2, x=2.0, y=0.0, heading=0.0))
    tray.report("one", Pose(seq=1, x=1.0, y=0.0, heading=0.0))
    assert tray.collect((), []).poses["one"].x == 2.0


@pytest.mark.parametrize("first", ["say", "actions"])
def test_a_say_beside_actions_that_speak_is_not_heard_and_told_so(first: str) -> None:
    tray = Tray()
    if first == "say":
        assert tray.say("one", Say(text="a", seq=3)) is None
        fault = tray.act("one", Actions(say="b"))
    else:
        assert tray.act("one", Actions(say="b")) is None
        fault = tray.say("one", Say(text="a", seq=3))
    assert fault is not None
    assert (fault.code, fault.where, fault.seq) == ("too-many", "Say", 3)
    inputs = tray.collect((), [])
    assert (inputs.says, inputs.actions["one"].say) == ((), "b")


def test_a_say_beside_actions_that_do_not_speak_is_heard() -> None:
    tray = Tray()
    assert tray.say("one", Say(text="a")) is None
    assert tray.act("one", Actions(left_motor=0.1)) is None
    assert [said.text for said in tray.collect((), []).says] == ["a"]


def test_one_say_a_tick() -> None:
    tray = Tray()
    assert tray.say("one", Say(text="a")) is None
    fault = tray.say("one", Say(text="b", seq=3))
    assert fault is not None
    assert (fault.code, fault.seq) == ("too-many", 3)
    assert [said.text for said in tray.collect((), []).says] == ["a"]
    assert tray.say("one", Say(text="c")) is None


def test_what_is_collected_is_sorted_by_name_and_gone() -> None:
    tray = Tray()
    for agent in ("b", "c", "a"):
        tray.act(agent, Actions())
    assert list(tray.collect((), []).actions) == ["a", "b", "c"]
    assert tray.collect((), []).actions == {}
