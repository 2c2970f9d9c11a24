"""How agents are told apart."""

from __future__ import annotations

from intellwheels_viewer.panels.marks import GREY, Mark, marks, swatch

BLUE, ORANGE = (0, 114, 178), (230, 159, 0)


def test_a_colour_that_comes_again_has_a_second_mark() -> None:
    found = marks({"a": BLUE, "b": ORANGE, "c": BLUE, "d": BLUE, "e": BLUE})
    assert [found[name].repeat for name in "abcde"] == [0, 0, 1, 2, 3]


def test_each_repeat_of_a_colour_has_a_swatch_of_its_own() -> None:
    swatches = [swatch(Mark(BLUE, repeat)) for repeat in range(12)]
    assert len(set(swatches)) == 12


def test_the_fourth_of_a_colour_has_its_number() -> None:
    assert ">4</text>" in swatch(Mark(BLUE, 3))


def test_the_second_mark_is_seen_on_its_colour() -> None:
    assert (Mark((20, 20, 20)).ink, Mark(ORANGE).ink) == ("#fff", "#000")


def test_bodies_without_a_colour_are_grey() -> None:
    assert Mark().colour == GREY


def test_the_title_of_a_swatch_is_text() -> None:
    assert "<b>" not in swatch(Mark(), "<b>")
