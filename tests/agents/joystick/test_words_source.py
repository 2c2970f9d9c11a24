"""Words drive for so long only, and all of them are passed on."""

from __future__ import annotations

import os
from itertools import groupby

import pytest

from intellwheels_agents.joystick.wish import NOTHING, Wish
from intellwheels_agents.joystick.words_source import LONGEST, WAITING, Spoken, WordsSource


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
        assert source.wish(1.2, None) == Wish(word="go")
        assert source.wish(1.6, None) is None
    finally:
        os.close(reading)
        if writing >= 0:
            os.close(writing)


def test_words_that_come_at_once_are_put_one_after_the_other_and_none_is_lost() -> None:
    said = spoken()
    for word in ("forward", "horn", "lights", "horn"):
        said.hear(word, 10.0)
    times = [10.0 + 0.05 * k for k in range(40)]
    words = [said.wish(time).word for time in times]
    assert [word for word, _ in groupby(words)] == ["forward", "horn", "lights", "horn", None]
    assert all(len(list(group)) >= 5 for _, group in groupby(words))
    assert said.wish(11.5).forward == 0.5


def test_a_word_that_drives_goes_before_those_that_wait_and_one_it_replaced_is_not_put() -> None:
    said = spoken()
    for word in ("forward", "kitchen", "stop"):
        said.hear(word, 10.0)
    wishes = [said.wish(10.0 + 0.05 * k) for k in range(20)]
    assert [word for word, _ in groupby(wish.word for wish in wishes)] == ["stop", "kitchen", None]
    assert all(wish.forward == wish.turn == 0.0 for wish in wishes)


def test_who_says_more_than_can_be_put_is_heard_with_the_last_of_it() -> None:
    said = spoken()
    for number in range(WAITING + 5):
        said.hear(f"w{number}", 10.0)
    assert said.wish(10.0).word == "w5"


def test_the_last_words_are_put_after_the_input_ended_but_drive_no_more() -> None:
    reading, writing = os.pipe()
    source = WordsSource(spoken(), reading)
    try:
        os.write(writing, b"forward horn")
        os.close(writing)
        source.wait(5.0)
        assert source.wish(1.0, None) == NOTHING
        source.wait(5.0)
        assert [source.wish(1.0 + 0.1 * k, None) for k in range(1, 4)] == [Wish(word="horn")] * 3
        assert source.wish(1.5, None) is None
    finally:
        os.close(reading)
