from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.every_case import every_case
from tests.schemas.documents import GROWN, REFUSED, SCHEMAS, class_name, json_validator, vectors


@pytest.mark.parametrize("folder", ["reader", "writer"])
@every_case("path", vectors("json"), ids=lambda path: path.name)
def test_every_vector_is_valid(path: Path, folder: str) -> None:
    validator = json_validator(class_name(path), folder)
    assert [error.message for error in validator.iter_errors(json.loads(path.read_bytes()))] == []


@pytest.mark.parametrize("name", ["Measures-first.json", "Refused.json"])
def test_unknown_fields_pass_a_reader_and_no_writer(name: str) -> None:
    document = json.loads((GROWN / name).read_bytes())
    assert json_validator(class_name(GROWN / name), "reader").is_valid(document)
    assert not json_validator(class_name(GROWN / name), "writer").is_valid(document)


def test_unknown_fields_pass_at_every_depth_and_known_ones_are_checked() -> None:
    document = json.loads((SCHEMAS / "vectors" / "Measures.json").read_bytes())
    document["Sensors"]["Sniffer"] = [{"Id": "nose"}]
    document["Sensors"]["Proximity"][0]["Colour"] = "red"
    assert json_validator("Measures", "reader").is_valid(document)
    document["Sensors"]["Proximity"][0]["Value"] = "far"
    assert not json_validator("Measures", "reader").is_valid(document)


@every_case("folder", ["reader", "writer"])
@every_case(
    "name",
    [
        "Actions-left-motor-word.json", "Actions-left-motor-high.json", "Actions-say-null.json",
        "Actions-say-control.json", "Actions-say-surrogate.json", "Actions-goal-half.json", "Actions-run-capital.json",
        "Actions-tick-high.json", "Actions-leave-number.json", "Say-no-text.json", "Robot-cone-zero.json",
        "Robot-inertia-one.json", "Robot-name-star.json", "UserInput-button.json", "Speed-zero.json",
        "Robot-both-forms.json", "Robot-no-form.json", "Robot-mind-with-motors.json", "Robot-source-real.json",
        "Load-neither.json", "Load-both.json", "Measures-value-without-ok.json", "Pose-covariance.json",
    ],
)  # fmt: skip
def test_wrong_fields_are_invalid(name: str, folder: str) -> None:
    validator = json_validator(class_name(REFUSED / name), folder)
    assert not validator.is_valid(json.loads((REFUSED / name).read_bytes()))


@pytest.mark.parametrize("name", ["InputHeader", "InputTick", "TraceHeader", "TraceTick"])
def test_lines_of_files_have_a_schema_for_readers(name: str) -> None:
    assert json_validator(name, "reader").is_valid(5) is False
