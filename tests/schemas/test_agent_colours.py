"""Colours by name."""

from __future__ import annotations

import itertools
import random

import pytest

from intellwheels_schemas.agent_colours import COLOURS, STRIPES, Look, colour_of, css, look_of, looks, natural_key


def test_a_colour_depends_on_the_name_only() -> None:
    cast = [f"chair{number}" for number in range(1, 20)]
    together = looks(cast)
    assert {name: look.colour for name, look in together.items()} == {name: colour_of(name) for name in cast}
    assert looks(["chair4", "table-7"])["chair4"] == together["chair4"]


def test_colours_stay_the_same_from_release_to_release() -> None:
    names = ("chair1", "chair2", "chair3", "goer", "iris")
    assert [COLOURS.index(colour_of(name)) for name in names] == [5, 6, 7, 1, 7]


def test_the_first_twelve_of_a_cast_differ_in_colour_and_the_next_in_stripes() -> None:
    found = [look_of(f"chair{number}") for number in range(1, 49)]
    assert len({look.colour for look in found[:12]}) == 12
    assert [look.stripes for look in found] == sorted([0, 1, 2, 3] * 12)
    assert len(set(found)) == 48


def test_names_that_would_look_the_same_are_told_apart_in_whatever_order_they_come() -> None:
    same = [
        name
        for name in (f"{a}{b}" for a, b in itertools.product("abcdefgh", repeat=2))
        if look_of(name) == look_of("aa")
    ]
    same = same[: STRIPES + 1]
    assert len(same) == STRIPES + 1
    found = looks(same)
    assert sorted(look.stripes for look in found.values()) == [0, 1, 2, 3]
    shuffled = random.Random(1).sample(same, len(same))
    assert looks(shuffled) == looks([*same, *same]) == found


def test_a_name_alone_keeps_its_own_look() -> None:
    assert looks(["chair9"]) == {"chair9": look_of("chair9")}
    assert look_of("chair0") == look_of("chair1") == Look(colour_of("chair1"), 0)


@pytest.mark.parametrize(
    "name", ["", "7", "a" * 5000, "1" * 5000, "x\n1", "\u00b2", "\ud800".encode("utf-8", "replace").decode()]
)
def test_any_text_has_a_colour(name: str) -> None:
    assert colour_of(name) in COLOURS
    assert isinstance(natural_key(name), tuple)


def test_natural_order_counts_numbers() -> None:
    names = ["chair10", "b", "chair2", "a2b10", "a2b9", "chair", "chair02", "2", "10"]
    assert sorted(names, key=natural_key) == ["2", "10", "a2b9", "a2b10", "b", "chair", "chair02", "chair2", "chair10"]


def test_css_is_six_digits() -> None:
    assert css((0, 114, 178)) == "#0072b2"
