"""`iw-agent MIND --help`: the options of an included mind, with ranges and defaults."""

from __future__ import annotations

import re
from importlib import import_module

import pytest

from intellwheels_agents import minds
from intellwheels_agents.__main__ import main
from intellwheels_agents.mind_help import mind_help, option_rows
from tests.every_case import every_case


def test_help_of_a_mind_lists_its_options_with_ranges_and_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["waypoints", "--help"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("usage: iw-agent waypoints ")
    assert "Drives along a path of points" in text
    assert re.search(r"^  speed +speed on .*, m/s \(a number in \[0.05, 20\]; default 0.6\)$", text, re.MULTILINE)
    assert text.count("default 0.6") == 1


@every_case("name", minds.names())
def test_every_option_that_a_mind_reads_is_explained_too(name: str) -> None:
    shown = " ".join(mind_help(name).split())
    # Each with its range, in the one list of options.
    assert [option for option, row in option_rows(name).items() if row not in shown] == []
    assert "(default" not in shown


def described(name: str) -> set[str]:
    """Return the options that the docstring of a mind describes: the first block of indented lines."""
    about = import_module(f"{minds.__name__}.{name}").__doc__ or ""
    blocks = [part.splitlines() for part in about.split("\n\n") if part.startswith("    ")]
    found: set[str] = set()
    for line in blocks[0] if blocks else []:
        if (names := re.match(r" {4}(\w+(?:, \w+)*) +\S", line)) is not None:
            found |= set(names[1].split(", "))
    return found


@every_case("name", minds.names())
def test_every_option_that_a_mind_describes_is_listed_with_its_range(name: str) -> None:
    assert described(name) == option_rows(name).keys()


def test_help_of_a_mind_that_needs_a_place_lists_what_it_reads_after_it() -> None:
    assert "margin" in option_rows("seek")


def test_help_says_which_options_are_required_and_what_the_others_are() -> None:
    assert option_rows("seek")["to"] == "a place of the map; required"
    assert option_rows("follow")["leader"] == "the name of an agent; required"
    assert option_rows("waypoints")["via"] == "names, separated by spaces or commas; default none"
    assert option_rows("waypoints")["points"] == 'pairs of coordinates, "x y x y"; default none'
