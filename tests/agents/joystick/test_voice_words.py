"""Synthesized words are recognised, in several voices; other words, talk and noise do not drive."""

from __future__ import annotations

import random
import sys
from array import array

import pytest

from intellwheels_agents.joystick.pygame_source import DeviceError
from intellwheels_agents.joystick.voice_words import MAX_SPEECH, Spoken, WordRecogniser
from tests.agents.joystick.spoken import COMMANDS, OTHERS, RATE, VOICES, said

pytest.importorskip("pocketsphinx", reason="words need the extra `voice`")

MEANINGS = {**dict(zip(COMMANDS, COMMANDS, strict=True)), "reverse": "back"}


@pytest.fixture
def recogniser() -> WordRecogniser:
    return WordRecogniser(RATE)


def heard(recogniser: WordRecogniser, sound: bytes, piece: int = 1000) -> list[Spoken]:
    return [
        word
        for begin in range(0, len(sound), piece)
        for word in recogniser.feed(sound[begin : begin + piece])
    ] + recogniser.end()  # fmt: skip


@pytest.mark.parametrize("voice", VOICES)
def test_every_word_is_recognised(recogniser: WordRecogniser, voice: tuple[str, int, int]) -> None:
    for word, meaning in MEANINGS.items():
        assert [spoken.word for spoken in heard(recogniser, said(word, voice))] == [meaning]


def test_a_word_is_known_a_third_of_a_second_after_its_end_and_stop_before(recogniser: WordRecogniser) -> None:
    # Sound in pieces of odd sizes is the same sound.
    (forward,) = heard(recogniser, said("forward"), piece=777)
    assert 0.1 < forward.age < 0.4
    (stop,) = heard(recogniser, said("stop"))
    assert stop.age == 0.0


def test_the_age_of_a_word_counts_the_sound_that_came_with_it(recogniser: WordRecogniser) -> None:
    (forward,) = recogniser.feed(said("forward").rstrip(b"\0") + bytes(2 * 2 * RATE))
    assert forward.age == pytest.approx(2.0, abs=0.2)


def test_other_words_do_not_drive(recogniser: WordRecogniser) -> None:
    for word in OTHERS:
        assert {spoken.word for spoken in heard(recogniser, said(word))} <= {"stop"}


def test_noise_and_silence_are_no_words(recogniser: WordRecogniser) -> None:
    noise = random.Random(1)
    loud = array("h", [int(noise.gauss(0.0, 3000.0)) for _ in range(2 * RATE)]).tobytes()
    assert heard(recogniser, loud + bytes(2 * RATE)) == []


def test_speech_without_a_pause_gives_nothing_but_stop(recogniser: WordRecogniser) -> None:
    word = said("forward").strip(b"\0")
    word += b"\0" * (len(word) % 2)
    sound = bytes(RATE) + word * (int(2.0 * MAX_SPEECH * 2 * RATE / len(word)) + 1) + bytes(RATE)
    assert {spoken.word for spoken in heard(recogniser, sound)} <= {"stop"}


@pytest.mark.parametrize("rate", [8000, 96000])
def test_a_rate_that_the_model_lacks_is_refused(rate: int) -> None:
    with pytest.raises(DeviceError, match=f"expected 16000 to 48000 samples a second, got {rate}"):
        WordRecogniser(rate)


def test_without_the_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pocketsphinx", None)
    with pytest.raises(DeviceError, match=r"pip install '\.\[voice\]'"):
        WordRecogniser(RATE)
