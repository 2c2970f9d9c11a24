"""Scripts: a line for each wish, with words for each that is none."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from intellwheels_agents.joystick.script_source import ScriptError, ScriptSource, parse, read
from intellwheels_agents.joystick.wish import NOTHING, Wish

TEXT = """\
# a bend
0.5  1    0
2.0  0.5  -0.5  3,0  hello   # said
3.0  0    0     -    stop

3.5  0    0
"""


def test_what_is_wanted_at_a_time() -> None:
    script = parse(TEXT, "bend")
    assert script.at(0.0) == NOTHING
    assert script.at(0.5) == script.at(1.99) == Wish(1.0, 0.0)
    assert script.at(2.0) == Wish(0.5, -0.5, (0, 3), "hello")
    assert script.at(3.2) == Wish(word="stop")
    assert script.at(3.5) is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "bend: expected at least one line, got none"),
        (
            "0 1",
            r"bend:1: expected seconds, forward and turn in \[-1, 1\], perhaps buttons \(0,3\) and a word, got '0 1'",
        ),
        ("0 0 0\n1 2 0", "bend:2: expected seconds, forward and turn"),
        ("0 nan 0", "bend:1: expected seconds, forward and turn"),
        ("0 0 0 64", "bend:1: expected seconds, forward and turn"),
        ("0 0 0 - two words", "bend:1: expected seconds, forward and turn"),
        ("0 0 0 - <b>", "bend:1: expected seconds, forward and turn"),
        ("1 0 0\n1 0 0", "bend:2: expected seconds that grow from 0, got '1'"),
        ("-1 0 0", "bend:1: expected seconds that grow from 0, got '-1'"),
        ("inf 0 0", "bend:1: expected seconds that grow from 0, got 'inf'"),
    ],
)
def test_a_line_that_is_none_is_named(text: str, message: str) -> None:
    with pytest.raises(ScriptError, match=f"^{message}"):
        parse(text, "bend")


def test_its_seconds_are_the_walls_from_the_first_wish() -> None:
    source = ScriptSource(parse(TEXT, "bend"), simulated=False, stop=threading.Event())
    assert source.wish(100.0, None) == NOTHING
    assert source.wish(100.6, None) == Wish(1.0, 0.0)
    assert source.wish(103.5, None) is None


def test_its_seconds_are_the_simulations_from_the_first_clock_and_anew_after_a_reset() -> None:
    source = ScriptSource(parse(TEXT, "bend"), simulated=True, stop=threading.Event())
    assert source.wish(100.0, None) == NOTHING
    assert source.wish(200.0, 7.0) == NOTHING
    assert source.wish(200.0, 7.5) == Wish(1.0, 0.0)
    assert source.wish(200.0, 0.0) == NOTHING
    assert source.wish(200.0, 3.5) is None


def test_a_file_that_is_no_text_is_said(tmp_path: Path) -> None:
    (tmp_path / "drive.txt").write_bytes(b"0 1 0\n\xff\xfe\n")
    with pytest.raises(ScriptError, match=r"drive\.txt: expected a text in UTF-8, got byte 0xff$"):
        read(tmp_path / "drive.txt")
    (tmp_path / "drive.txt").write_text("0 1 0  # für dich\n1 0 0\n", encoding="utf-8")
    assert read(tmp_path / "drive.txt").at(0.5) == Wish(1.0)
