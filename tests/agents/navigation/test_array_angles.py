"""Sines of arrays are those of the mathematics, from operations that are the same everywhere."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

from intellwheels_agents.navigation import array_angles
from intellwheels_agents.navigation.array_angles import sines, wrapped_all
from tests.every_case import every_case

FOLDER = Path(array_angles.__file__).parent
ROUNDED_RIGHT = {
    "abs", "absolute", "all", "any", "append", "arange", "argmax", "argmin", "argsort", "array", "asarray",
    "broadcast_to", "clip", "column_stack", "concatenate", "cumsum", "empty", "flatnonzero", "float32",
    "float64", "floor", "full",
    "full_like", "inf", "int64", "isfinite", "maximum", "meshgrid", "min", "minimum", "ones",
    "pad", "random", "roll", "searchsorted",
    "sort", "sqrt", "stack", "uint64", "unique", "where", "zeros", "zeros_like", "bool_", "floating",
}  # fmt: skip
"""What of numpy gives the same bits on every processor: no elementary function, and no sum in an order of its own."""


def test_sines_and_cosines_are_those_of_the_mathematics() -> None:
    angles = np.linspace(-60.0, 60.0, 5001)
    sine, cosine = sines(angles)
    assert np.abs(sine - np.sin(angles)).max() < 4e-16
    assert np.abs(cosine - np.cos(angles)).max() < 4e-16


def test_wrapped_angles_are_within_half_a_turn() -> None:
    assert wrapped_all(np.array([0.5, 7.0, -7.0])) == pytest.approx([0.5, 7.0 - 2 * np.pi, 2 * np.pi - 7.0])


@every_case("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.name)
def test_package_uses_of_numpy_only_what_is_the_same_everywhere(path: Path) -> None:
    used = {
        node.attr
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "np"
    }
    assert used <= ROUNDED_RIGHT
    methods = {
        node.func.attr
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    }
    assert not methods & {"sum", "mean", "std", "var", "dot", "einsum"}
