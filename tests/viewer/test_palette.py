from __future__ import annotations

import itertools

import pytest

from intellwheels_schemas.messages import Body, Robot
from intellwheels_viewer import palette
from intellwheels_viewer.palette import Colours, Sight

RUN = "0" * 16
SIGHTS: tuple[Sight, ...] = ("common", "protan", "deutan", "tritan")


def mover(name: str) -> Body:
    return Body(run=RUN, tick=0, robot=Robot(name=name, kind="wheelchair", top_speed=1.0, length=1.0, width=0.6))


def thing(kind: str) -> Body:
    return Body(run=RUN, tick=0, robot=Robot(kind=kind, length=1.0, width=0.6))


@pytest.mark.parametrize("sight", SIGHTS)
def test_agents_contact_and_selection_are_sixteen_apart_in_every_sight(sight: Sight) -> None:
    colours = (*palette.AGENTS, palette.CONTACT, palette.SELECTED)
    assert min(palette.difference(a, b, sight) for a, b in itertools.combinations(colours, 2)) >= 16.0


@pytest.mark.parametrize("sight", SIGHTS)
def test_the_states_of_wedges_are_sixteen_apart_in_every_sight(sight: Sight) -> None:
    colours = (palette.NEAR, palette.MIDDLE, palette.FAR, palette.NOTHING, palette.FAILED)
    assert min(palette.difference(a, b, sight) for a, b in itertools.combinations(colours, 2)) >= 16.0


def test_sights_differ_where_they_should() -> None:
    red, green = (220, 20, 20), (0, 130, 0)
    assert palette.difference(red, green, "deutan") < palette.difference(red, green) / 2
    assert palette.difference((128, 128, 128), (128, 128, 128), "tritan") == 0.0


def test_the_difference_of_black_and_white_is_a_hundred() -> None:
    assert palette.difference((0, 0, 0), (255, 255, 255)) == pytest.approx(100.0, abs=0.05)


@pytest.mark.parametrize("colour", palette.AGENTS)
def test_text_in_an_agents_colour_can_be_read_on_both_grounds(colour: palette.RGB) -> None:
    assert palette.contrast(palette.text_safe(colour), palette.ON_WHITE) >= 4.5
    assert palette.contrast(palette.text_safe(colour, dark=True), palette.ON_DARK) >= 4.5


def test_a_colour_that_can_be_read_stays_as_it_is() -> None:
    assert palette.text_safe((0, 80, 140)) == (0, 80, 140)


def test_contrast_is_that_of_wcag() -> None:
    assert palette.contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21.0)
    assert palette.contrast((118, 118, 118), (255, 255, 255)) == pytest.approx(4.54, abs=0.01)


def test_light_and_bytes_are_inverse() -> None:
    for byte in range(256):
        assert palette.encoded(palette.linear((byte, byte, byte))) == (byte, byte, byte)
    assert palette.light_bytes([(0, 188, 255)]).tolist() == [[0, 128, 255]]


def test_agents_get_colours_in_the_order_in_which_they_come_and_keep_them() -> None:
    colours = Colours()
    colours.see({"b": mover("b"), "a": mover("a")})
    colours.see({"a": mover("a"), "c": mover("c")})
    assert [colours.rgb(name) for name in "bac"] == list(palette.AGENTS[:3])


def test_the_seventh_agent_has_the_first_colour_and_a_stripe() -> None:
    colours = Colours()
    colours.see({f"a{index}": mover(f"a{index}") for index in range(25)})
    assert colours.rgb("a6") == colours.rgb("a0")
    assert [colours.mark(name) for name in ("a5", "a6", "a12", "a23", "a24")] == [0, 1, 2, 3, 0]


def test_doors_and_tables_use_no_colour_up() -> None:
    colours = Colours()
    colours.see({"door": thing("door"), "table": thing("table"), "crate": thing("crate"), "chair": mover("chair")})
    assert colours.rgb("door") == palette.TEAL
    assert colours.rgb("table") == palette.WOOD
    assert colours.rgb("chair") == palette.AGENTS[0]
    assert colours.mark("door") == 0


def test_an_agents_text_is_css() -> None:
    assert Colours().text("anybody") == palette.hexadecimal(palette.text_safe(palette.AGENTS[0]))
    assert palette.hexadecimal((0, 114, 178)) == "#0072b2"


def test_a_cast_that_begins_anew_has_the_same_colours_in_whatever_order_it_came_before() -> None:
    colours = Colours()
    colours.see({"chair2": mover("chair2")})
    colours.begin()
    colours.see({name: mover(name) for name in ("chair1", "chair2")})
    assert (colours.index("chair1"), colours.index("chair2")) == (0, 1)
