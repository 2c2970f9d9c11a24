from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest

SCHEMAS = Path(__file__).parents[2] / "schemas"
VECTORS = sorted((SCHEMAS / "vectors").glob("*.json"))


@cache
def validator(file: str) -> Any:
    name = file.replace(".", "-").partition("-")[0]
    schema = json.loads((SCHEMAS / "json" / f"{name}.json").read_bytes())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("path", VECTORS, ids=lambda path: path.name)
def test_every_vector_is_valid(path: Path) -> None:
    assert [error.message for error in validator(path.name).iter_errors(json.loads(path.read_bytes()))] == []


@pytest.mark.parametrize(
    "name",
    [
        "Actions-left-motor-word.json", "Actions-left-motor-high.json", "Actions-unknown.json", "Actions-say-null.json",
        "Actions-say-control.json", "Actions-say-surrogate.json", "Actions-goal-half.json", "Actions-run-capital.json",
        "Actions-tick-high.json", "Actions-leave-number.json", "Say-no-text.json", "Robot-cone-zero.json",
        "Robot-inertia-one.json", "Robot-name-star.json", "UserInput-button.json", "Speed-zero.json",
        "Pause-field.json",
    ],
)  # fmt: skip
def test_wrong_fields_are_invalid(name: str) -> None:
    assert not validator(name).is_valid(json.loads((SCHEMAS / "vectors" / "refused" / name).read_bytes()))
