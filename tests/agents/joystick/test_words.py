"""Words drive for so long only, and all of them are passed on."""

from __future__ import annotations

import os

import pytest

from intellwheels_agents.joystick.wish import NOTHING, Wish
from intellwheels_agents.joystick.words import LONGEST, Spoken, WordsSource


def spoken() -> Spoken:
    return Spoken(forward=0.5, turn=0.25, hold=2.0)


@pytest.mark.parametrize(
    ("word", "forward", "turn"),
    [("forward", 0.5, 0.0), ("back", -0.5, 0.0), ("left", 0.0, 0.25), ("right", 0.0, -0.25), ("FORWARD", 0.5, 0.0)],
)
def test_a_word_drives_and_no_longer_than_it_is_held(word: str, forward: float, turn: float) -> None:
    said = spoken()
    said.hear(word, 10.0)
    assert said.wish(10.0) == said.wish(11.99) == Wish(forward, turn, word=word.lower())
    assert said.wish(12.0) == NOTHING


def test_stop_stops_at_once() -> None:
    said = spoken()
    said.hear("forward", 10.0)
    said.hear("stop", 10.5)
    assert said.wish(10.5) == Wish(word="stop")
    assert said.wish(11.0) == NOTHING


def test_another_word_is_passed_on_for_a_moment_and_the_chair_drives_on() -> None:
    said = spoken()
    said.hear("forward", 10.0)
    said.hear("kitchen", 10.5)
    assert said.wish(10.5) == Wish(0.5, word="kitchen")
    assert said.wish(11.0) == Wish(0.5)
    assert said.wish(12.0) == NOTHING


@pytest.mark.parametrize("word", ["<b>", "ä", "a" * 65, "\x00"])
def test_what_the_wire_would_not_take_is_dropped(word: str) -> None:
    said = spoken()
    said.hear(word, 1.0)
    assert said.wish(1.0) == NOTHING


def test_words_are_read_as_they_come_and_the_end_of_the_input_ends_it() -> None:
    reading, writing = os.pipe()
    source = WordsSource(spoken(), reading)
    try:
        assert source.wish(1.0, None) == NOTHING
        source.wait(0.0)
        os.write(writing, b"go for")
        source.wait(5.0)
        assert source.wish(1.0, None) == NOTHING
        os.write(writing, b"ward\nkitchen")
        source.wait(5.0)
        assert source.wish(1.0, None) == Wish(0.5, word="forward")
        os.write(writing, b"x" * LONGEST)
        source.wait(5.0)
        os.write(writing, b"\nstop\n")
        source.wait(5.0)
        assert source.wish(1.1, None) == Wish(word="stop")
        os.close(writing)
        writing = -1
        source.wait(5.0)
        assert source.wish(1.2, None) is None
    finally:
        os.close(reading)
        if writing >= 0:
            os.close(writing)
