"""How agents are told apart."""

from __future__ import annotations

from intellwheels_viewer.panels.marks import GREY, Mark, swatch

BLUE, ORANGE = (0, 114, 178), (230, 159, 0)


def test_each_number_of_stripes_has_a_swatch_of_its_own() -> None:
    swatches = [swatch(Mark(BLUE, stripes)) for stripes in range(4)]
    assert [each.count("<path") for each in swatches] == [0, 1, 2, 3]


def test_the_second_mark_is_seen_on_its_colour() -> None:
    assert (Mark((20, 20, 20)).ink, Mark(ORANGE).ink) == ("#fff", "#000")


def test_bodies_without_a_colour_are_grey() -> None:
    assert Mark().colour == GREY


def test_the_title_of_a_swatch_is_text() -> None:
    assert "<b>" not in swatch(Mark(), "<b>")
