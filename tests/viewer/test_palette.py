from __future__ import annotations

import itertools

import pytest

from intellwheels_maps import library
from intellwheels_schemas.agent_colours import COLOURS, FIXTURES, THING, colour_of
from intellwheels_schemas.messages import Body, Robot
from intellwheels_viewer import palette
from intellwheels_viewer.palette import Colours
from tests.viewer.colour_difference import Sight, difference

RUN = "0" * 16
SIGHTS: tuple[Sight, ...] = ("common", "protan", "deutan", "tritan")


def mover(name: str) -> Body:
    return Body(run=RUN, tick=0, robot=Robot(name=name, kind="wheelchair", top_speed=1.0, length=1.0, width=0.6))


def thing(kind: str) -> Body:
    return Body(run=RUN, tick=0, robot=Robot(kind=kind, length=1.0, width=0.6))


@pytest.mark.parametrize("sight", SIGHTS)
def test_agents_contact_and_selection_are_sixteen_apart_in_every_sight(sight: Sight) -> None:
    colours = (*COLOURS, palette.CONTACT, palette.SELECTED)
    assert min(difference(a, b, sight) for a, b in itertools.combinations(colours, 2)) >= 16.0


@pytest.mark.parametrize("sight", SIGHTS)
def test_the_states_of_wedges_are_sixteen_apart_in_every_sight(sight: Sight) -> None:
    colours = (palette.NEAR, palette.MIDDLE, palette.FAR, palette.NOTHING, palette.FAILED)
    assert min(difference(a, b, sight) for a, b in itertools.combinations(colours, 2)) >= 16.0


def test_sights_differ_where_they_should() -> None:
    red, green = (220, 20, 20), (0, 130, 0)
    assert difference(red, green, "deutan") < difference(red, green) / 2
    assert difference((128, 128, 128), (128, 128, 128), "tritan") == 0.0


def test_the_difference_of_black_and_white_is_a_hundred() -> None:
    assert difference((0, 0, 0), (255, 255, 255)) == pytest.approx(100.0, abs=0.05)


def test_light_and_bytes_are_those_of_srgb() -> None:
    assert palette.linear((0, 188, 255)) == pytest.approx([0.0, 0.5028, 1.0], abs=1e-4)
    assert palette.light_bytes([(0, 188, 255)]).tolist() == [[0, 128, 255]]


def test_a_body_has_the_colour_of_its_name_in_whatever_order_bodies_come() -> None:
    one, other = Colours(), Colours()
    one.see({name: mover(name) for name in ("chair1", "chair2", "b")})
    other.see({"b": mover("b")})
    other.see({name: mover(name) for name in ("b", "chair2", "chair1")})
    assert [one.look(name) for name in ("chair1", "chair2", "b")] == [
        other.look(name) for name in ("chair1", "chair2", "b")
    ]
    assert one.rgb("chair1") == Colours().rgb("chair1") == colour_of("chair1")


def test_the_thirteenth_chair_has_the_first_colour_and_a_stripe() -> None:
    colours = Colours()
    colours.see({f"a{index}": mover(f"a{index}") for index in range(1, 49)})
    assert colours.rgb("a13") == colours.rgb("a1")
    assert [colours.mark(name) for name in ("a12", "a13", "a25", "a48")] == [0, 1, 2, 3]


@pytest.mark.parametrize("scene", library.names("scenes"))
def test_bodies_of_a_scene_differ_clearly_in_colour(scene: str) -> None:
    fixtures = {"door", "table"}
    names = sorted({cast.name for cast in library.scene(scene).cast if cast.mind not in fixtures})
    colours = Colours()
    colours.see({name: mover(name) for name in names})
    pairs = itertools.combinations((colours.rgb(name) for name in names), 2)
    assert min((difference(one, other) for one, other in pairs), default=100.0) >= 30.0


def test_a_dozen_that_come_together_differ_from_the_next_two_most() -> None:
    for one, two in itertools.product(range(len(COLOURS)), (1, 2)):
        assert difference(COLOURS[one], COLOURS[(one + two) % len(COLOURS)]) >= 50.0


def test_doors_and_tables_have_the_colour_of_their_kind() -> None:
    colours = Colours()
    colours.see({"door": thing("door"), "table": thing("table"), "crate": thing("crate"), "chair": mover("chair")})
    assert [colours.rgb(name) for name in ("door", "table", "crate")] == [FIXTURES["door"], FIXTURES["table"], THING]
    assert colours.rgb("chair") == colour_of("chair")
    assert colours.mark("door") == 0
