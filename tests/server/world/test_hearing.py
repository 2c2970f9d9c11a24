"""Who hears what is said: range, walls and closed doors, loss and delay."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_schemas.file_records import Depart, Inputs, Restart, Speech
from intellwheels_schemas.messages import Actions
from intellwheels_server.world import State, advance, measures
from tests.server.worlds import RUN, box_wall, cart, do, run, world


def _say(state: State, *agents: str) -> State:
    actions = {agent: Actions(say=f"{agent} at {state.tick}") for agent in agents}
    return advance(state, Inputs(actions=actions))[0]


def _hears(state: State, agent: str) -> list[str]:
    return [words.text for words in measures(state, agent).message]


def test_say_is_heard_within_its_range_with_its_distance() -> None:
    state = _say(world({"a": cart(), "b": cart(8.0), "c": cart(8.1, 2.0)}), "a")
    (heard,) = measures(state, "b").message
    assert (heard.sender, heard.tick, heard.distance, heard.text) == ("a", 0, 8.0, "a at 0")
    assert _hears(state, "c") == []
    assert _hears(state, "a") == []


@pytest.mark.parametrize(("top", "kept"), [(2.5, True), (1.1, False)])
def test_wall_as_high_as_a_mouth_stops_speech(*, top: float, kept: bool) -> None:
    wall = box_wall(1.9, -1.0, 2.1, 1.0)
    wall = type(wall)(height=top, corner=wall.corner)
    robots = {"a": cart(), "b": cart(4.0), "c": cart(4.0, 4.0)}
    for walls in (False, True):
        state = _say(world(robots, [wall], say_walls=walls), "a")
        assert _hears(state, "b") == ([] if walls and kept else ["a at 0"])
        assert _hears(state, "c") == ["a at 0"]


def _leaf(heading: float) -> Any:
    return cart(2.0, -0.5, heading, kind="door", length=1.2, width=0.1, center=0.0, top=2.0)


def test_closed_door_stops_speech_and_an_open_one_does_not() -> None:
    for heading, hears in ((math.pi / 2, []), (-math.pi / 2, ["a at 0"])):
        robots = {"a": cart(), "b": cart(4.0), "door": _leaf(heading)}
        state = _say(world(robots, say_walls=True), "a")
        assert _hears(state, "b") == hears
        assert _hears(state, "door") == ["a at 0"]


def test_door_itself_is_heard_and_other_bodies_do_not_stop_speech() -> None:
    robots = {"a": cart(), "b": cart(4.0), "door": _leaf(math.pi / 2), "person": cart(1.2, kind="person")}
    state = _say(world(robots, say_walls=True), "door")
    assert _hears(state, "a") == _hears(state, "b") == ["door at 0"]


def test_say_is_late_by_the_delay_in_whole_ticks() -> None:
    robots = {"a": cart(), "b": cart(4.0)}
    for delay, late in ((0.0, 0), (0.05, 1), (0.12, 3)):
        state = world(robots, say_delay=delay)
        state = _say(state, "a")
        state = _say(state, "a")
        found = [_hears(state, "b")]
        for _ in range(4):
            state, _ = run(state, 1)
            found.append(_hears(state, "b"))
        expected = [[f"a at {tick - late}"] if tick - late in {0, 1} else [] for tick in range(1, 6)]
        assert found == expected


def test_agent_that_left_is_still_heard_until_a_reset() -> None:
    state = _say(world({"a": cart(), "b": cart(4.0)}, say_delay=0.1, say_walls=True), "a")
    state, _, _ = do(state, Depart(agent="a"))
    late, _ = run(state, 2)
    assert [(words.sender, words.distance) for words in measures(late, "b").message] == [("a", 4.0)]
    state, _, _ = do(state, Restart(run=RUN, seed="1"))
    for _ in range(4):
        assert _hears(state, "b") == []
        state, _ = run(state, 1)


def test_operator_is_heard_at_once_through_everything() -> None:
    walls = [box_wall(1.9, -9.0, 2.1, 9.0)]
    state = world({"a": cart(), "b": cart(40.0)}, walls, say_delay=1.0, say_loss=1.0, say_walls=True)
    state, _, _ = do(state, Speech(text="stop"))
    state, _ = run(state, 1)
    assert _hears(state, "a") == _hears(state, "b") == ["stop"]


def _missed(loss: float, seed: str, robots: dict[str, Any]) -> list[bool]:
    state = world(robots, say_loss=loss, seed=seed)
    found = []
    for _ in range(300):
        state = _say(state, "a")
        found.append(not _hears(state, "b"))
    return found


def test_missed_messages_follow_from_the_seed_whoever_else_is_there() -> None:
    pair = {"a": cart(), "b": cart(4.0)}
    missed = _missed(0.3, "1", pair)
    assert sum(missed) == pytest.approx(90, abs=32)  # four standard deviations
    assert missed == _missed(0.3, "1", {**pair, "c": cart(0.0, 4.0)})
    assert missed != _missed(0.3, "2", pair)
    assert not any(_missed(0.0, "1", pair))
    assert all(_missed(1.0, "1", pair))


def test_listeners_miss_messages_independently() -> None:
    state = world({"a": cart(), "b": cart(4.0), "c": cart(0.0, 4.0)}, say_loss=0.5)
    alike = 0
    for _ in range(200):
        state = _say(state, "a")
        alike += bool(_hears(state, "b")) == bool(_hears(state, "c"))
    assert alike == pytest.approx(100, abs=29)  # four standard deviations
