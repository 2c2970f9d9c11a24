from __future__ import annotations

import json

import pytest

from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import Repeated, check_plain, expected, object_of_pairs, shown
from intellwheels_schemas.messages import Actions
from intellwheels_schemas.shapes import Scalar, shape_of
from intellwheels_schemas.vectors import NAMES
from tests.every_case import every_case


@every_case(
    ("scalar", "words"),
    [
        (Scalar(kind="number", low=0.0, high=360.0, low_open=True, unit="deg"), "degrees in (0, 360]"),
        (Scalar(kind="number", low=0.0, high=1.0, high_open=True, unit="1"), "a number in [0, 1)"),
        (Scalar(kind="number", low=0.5, unit="m"), "metres in [0.5, inf)"),
        (Scalar(kind="integer"), "a whole number"),
        (Scalar(kind="word", words=("a", "b")), "one of a, b"),
        (Scalar(kind="word", words=("a",)), "a"),
        (Scalar(kind="truth"), "true or false"),
        (Scalar(kind="text"), "text"),
    ],
)
def test_expectation_is_in_words(scalar: Scalar, words: str) -> None:
    assert expected(scalar) == words


@every_case(
    ("value", "words"),
    [
        (None, "null"), (True, "true"), (0.0, "0"), (0.5, "0.5"), (1e300, "1e+300"), (10**30, "a very large number"),
        ("a\x00", "'a\\x00'"), ([], "a list"), ({}, "an object"), ("x" * 50, f"{'x' * 37!r} and 13 characters more"),
    ],
)  # fmt: skip
def test_value_of_a_stranger_is_shown_short(value: object, words: str) -> None:
    assert shown(value) == words


def test_name_that_comes_twice_marks_its_object() -> None:
    plain = json.loads('{"a":{"b":1,"c":2,"b":3}}', object_pairs_hook=object_of_pairs)
    assert not isinstance(plain, Repeated)
    assert isinstance(plain["a"], Repeated)
    assert plain["a"].name == "b"


def test_unknown_fields_are_taken_out_when_not_strict() -> None:
    ours = {"Session": "c0ffee0012345678", "Tick": 1}
    plain = {**ours, "New": {"Deep": None}, "Goal": {"X": 1.0, "Y": 2.0, "Z": 3.0}}
    check_plain(shape_of(Actions), plain, "Actions", strict=False)
    assert plain == {**ours, "Goal": {"X": 1.0, "Y": 2.0}}


def test_strange_name_of_a_field_is_not_repeated_as_a_place() -> None:
    with pytest.raises(WireError) as caught:
        check_plain(shape_of(Actions), {"\x1b[31m": 1}, "Actions", strict=True)
    assert caught.value.where == "Actions"
    assert "\x1b" not in caught.value.text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<Robot><Type>real</Type></Robot>",
         'Robot.Type: expected an attribute, as in <Robot Type="real">, got an element'),
        ("<Robot Part='1'/>", "Robot.Part: expected an element, as in <Robot><Part .../></Robot>, got an attribute"),
        ("<Actions Say='a'/>",
         "Actions.Say: expected an element, as in <Actions><Say>...</Say></Actions>, got an attribute"),
        ("<Say Text='a'/>", "Say.Text: expected the text of the element, as in <Say>...</Say>, got Text"),
        ("<UserInput><Buttons/></UserInput>",
         'UserInput.Buttons: expected an attribute, as in <UserInput Buttons="...">, got an element'),
    ],
)  # fmt: skip
def test_field_in_another_form_of_xml_is_told_how_to_write_it(text: str, words: str) -> None:
    root = text[1:].partition(">")[0].partition(" ")[0]
    with pytest.raises(WireError) as caught:
        decode(NAMES[root], text.encode(), Encoding.XML)
    assert (caught.value.code, caught.value.text) == ("field", words)


def test_curve_of_one_is_refused_with_the_reason() -> None:
    with pytest.raises(WireError) as caught:
        decode(NAMES["Robot"], b'{"Length":1.0,"Width":1.0,"AccelerationCurve":1.0}')
    assert caught.value.text == (
        "Robot.AccelerationCurve: expected a number in [0, 1), got 1; "
        "with 1 the motors would keep their last power for ever and never move: write 0.999"
    )
