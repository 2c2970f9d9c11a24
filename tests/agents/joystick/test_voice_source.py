"""What words of a recogniser do, and what silence of the sound does. The recogniser is a stand-in."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.voice_source import VoiceSource
from intellwheels_agents.joystick.voice_words import Spoken
from intellwheels_agents.joystick.words_source import SpokenWords


class Listening:
    """A recogniser whose sound is its words, and an input that gives what the test puts in."""

    rate = 16000
    age = 0.25

    def __init__(self) -> None:
        self.pieces: list[bytes | None] = []

    def read(self, seconds: float) -> bytes | None:
        return self.pieces.pop(0) if self.pieces else b""

    def feed(self, data: bytes) -> list[Spoken]:
        return [Spoken(word, self.age) for word in data.decode().split()]

    def end(self) -> list[Spoken]:
        return []


@pytest.fixture
def now(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    clock = [100.0]
    monkeypatch.setattr(
        f"{VoiceSource.__module__}.time", SimpleNamespace(monotonic=lambda: clock[0], sleep=lambda _: 0)
    )
    return clock


def source(listening: Listening) -> VoiceSource:
    return VoiceSource(listening, listening, SpokenWords(0.5, 0.25, 2.0))


def hears(
    made: VoiceSource, listening: Listening, now: list[float], piece: bytes | None, after: float
) -> InputState | None:
    now[0] += after
    listening.pieces.append(piece)
    made.wait(0.05)
    return made.state(now[0], None)


def test_a_word_drives_while_sound_arrives_and_has_the_time_at_which_it_ended(now: list[float]) -> None:
    listening = Listening()
    made = source(listening)
    state = hears(made, listening, now, b"forward", 0.1)
    assert state == InputState(0.5, word="forward")
    assert state is not None
    assert state.at == pytest.approx(now[0] - 0.25)
    assert [hears(made, listening, now, b" ", 0.1) for _ in range(19)] == [state] * 19
    assert hears(made, listening, now, b" ", 0.15) == NEUTRAL


def test_no_sound_for_0_3_s_stops_and_the_word_does_not_come_back(
    now: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    listening = Listening()
    made = source(listening)
    hears(made, listening, now, b"left", 0.1)
    assert hears(made, listening, now, b"", 0.29) == InputState(0.0, 0.25, word="left")
    assert hears(made, listening, now, b"", 0.02) == NEUTRAL
    assert hears(made, listening, now, b" ", 0.02) == NEUTRAL
    assert capsys.readouterr().err.splitlines()[-2:] == [
        "iw-joystick: stale: no sound arrives", "iw-joystick: fresh: sound arrives",
    ]  # fmt: skip


@pytest.mark.parametrize("word", ["forward", "stop"])
def test_the_end_of_the_sound_stops_and_ends_it(now: list[float], word: str) -> None:
    listening = Listening()
    made = source(listening)
    hears(made, listening, now, word.encode(), 0.1)
    last = hears(made, listening, now, None, 0.1)
    assert last is not None
    assert last.word == word
    # Nobody can say stop any more: the word ends long before its 2 s.
    assert hears(made, listening, now, None, 0.31) is None


def test_a_word_does_not_drive_on_after_a_gap_in_which_this_process_was_stopped(now: list[float]) -> None:
    listening = Listening()
    made = source(listening)
    assert hears(made, listening, now, b"forward", 0.1) == InputState(0.5, word="forward")
    # No state was asked for in the gap, and sound is there at once after it.
    assert hears(made, listening, now, b" ", 1.0) == NEUTRAL
    assert hears(made, listening, now, b"left", 0.1) == InputState(0.0, 0.25, word="left")


def test_a_word_that_waited_drives_nothing_but_a_late_stop_stops(
    now: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    listening = Listening()
    made = source(listening)
    listening.age = 1.5
    assert hears(made, listening, now, b"forward", 0.1) == NEUTRAL
    assert "dropped word=forward why='expected one of the last 1 s, got one of 1.5 s ago'" in capsys.readouterr().err
    listening.age = 0.25
    assert hears(made, listening, now, b"forward", 0.1) == InputState(0.5, word="forward")
    listening.age = 1.5
    assert hears(made, listening, now, b"stop", 0.1) == InputState(word="stop")


@pytest.mark.parametrize(("word", "state"), [("forward", NEUTRAL), ("stop", InputState(word="stop"))])
def test_of_words_that_took_long_to_recognise_only_stop_counts(now: list[float], word: str, state: InputState) -> None:
    listening = Listening()
    made = source(listening)
    listening.pieces.append(word.encode())
    made.wait(0.05)
    now[0] += 0.4
    assert made.state(now[0], None) == state
