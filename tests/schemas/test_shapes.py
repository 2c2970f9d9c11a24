from __future__ import annotations

import math

import pytest

from intellwheels_schemas.messages import Actions, LidarReading, Place, Result, Robot
from intellwheels_schemas.shapes import Form, number_text, shape_of
from intellwheels_schemas.vectors import NAMES


def test_every_document_has_a_shape() -> None:
    for cls in NAMES.values():
        shape = shape_of(cls)
        assert [member.name for member in shape.members] == list(cls.__struct_fields__)
        assert len(shape.by_wire) == len(shape.members)


def test_names_on_the_wire_are_in_pascal_case() -> None:
    for cls in NAMES.values():
        for wire in shape_of(cls).by_wire:
            assert wire[0].isupper()
            assert "_" not in wire
    assert {"GPS", "IMU"} <= shape_of(Robot).by_wire.keys()


def test_units_bounds_and_forms_are_those_of_the_annotations() -> None:
    robot = shape_of(Robot).by_wire
    top_speed = robot["TopSpeed"].scalar
    assert top_speed is not None
    assert (top_speed.unit, top_speed.low, top_speed.high) == ("m/s", 0.0, 50.0)
    inertia = robot["AccelerationCurve"].scalar
    assert inertia is not None
    assert inertia.high_open
    assert robot["UserInput"].form is Form.LIST
    assert robot["Part"].form is Form.RECORDS
    assert robot["Part"].max_count == 32
    assert robot["Position"].form is Form.RECORD
    assert shape_of(Actions).by_wire["Say"].form is Form.ELEMENT
    content = shape_of(Result).content
    assert content is not None
    assert content.wire == "Text"
    ranges = shape_of(LidarReading).by_wire["Ranges"].scalar
    assert ranges is not None
    assert ranges.nullable
    assert shape_of(Place).root == "Place"


@pytest.mark.parametrize(
    ("number", "text"),
    # The three where Python's own repr differs, as msgspec writes them.
    [(5.0, "5.0"), (0.00001, "0.00001"), (1e-7, "1e-7"), (1e16, "1e16"), (-0.0, "-0.0"), (3, "3")],
)
def test_numbers_are_written_as_json_has_them(number: float, text: str) -> None:
    assert number_text(number) == text


def test_number_that_is_not_finite_has_no_text() -> None:
    with pytest.raises(ValueError, match="expected a finite number"):
        number_text(math.nan)
