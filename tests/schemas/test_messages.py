"""Every field of the contract says what it is for."""

from __future__ import annotations

import re

import msgspec
import pytest

from intellwheels_schemas import file_records, messages
from intellwheels_schemas.field_docs import field_docs, is_sentence
from intellwheels_schemas.messages import Actions, AgentActions, AgentMeasures, Measures, Record
from intellwheels_schemas.shapes import Member, shape_of
from tests.every_case import every_case

RECORDS = [
    cls
    for module in (messages, file_records)
    for cls in vars(module).values()
    if isinstance(cls, type)
    and issubclass(cls, msgspec.Struct)
    and cls.__module__ == module.__name__
    and not cls.__name__.startswith("_")
]

# Words that tell nobody anything about a field.
_EMPTY = {"a", "an", "the", "of", "its", "this", "field", "value", "is", "number", "text", "list"}

_UNITS = {"m", "rad", "deg", "m/s", "rad/s", "m/s2", "1"}
# Which way a signed quantity counts.
_DIRECTION = re.compile(r"\bframe\b|\bpositive\b|\banticlockwise\b|\bforward\b")


def words(text: str) -> set[str]:
    """Return the words of a text or of a name in any case, without those that say nothing."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text).replace("_", " ")
    return {word.lower() for word in re.findall(r"[A-Za-z0-9]+", apart)} - _EMPTY


def what_is_wrong(text: str, name: str, kind: str) -> str:
    """Return why a text does not say what a field is for, or an empty string."""
    if not text:
        return "it says nothing"
    if not is_sentence(text):
        return "it is no sentence"
    if not words(text) - words(name) - words(kind):
        return "it repeats the name or the type"
    return ""


@every_case("cls", RECORDS, ids=lambda cls: cls.__name__)
def test_every_field_says_what_it_is_for(cls: type[msgspec.Struct]) -> None:
    docs = field_docs(cls)
    kinds = {member.name: kind_of(member) for member in shape_of(cls).members} if issubclass(cls, Record) else {}
    found = {name: what_is_wrong(docs[name], name, kinds.get(name, "")) for name in cls.__struct_fields__}
    assert {f"{cls.__name__}.{name}": wrong for name, wrong in found.items() if wrong} == {}


def kind_of(member: Member) -> str:
    if member.scalar is not None:
        return f"{member.scalar.kind} {member.scalar.expected} {member.scalar.unit}"
    return member.record.__name__ if member.record is not None else ""


@every_case("cls", [cls for cls in RECORDS if issubclass(cls, Record)], ids=lambda cls: cls.__name__)
def test_angles_and_coordinates_say_their_frame_or_sign(cls: type[Record]) -> None:
    docs = field_docs(cls)
    for member in shape_of(cls).members:
        scalar = member.scalar
        if scalar is not None and scalar.unit in _UNITS and scalar.low is not None and scalar.low < 0.0:
            assert _DIRECTION.search(docs[member.name]), f"{cls.__name__}.{member.wire}: {docs[member.name]}"


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("", "it says nothing"),
        ("distance between the wheels", "it is no sentence"),
        ("The wheel diameter.", "it repeats the name or the type"),
        ("A number.", "it repeats the name or the type"),
        ("Nominal diameter of both driven wheels.", ""),
    ],
)
def test_sentence_that_says_nothing_is_refused(text: str, wrong: str) -> None:
    assert what_is_wrong(text, "wheel_diameter", "number m") == wrong


def test_every_record_says_what_it_is() -> None:
    for cls in RECORDS:
        assert is_sentence((cls.__doc__ or "").strip().partition("\n")[0]), cls


def test_crew_messages_have_the_fields_of_those_of_one_agent() -> None:
    assert {*AgentMeasures.__struct_fields__} == {*Measures.__struct_fields__, "agent"}
    assert {*AgentActions.__struct_fields__} == {*Actions.__struct_fields__, "agent"}
    assert field_docs(AgentMeasures)["collision"] == field_docs(Measures)["collision"]
