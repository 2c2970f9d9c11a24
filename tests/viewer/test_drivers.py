"""Who drives a body, from what is published of it."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from intellwheels_schemas.messages import Body, Measures, UserInput
from intellwheels_viewer.drivers import driver_of, reality_of, reality_words
from tests.viewer.drawings.cast import RUN, entity, robot

INSTANCE = "5f0c2a9be1d84377"


def joined(name: str = "rear-wheel", roles: tuple[str, ...] = ("both",), **fields: Any) -> Body:
    return Body(run=RUN, tick=0, owner=INSTANCE, roles=roles, robot=robot(name, instance=INSTANCE, **fields))  # type: ignore[arg-type]


def measures(user_input: UserInput | None) -> Measures:
    return Measures(run=RUN, tick=1, time=0.05, user_input=user_input)


def test_a_mind_is_a_program() -> None:
    assert driver_of(entity("a"), joined()) == "driven by a program"
    assert driver_of(entity("a"), joined(roles=("body", "mind"))) == "driven by a program"
    assert driver_of(entity("a"), joined("person")) == "moved by a program"
    assert driver_of(entity("door"), joined("door")) == "moved by a program"


def test_goals_are_given_to_a_program_which_drives() -> None:
    assert driver_of(entity("a"), joined(user_input=("goal",))) == "driven by a program"


@pytest.mark.parametrize("kind", ["drive", "words"])
def test_who_takes_a_stick_is_driven_by_a_person_or_waits_for_one(kind: str) -> None:
    stick = joined(user_input=(kind,))
    assert driver_of(entity("a"), stick) == "driven by a person at a joystick"
    assert driver_of(entity("a"), stick, measures(UserInput(forward=0.5))) == "driven by a person at a joystick"
    assert driver_of(entity("a"), stick, measures(None)) == "waits for a person at a joystick"


def test_who_is_taken_over_is_driven_by_an_operator_or_in_this_page() -> None:
    assert driver_of(entity("a", state="taken"), joined()) == "driven by an operator who took it over"
    assert driver_of(entity("a", state="taken"), joined(), here=True) == "driven by you, in this page"


def test_a_body_alone_is_driven_by_nobody() -> None:
    assert driver_of(entity("a"), joined(roles=("body",))) == "nobody drives it"
    placed = Body(run=RUN, tick=0, robot=robot("rear-wheel"))
    assert driver_of(entity("a"), placed) == "nobody drives it"
    assert driver_of(entity("table"), joined("table")) == "nobody drives it"
    assert driver_of(entity("door"), joined("door", roles=("body",))) == "nobody moves it"


def test_a_log_that_names_no_roles_has_those_of_the_document() -> None:
    body = msgspec.structs.replace(joined(), owner=None, roles=())
    assert driver_of(entity("a"), body) == "driven by a program"
    # A mind of another process is not named there, but it says what it does.
    body = msgspec.structs.replace(joined(role="body"), roles=("body",))
    assert driver_of(entity("a"), body) == "nobody drives it"
    assert driver_of(entity("a", mode="autonomous"), body) == "driven by a program"


def test_a_stand_in_is_told_from_a_real_chair() -> None:
    real, acted = robot("rear-wheel", type="real"), robot("rear-wheel", type="real", hardware="simulated")
    assert [reality_of(each) for each in (real, acted, robot("rear-wheel"))] == ["real", "stand-in", "simulated"]
    assert reality_words(real) == "real chair"
    assert reality_words(acted) == "stand-in for a real chair"
    assert reality_words(robot("person", type="real")) == "real robot"
    assert reality_words(robot("rear-wheel")) == ""
