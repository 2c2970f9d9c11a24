"""Keys of a terminal: what its characters mean, and for how long. A pseudo-terminal plays the terminal."""

from __future__ import annotations

import os
import termios
import time
from collections.abc import Callable, Collection, Iterator

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.key_bindings import GENTLE, DrivingKeys
from intellwheels_agents.joystick.pygame_source import DeviceError
from intellwheels_agents.joystick.scan_keys import ScanKeys
from intellwheels_agents.joystick.terminal_source import ESCAPE_TIMEOUT, KEY_TIMEOUT, TerminalKeys, TerminalSource
from intellwheels_schemas.switch_scan import ScanSettings
from tests.every_case import every_case

DEADLINE = 10.0


def held(text: str) -> set[str]:
    keys = TerminalKeys()
    keys.feed(text, 1.0)
    return keys.held(1.0)


@every_case(
    ("text", "names"),
    [
        ("w", {"w"}),
        ("W", {"w", "shift"}),
        ("i", {"i"}),
        ("\x1b[A", {"up"}),
        ("\x1bOB", {"down"}),
        ("\x1b[D", {"left"}),
        ("\x1b[1;2C", {"right", "shift"}),
        ("\x1b[1;5C", {"right"}),
        ("3", {"3"}),
        ("w3", {"w", "3"}),
        ("wa", {"a"}),
        ("wwww ", {"space"}),
        ("w\x1b[H", {"w"}),
        ("w\x1b[15~", {"w"}),
        ("x\t\xff\n", set()),
    ],
)
def test_characters_and_sequences_are_keys(text: str, names: set[str]) -> None:
    assert held(text) == names


def test_a_key_counts_for_its_time_after_the_last_character() -> None:
    keys = TerminalKeys()
    for now in (1.0, 1.25, 1.5):
        keys.feed("w", now)
        assert keys.held(now + KEY_TIMEOUT - 0.01) == {"w"}
    assert keys.held(1.5 + KEY_TIMEOUT) == set()


def test_a_sequence_may_arrive_in_pieces() -> None:
    keys = TerminalKeys()
    for piece in ("\x1b", "[", "1;", "2A"):
        keys.feed(piece, 1.0)
    assert keys.held(1.0) == {"up", "shift"}
    assert not keys.has_ended


@pytest.mark.parametrize("text", ["\x1b", "\x04", "w\x1b\x1b"])
def test_escape_and_ctrl_d_end_it(text: str) -> None:
    keys = TerminalKeys()
    keys.feed(text, 1.0)
    keys.held(1.0 + ESCAPE_TIMEOUT + 0.01)
    assert keys.has_ended


def test_an_unfinished_sequence_is_dropped() -> None:
    keys = TerminalKeys()
    keys.feed("\x1b[", 1.0)
    assert keys.held(2.0) == set()
    keys.feed("A", 2.0)
    assert keys.held(2.0) == {"a", "shift"}
    assert not keys.has_ended


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    ours, theirs = os.openpty()
    yield ours, theirs
    os.close(ours)
    os.close(theirs)


def until(source: TerminalSource, found: Callable[[InputState | None], bool]) -> None:
    deadline = time.monotonic() + DEADLINE
    while not found(source.state(time.monotonic(), None)):
        assert time.monotonic() < deadline
        source.wait(0.05)


def test_a_key_drives_while_it_repeats_and_the_terminal_is_restored(terminal: tuple[int, int]) -> None:
    ours, theirs = terminal
    before = termios.tcgetattr(theirs)
    with TerminalSource(DrivingKeys(1.0, 0.5), theirs) as source:
        assert not termios.tcgetattr(theirs)[3] & (termios.ICANON | termios.ECHO)
        assert source.state(time.monotonic(), None) == NEUTRAL
        os.write(ours, b"W")
        until(source, lambda state: state == InputState(1.0))
        os.write(ours, b"\x1b[D")
        until(source, lambda state: state == InputState(0.0, 0.5 * GENTLE))
        # Nothing follows: the key is released by time.
        until(source, lambda state: state == NEUTRAL)
        os.write(ours, b"\x04")
        until(source, lambda state: state is None)
    assert termios.tcgetattr(theirs) == before


def test_a_terminal_that_hangs_up_ends_it() -> None:
    ours, theirs = os.openpty()
    with TerminalSource(DrivingKeys(1.0, 0.5), theirs) as source:
        os.close(ours)
        until(source, lambda state: state is None)
    os.close(theirs)


def test_a_pipe_is_no_terminal() -> None:
    reading, writing = os.pipe()
    with pytest.raises(DeviceError, match="expected a terminal on standard input, got a pipe or a file"):
        TerminalSource(DrivingKeys(1.0, 0.5), reading)
    os.close(reading)
    os.close(writing)


def test_other_keys_count_when_they_are_asked_for() -> None:
    for text, name in ((" ", "space"), ("\n", "enter"), ("\r", "enter"), ("\t", "tab"), ("X", "x"), ("1", "1")):
        keys = TerminalKeys({"space", "enter", "tab", "x", "1"})
        keys.feed(text, 1.0)
        assert keys.held(1.0) - {"shift"} == {name}


def test_of_two_switches_that_are_pressed_at_once_none_is_lost(terminal: tuple[int, int]) -> None:
    ours, theirs = terminal
    reader = ScanKeys(ScanSettings(method="step"), ("a", "b"), 1.0, 1.0)
    with TerminalSource(reader, theirs) as source:
        assert source.state(time.monotonic(), None) == NEUTRAL
        os.write(ours, b"ab")
        until(source, lambda state: state is not None and state.turn > 0.0)
    assert reader.caption.split() == ["forward", ">LEFT<", "right", "back", "stop"]


class Captioned(DrivingKeys):
    """Shows how often it was read."""

    caption = "0"

    def read(self, held: Collection[str], now: float) -> InputState:
        self.caption = str(int(self.caption) + 1)
        return super().read(held, now)


def test_a_caption_is_shown_in_one_line_and_a_key_has_its_time(
    terminal: tuple[int, int], capsys: pytest.CaptureFixture[str]
) -> None:
    ours, theirs = terminal
    with TerminalSource(Captioned(1.0, 0.5), theirs) as source:
        state = source.state(time.monotonic(), None)
        assert state is not None
        assert state.at is None
        began = time.monotonic()
        os.write(ours, b"W")
        until(source, lambda state: state is not None and state.at is not None and state.at >= began)
    shown = capsys.readouterr().err
    assert "\r\x1b[K1\r\x1b[K2" in shown
    assert shown.endswith("\n")


def test_a_line_that_is_printed_begins_after_the_caption_which_then_comes_again(
    terminal: tuple[int, int], capsys: pytest.CaptureFixture[str]
) -> None:
    with TerminalSource(Captioned(1.0, 0.5), terminal[1]) as source:
        source.state(time.monotonic(), None)
        source.leave_caption()
        source.leave_caption()
        source.state(time.monotonic(), None)
        source.leave_caption()
    assert capsys.readouterr().err.endswith("\r\x1b[K1\n\r\x1b[K2\n")
