from __future__ import annotations

from typing import Annotated

import msgspec
import pytest
from msgspec import Meta

from intellwheels_schemas.field_docs import field_docs, is_sentence
from intellwheels_schemas.messages import AgentActions, Proximity, Wall


class Local(msgspec.Struct):
    """A class of another package."""

    x: Annotated[Annotated[float, Meta(description="a length")], Meta(description="How far it is.")] | None = None
    y: float | int = 0.0
    """A string that is not read, since only the project's own modules are."""


def test_string_below_a_field_is_what_it_is_for() -> None:
    assert field_docs(Wall)["height"] == "Height of the upper edge above the floor (not above Bottom)."


def test_field_without_a_string_has_the_sentence_of_its_type() -> None:
    docs = field_docs(Proximity)
    assert docs["every"].startswith("Sampling interval in ticks")
    assert docs["latency"].startswith("Delay in ticks")
    # The field's own string comes before that of its type.
    assert docs["dropout"].endswith("must be 0 for the ideal model.")


def test_inherited_field_keeps_what_it_is_for() -> None:
    assert field_docs(AgentActions)["say"].startswith("Message to the agents in range")


def test_label_of_a_type_is_no_sentence() -> None:
    assert field_docs(Local) == {"x": "How far it is.", "y": ""}
    assert not is_sentence("a length")
    assert not is_sentence("")


def test_only_structs_have_fields() -> None:
    with pytest.raises(TypeError, match="expected a struct, got <class 'int'>"):
        field_docs(int)
