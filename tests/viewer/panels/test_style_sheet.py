"""The style sheet: what is promised of sizes and contrast, and whose text may hold what."""

from __future__ import annotations

import re

import pytest

from intellwheels_viewer.panels import style_sheet
from intellwheels_viewer.panels.marks import _linear
from tests.every_case import every_case

GROUNDS = {"light": "#ffffff", "dark": "#242424"}
"""viser's panel in each theme."""


def variables(theme: str) -> dict[str, str]:
    found = re.findall(r"--iw-(\w+):(#[0-9a-f]{6})", style_sheet._LIGHT if theme == "light" else style_sheet._DARK)
    return dict(found)


def luminance(colour: str) -> float:
    red, green, blue = (_linear(int(colour[k : k + 2], 16) / 255) for k in (1, 3, 5))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@every_case("theme", GROUNDS)
@every_case("text", ["ink", "soft", "red", "amber", "green", "near", "middle", "far"])
@every_case("ground", ["panel", "tint", "chosen"])
def test_text_is_seen_on_every_ground_of_each_theme(theme: str, text: str, ground: str) -> None:
    colours = variables(theme)
    # WCAG 2, level AA for text of any size.
    assert contrast(colours[text], GROUNDS[theme] if ground == "panel" else colours[ground]) >= 4.5


def test_no_text_is_smaller_than_eleven_pixels() -> None:
    assert min(int(size) for size in re.findall(r"font-size:(\d+)px", style_sheet.STYLE_SHEET)) == 11


def test_both_themes_have_the_same_colours() -> None:
    assert variables("light").keys() == variables("dark").keys()


def test_words_of_a_peer_are_text_whatever_they_hold() -> None:
    assert "<img" not in style_sheet.prose("<img src=x onerror=alert(1)> `<b>`")


def test_a_command_stands_out() -> None:
    assert style_sheet.prose("Start `iw-router`.") == "Start <code>iw-router</code>."


def test_a_word_or_a_long_number_in_place_of_a_figure_is_written_smaller() -> None:
    written = [style_sheet.figures([(figure, "tick")]) for figure in ("12.50", "paused", "123456789")]
    assert ["word" in one for one in written] == [False, True, True]


SCROLLBAR = 12
"""Pixels of the scrollbar that viser lays over the right edge of a panel (the default of its library)."""


@pytest.mark.parametrize("selector", [".iw", ".iw-plan"])
def test_no_text_is_under_the_scrollbar_of_a_long_panel(selector: str) -> None:
    rule = re.search(rf"{re.escape(selector)}{{[^}}]*?padding:([^;}}]+)", style_sheet._RULES)
    assert rule is not None
    sides = [int(size.removesuffix("px")) for size in rule[1].split()]
    assert sides[1] > SCROLLBAR


@pytest.mark.parametrize("theme", GROUNDS)
def test_buttons_and_their_focus_are_seen(theme: str) -> None:
    colours = variables(theme)
    assert colours["ground"] == GROUNDS[theme]
    # The text of an active choice, and of a recording that runs.
    assert contrast(colours["floor"], colours["ink"]) >= 4.5
    assert contrast(colours["floor"], colours["red"]) >= 4.5
    # WCAG 2, level AA for what shows where a control is and that it has the focus.
    assert contrast(colours["edge"], GROUNDS[theme]) >= 3.0
    assert contrast(colours["focus"], GROUNDS[theme]) >= 3.0
