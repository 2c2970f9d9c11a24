"""Scripts: a state on each line, and an error for each wrong line."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.script_source import ScriptError, ScriptSource, parse, read
from tests.every_case import every_case

TEXT = """\
# a bend
0.5  1    0
2.0  0.5  -0.5  3,0  hello   # said
3.0  0    0     -    stop

3.5  0    0
"""


def test_the_state_at_a_time() -> None:
    script = parse(TEXT, "bend")
    assert script.at(0.0) == NEUTRAL
    assert script.at(0.5) == script.at(1.99) == InputState(1.0, 0.0)
    assert script.at(2.0) == InputState(0.5, -0.5, (0, 3), "hello")
    assert script.at(3.2) == InputState(word="stop")
    assert script.at(3.5) is None


@every_case(
    ("text", "message"),
    [
        ("", "bend: expected at least one line, got none"),
        (
            "0 1",
            r"bend:1: expected seconds, forward and turn in \[-1, 1\], then optionally buttons \(0,3\) and a word, "
            "got '0 1'",
        ),
        ("0 0 0\n1 2 0", "bend:2: expected seconds, forward and turn"),
        ("0 nan 0", "bend:1: expected seconds, forward and turn"),
        ("0 0 0 64", "bend:1: expected seconds, forward and turn"),
        ("0 0 0 - two words", "bend:1: expected seconds, forward and turn"),
        ("0 0 0 - <b>", "bend:1: expected seconds, forward and turn"),
        ("1 0 0\n1 0 0", "bend:2: expected increasing seconds from 0 on, got '1'"),
        ("-1 0 0", "bend:1: expected increasing seconds from 0 on, got '-1'"),
        ("inf 0 0", "bend:1: expected increasing seconds from 0 on, got 'inf'"),
    ],
)
def test_a_wrong_line_is_named(text: str, message: str) -> None:
    with pytest.raises(ScriptError, match=f"^{message}"):
        parse(text, "bend")


def test_wall_seconds_count_from_the_first_read() -> None:
    source = ScriptSource(parse(TEXT, "bend"), simulated=False, stop=threading.Event())
    assert source.state(100.0, None) == NEUTRAL
    assert source.state(100.6, None) == InputState(1.0, 0.0)
    assert source.state(103.5, None) is None


def test_simulated_seconds_count_from_the_first_clock_and_restart_after_a_reset() -> None:
    source = ScriptSource(parse(TEXT, "bend"), simulated=True, stop=threading.Event())
    assert source.state(100.0, None) == NEUTRAL
    assert source.state(200.0, 7.0) == NEUTRAL
    assert source.state(200.0, 7.5) == InputState(1.0, 0.0)
    assert source.state(200.0, 0.0) == NEUTRAL
    assert source.state(200.0, 3.5) is None


def test_a_file_that_is_not_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "drive.txt").write_bytes(b"0 1 0\n\xff\xfe\n")
    with pytest.raises(ScriptError, match=r"drive\.txt: expected UTF-8 text, got byte 0xff$"):
        read(tmp_path / "drive.txt")
    (tmp_path / "drive.txt").write_text("0 1 0  # für dich\n1 0 0\n", encoding="utf-8")
    assert read(tmp_path / "drive.txt").at(0.5) == InputState(1.0)
