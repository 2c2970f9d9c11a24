"""What holds for every message: immutable, named on the wire by one rule, and no longer than what it says."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from inspect import Parameter
from typing import Any

import msgspec
import pytest
from msgspec.structs import fields

from intellwheels_schemas import messages
from intellwheels_schemas.messages import DOCUMENTS, EVENT_CODES, MAX_INTEGER, ROOTS, Actions, Record

RECORDS = [
    kind
    for kind in vars(messages).values()
    if isinstance(kind, type) and issubclass(kind, Record) and kind is not Record
]
OTHERWISE = {"gps": "GPS", "imu": "IMU", "sender": "From"}
"""Names on the wire that are not their name here: abbreviations, and a word of Python's own."""
each = pytest.mark.parametrize("kind", RECORDS, ids=[kind.__name__ for kind in RECORDS])


def types_in(kind: Any) -> Iterator[Any]:
    """Yield a field's type and all that it is made of."""
    yield kind
    for name in ("item_type", "types", "item_types", "key_type", "value_type"):
        inner = getattr(kind, name, ())
        for one in inner if isinstance(inner, tuple) else (inner,):
            yield from types_in(one)


@each
def test_a_message_is_immutable_and_written_by_names_only(kind: type[Record]) -> None:
    config = kind.__struct_config__
    assert (config.frozen, config.omit_defaults, config.forbid_unknown_fields) == (True, True, True)
    assert {parameter.kind for parameter in inspect.signature(kind).parameters.values()} <= {Parameter.KEYWORD_ONLY}


@each
def test_a_name_on_the_wire_is_the_name_here_in_pascal_case(kind: type[Record]) -> None:
    for field in fields(kind):
        usual = "".join(part.capitalize() for part in field.name.split("_"))
        assert field.encode_name == OTHERWISE.get(field.name, usual)


@pytest.mark.parametrize("kind", [kind for kind in RECORDS if not any(field.required for field in fields(kind))])
def test_a_message_of_defaults_takes_two_bytes(kind: type[Record]) -> None:
    assert msgspec.json.encode(kind()) == b"{}"


@each
def test_every_whole_number_fits_into_every_languages_json(kind: type[Record]) -> None:
    for field in msgspec.inspect.type_info(kind).fields:  # type: ignore[attr-defined]
        for one in types_in(field.type):
            if isinstance(one, msgspec.inspect.IntType):
                low = one.ge if one.ge is not None else one.gt
                high = one.le if one.le is not None else one.lt
                assert low is not None, field.name
                assert high is not None, field.name
                assert -MAX_INTEGER <= low <= high <= MAX_INTEGER


@each
def test_every_text_has_a_form_or_a_list_of_words(kind: type[Record]) -> None:
    for field in msgspec.inspect.type_info(kind).fields:  # type: ignore[attr-defined]
        for one in types_in(field.type):
            if isinstance(one, msgspec.inspect.StrType):
                assert one.pattern is not None, field.name
                assert one.max_length is not None, field.name


def test_a_root_is_the_name_of_its_class_but_for_two() -> None:
    assert {root: kind.__name__ for kind, root in ROOTS.items() if kind.__name__ != root} == {
        "Power": "PowerInForce", "Say": "OperatorSay",
    }  # fmt: skip
    assert sum(len(kinds) for kinds in DOCUMENTS.values()) == len(ROOTS)


def test_a_message_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        Actions().left_motor = 1.0  # type: ignore[misc]


def test_codes_are_words_said_once() -> None:
    for codes in (EVENT_CODES, messages.ERROR_CODES, messages.REFUSED_CODES, messages.RESULT_CODES):
        assert len(set(codes)) == len(codes)
        assert all(code.replace("-", "").isalpha() and code.islower() for code in codes)
