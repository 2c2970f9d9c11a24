"""Words drive for a limited time, and all of them are sent on."""

from __future__ import annotations

import os
from itertools import groupby

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.words_source import MAX_LINE, QUEUE_LENGTH, SpokenWords, WordsSource


def spoken() -> SpokenWords:
    return SpokenWords(forward=0.5, turn=0.25, hold=2.0)


@pytest.mark.parametrize(
    ("word", "forward", "turn"),
    [("forward", 0.5, 0.0), ("back", -0.5, 0.0), ("left", 0.0, 0.25), ("right", 0.0, -0.25), ("FORWARD", 0.5, 0.0)],
)
def test_a_word_drives_for_its_hold_time_only(word: str, forward: float, turn: float) -> None:
    said = spoken()
    said.add(word, 10.0)
    assert said.state(10.0) == said.state(11.99) == InputState(forward, turn, word=word.lower())
    assert said.state(12.0) == NEUTRAL


def test_stop_stops_at_once() -> None:
    said = spoken()
    said.add("forward", 10.0)
    said.add("stop", 10.5)
    assert said.state(10.5) == InputState(word="stop")
    assert said.state(11.0) == NEUTRAL


def test_a_word_that_does_not_drive_is_sent_and_the_chair_drives_on() -> None:
    said = spoken()
    said.add("forward", 10.0)
    said.add("kitchen", 10.5)
    assert said.state(10.5) == InputState(0.5, word="kitchen")
    assert said.state(11.0) == InputState(0.5)
    assert said.state(12.0) == NEUTRAL


@pytest.mark.parametrize("word", ["<b>", "ä", "a" * 65, "\x00"])
def test_a_word_outside_the_contract_is_dropped(word: str) -> None:
    said = spoken()
    said.add(word, 1.0)
    assert said.state(1.0) == NEUTRAL


def test_words_are_read_as_they_come_and_the_source_ends_with_its_input() -> None:
    reading, writing = os.pipe()
    source = WordsSource(spoken(), reading)
    try:
        assert source.state(1.0, None) == NEUTRAL
        source.wait(0.0)
        os.write(writing, b"go for")
        source.wait(5.0)
        assert source.state(1.0, None) == NEUTRAL
        os.write(writing, b"ward\nkitchen")
        source.wait(5.0)
        assert source.state(1.0, None) == InputState(0.5, word="forward")
        os.write(writing, b"x" * MAX_LINE)
        source.wait(5.0)
        os.write(writing, b"\nstop\n")
        source.wait(5.0)
        assert source.state(1.1, None) == InputState(word="stop")
        os.close(writing)
        writing = -1
        source.wait(5.0)
        assert source.state(1.2, None) == InputState(word="go")
        assert source.state(1.6, None) is None
    finally:
        os.close(reading)
        if writing >= 0:
            os.close(writing)


def test_words_that_come_together_are_sent_one_after_the_other() -> None:
    said = spoken()
    for word in ("forward", "horn", "lights", "horn"):
        said.add(word, 10.0)
    times = [10.0 + 0.05 * k for k in range(40)]
    words = [said.state(time).word for time in times]
    assert [word for word, _ in groupby(words)] == ["forward", "horn", "lights", "horn", None]
    assert all(len(list(group)) >= 5 for _, group in groupby(words))
    assert said.state(11.5).forward == 0.5


def test_a_driving_word_goes_first_and_replaces_the_one_before() -> None:
    said = spoken()
    for word in ("forward", "kitchen", "stop"):
        said.add(word, 10.0)
    states = [said.state(10.0 + 0.05 * k) for k in range(20)]
    assert [word for word, _ in groupby(state.word for state in states)] == ["stop", "kitchen", None]
    assert all(state.forward == state.turn == 0.0 for state in states)


def test_of_too_many_words_the_oldest_are_dropped() -> None:
    said = spoken()
    for number in range(QUEUE_LENGTH + 5):
        said.add(f"w{number}", 10.0)
    assert said.state(10.0).word == "w5"


def test_waiting_words_are_sent_after_the_end_but_drive_no_more() -> None:
    reading, writing = os.pipe()
    source = WordsSource(spoken(), reading)
    try:
        os.write(writing, b"forward horn")
        os.close(writing)
        source.wait(5.0)
        assert source.state(1.0, None) == NEUTRAL
        source.wait(5.0)
        assert [source.state(1.0 + 0.1 * k, None) for k in range(1, 4)] == [InputState(word="horn")] * 3
        assert source.state(1.5, None) is None
    finally:
        os.close(reading)


def test_a_word_whose_share_is_0_drives_nothing_by_itself_either() -> None:
    words = SpokenWords(0.0, 0.5, 2.0)
    words.add("left", 0.0)
    assert words.state(0.1) == InputState(0.0, 0.5, word="left")
    words.add("forward", 0.2)
    assert words.state(0.3) == InputState()
    words.add("stop", 0.4)
    assert words.state(0.5) == InputState(word="stop")
