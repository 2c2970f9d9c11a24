from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from intellwheels_schemas import command_parser, messages
from intellwheels_schemas.command_parser import (
    CommandParser,
    add_retry_option,
    like_field,
    naming,
    number,
    open_descriptor,
    readable_file,
    whole,
)
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case


def parser() -> CommandParser:
    made = CommandParser(prog="iw-try")
    made.add_argument("scene", metavar="SCENE")
    made.add_argument("--pace", choices=("realtime", "free", "lockstep"))
    made.add_argument("--speed", type=float, metavar="F")
    made.add_argument("--seeds", type=int, metavar="N")
    made.add_argument("--view", action="store_true")
    made.add_argument("--both", type=number("a number", 0.0, 1.0))
    return made


@every_case(
    ("words", "text"),
    [
        ([], "SCENE: expected a value, got none"),
        (["a", "b"], "expected no further argument, got 'b'"),
        (["a", "--spede", "1"], "--spede: expected an option of iw-try, got '--spede'; did you mean '--speed'?"),
        (["a", "--s", "1"], "--s: expected one of --speed, --seeds, got '--s'"),
        (["a", "--pace", "fre"], "--pace: expected one of realtime, free, lockstep, got 'fre'; did you mean 'free'?"),
        (["a", "--pace"], "--pace: expected one of realtime, free, lockstep, got none"),
        (["a", "--speed"], "--speed: expected F, got none"),
        (["a", "--speed", "fast"], "--speed: expected a number, got 'fast'"),
        (["a", "--seeds", "1.5"], "--seeds: expected a whole number, got '1.5'"),
        (["a", "--view=yes"], "--view: expected no value, got 'yes'"),
        (["a", "--both", "2\n3"], "--both: expected a number in [0, 1], got '2\\n3'"),
    ],
)
def test_each_mistake_is_one_line_with_the_option_what_was_expected_and_what_came(
    words: list[str], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        parser().parse_args(words)
    assert ended.value.code == 2
    printed = capsys.readouterr()
    # A later Python writes some of them a little differently.
    see = " See" if text.endswith("?") else "; see"
    assert printed.err == f"iw-try: {text}{see} iw-try --help\n"
    assert printed.out == ""


def test_parsers_of_subcommands_are_of_the_same_kind(capsys: pytest.CaptureFixture[str]) -> None:
    made = CommandParser(prog="iw-try")
    made.add_subparsers(required=True, metavar="COMMAND").add_parser("go").add_argument("where")
    with pytest.raises(SystemExit):
        made.parse_args(["go"])
    assert capsys.readouterr().err == "iw-try go: where: expected a value, got none; see iw-try go --help\n"


@pytest.mark.parametrize("kind", [argparse.HelpFormatter, argparse.RawDescriptionHelpFormatter])
def test_help_breaks_no_value_at_its_hyphens(kind: type[argparse.HelpFormatter]) -> None:
    made = CommandParser(prog="iw-try", epilog="one\n  two", formatter_class=kind)
    made.add_argument("--keys", help="many  words, " * 4 + "hard-puff=up,hard-sip=down,soft-puff=right,soft-sip=left")
    help_ = made.format_help()
    assert "hard-puff=up,hard-sip=down,soft-puff=right,soft-sip=left" in help_
    assert ("one\n  two" in help_) is (kind is argparse.RawDescriptionHelpFormatter)


def test_the_option_is_named_before_the_text_of_an_error() -> None:
    with pytest.raises(WireError, match=r"^--map: expected a map, got 'x'$"), naming("--map"):
        raise WireError("value", "expected a map, got 'x'")
    with pytest.raises(WireError, match=r"^--map: once$"), naming("--map"):
        raise WireError("value", "--map: once", "--map")


@every_case(
    ("kind", "good", "bad", "expected"),
    [
        (number("a number"), ["1", "-2.5", "1e3"], ["", "x", "nan", "inf", "-inf", "1e400", "1,5"], "a number"),
        (number("a number", 0.0), ["0", "1e300"], ["-1e-300"], "a number of at least 0"),
        (number("a number", 0.0, low_open=True), ["1e-300"], ["0", "-0.0"], "a number above 0"),
        (command_parser.share, ["0", "1"], ["-0.1", "1.0001"], "a share in [0, 1]"),
        (command_parser.positive_seconds, ["0.1"], ["0", "2e9"], "seconds in (0, 1e+09]"),
        (whole(1, 100), ["1", "100"], ["0", "101", "1.0", "-1", "²", "9" * 5000, ""], "a whole number in [1, 100]"),
        (command_parser.port, ["0", "65535"], ["65536", "http"], "a port in [0, 65535]"),
        (like_field(messages.Factor), ["1000", "0.001"], ["0", "1001", "nan", "x"], "a number in (0, 1000]"),
        (like_field(messages.Period), ["0.001", "1"], ["0", "1.1"], "seconds in [0.001, 1]"),
        (like_field(messages.SayRange), ["20000"], ["0", "20001", "1e300"], "metres in (0, 20000]"),
    ],
)
def test_numbers_are_finite_and_in_their_range(
    kind: Callable[[str], Any], good: list[str], bad: list[str], expected: str
) -> None:
    assert [kind(text) for text in good] == [float(text) for text in good]
    for text in bad:
        with pytest.raises(argparse.ArgumentTypeError, match=f"^expected {re.escape(expected)}, got "):
            kind(text)


def test_text_has_the_bounds_of_its_field() -> None:
    assert like_field(messages.Seed)("seven") == "seven"
    with pytest.raises(argparse.ArgumentTypeError, match=r"^expected at most 64 characters, got 65$"):
        like_field(messages.Seed)("x" * 65)
    with pytest.raises(TypeError, match="expected a type of one number or text"):
        like_field(messages.Map)


def test_a_lifeline_is_an_open_descriptor() -> None:
    reading, writing = os.pipe()
    assert open_descriptor(str(reading)) == reading
    os.close(reading)
    os.close(writing)
    for text in (str(reading), "-1", "x", "", "1e3", "99999999999999999999"):
        with pytest.raises(argparse.ArgumentTypeError, match=r"^expected an open file descriptor, got "):
            open_descriptor(text)


def test_input_is_a_file_that_can_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "log"
    file.touch()
    assert readable_file(str(file)) == file
    assert readable_file(os.devnull) == Path(os.devnull)
    for text, words in (
        (str(tmp_path / "none"), "a file that exists, got '.*none'"),
        ("", "a file that exists, got ''"),
        (str(tmp_path), "a file, got the folder "),
    ):
        with pytest.raises(argparse.ArgumentTypeError, match=f"^expected {words}"):
            readable_file(text)
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(argparse.ArgumentTypeError, match=r"^expected a file that may be read, got "):
        readable_file(str(file))


def test_a_command_waits_for_ever_unless_it_is_told_how_long() -> None:
    parser = CommandParser(prog="iw-x")
    add_retry_option(parser, "the chair")
    assert parser.parse_args([]).retry_for == math.inf
    assert parser.parse_args(["--retry-for", "2.5"]).retry_for == 2.5
    assert "give up after S seconds without the chair (default: never)" in parser.format_help()
