from __future__ import annotations

from typing import get_args

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import VERBS
from intellwheels_schemas.lab_rules import LAB_ROLES, NAMES_AGENTS, NO_AGENTS, check_lab
from intellwheels_schemas.messages import ControlVerb, Identity, Lab, LabRole, May
from tests.every_case import every_case


def lab(*identities: Identity) -> Lab:
    return Lab(format="iw.v1", name="l", identity=identities)


def one(**may: object) -> Lab:
    return lab(Identity(name="a", may=(May(**may),)))  # type: ignore[arg-type]


def test_verbs_are_those_of_the_keys() -> None:
    assert get_args(ControlVerb) == tuple(VERBS)
    assert set(LAB_ROLES) > NAMES_AGENTS | NO_AGENTS


@every_case("role", get_args(LabRole))
def test_each_role_can_be_given(role: LabRole) -> None:
    check_lab(one(role=role, agents=("a",) if role in NAMES_AGENTS else ()), "Lab")


@pytest.mark.parametrize(
    ("document", "text"),
    [
        (lab(Identity(name="a"), Identity(name="a")), "Lab.Identity[1].Name: expected each name once, got 'a' twice"),
        (
            lab(Identity(name="a", until="2027-02-29")),
            "Lab.Identity[0].Until: expected a date of the calendar, got '2027-02-29'",
        ),
        (one(role="bridge"), "Lab.Identity[0].May[0].Agents: expected the agents of the role bridge, got none"),
        (
            one(role="recorder", agents=("a",)),
            "Lab.Identity[0].May[0].Agents: expected none, as the role recorder is for the whole world, got a",
        ),
        (
            one(role="viewer", verbs=("pause",)),
            "Lab.Identity[0].May[0].Verbs: expected none, as the role viewer has no verbs, got pause",
        ),
    ],
)
def test_wrong_lab_is_refused_with_its_place(document: Lab, text: str) -> None:
    with pytest.raises(WireError) as caught:
        check_lab(document, "Lab")
    assert caught.value.text == text
