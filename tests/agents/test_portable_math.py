"""The functions of minds have the bits of the world's, and no mind uses the C library's."""

from __future__ import annotations

import ast
import math
import random
import struct
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Final

import pytest

from intellwheels_agents import portable_math
from intellwheels_agents.portable_math import (
    acos,
    asin,
    atan,
    atan2,
    cos,
    dist,
    exp,
    hypot,
    log,
    power,
    sin,
    sincos,
    tan,
)
from intellwheels_server.world.kernels import elementary
from tests.every_case import every_case

ROOT = Path(__file__).parents[2]
SAME_EVERYWHERE = {
    "sqrt", "floor", "ceil", "trunc", "copysign", "fabs", "fmod", "remainder", "radians", "degrees", "fsum", "isclose",
    "isfinite", "isinf", "isnan", "nextafter", "pi", "tau", "e", "inf", "nan",
}  # fmt: skip
"""What of `math` a mind may use."""
FORBIDDEN_MODULES = {"cmath", "numpy", "scipy", "statistics"}

DRAW = random.Random(3)
ANGLES = [
    0.0, -0.0, *(DRAW.uniform(-7.0, 7.0) for _ in range(2000)), *(DRAW.uniform(-1e6, 1e6) for _ in range(1000)),
    *(k * math.pi / 4.0 for k in range(-200, 200)), *(math.nextafter(k * math.pi / 2.0, 0.0) for k in range(-200, 200)),
    *(DRAW.uniform(-1.0, 1.0) * 10.0 ** DRAW.uniform(-12.0, 6.0) for _ in range(1000)),
]  # fmt: skip
EXPONENTS = [*(DRAW.uniform(-745.0, 709.7) for _ in range(1000)), *(DRAW.uniform(-745.1, -700.0) for _ in range(200))]


def bits(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}d", *values)


def ulps(found: float, expected: float) -> float:
    return abs(found - expected) / math.ulp(expected)


def test_functions_have_the_bits_of_the_worlds() -> None:
    for x in ANGLES:
        assert bits(sin(x), cos(x), *sincos(x)) == bits(elementary.sin(x), elementary.cos(x), *elementary.sincos(x)), x
        if x != 0.0:
            assert bits(log(abs(x))) == bits(elementary.log(abs(x))), x
    for y, x in pairwise(ANGLES):
        assert bits(atan2(y, x)) == bits(elementary.atan2(y, x)), (y, x)
    for x in EXPONENTS:
        assert bits(exp(x)) == bits(elementary.exp(x)), x
    assert bits(log(5e-324)) == bits(elementary.log(5e-324))


def test_functions_are_those_of_the_mathematics() -> None:
    for x in ANGLES:
        for ours, theirs in ((sin, math.sin), (cos, math.cos)):
            assert ulps(ours(x), theirs(x)) <= 2.0, x
        assert ulps(atan(x), math.atan(x)) <= 2.0
        assert tan(x) == pytest.approx(math.tan(x), rel=1e-14)
        assert hypot(x, 2.0) == pytest.approx(math.hypot(x, 2.0), rel=1e-15)
        assert dist((x, 1.0), (0.5, 3.0)) == pytest.approx(math.dist((x, 1.0), (0.5, 3.0)), rel=1e-15)
        if abs(x) <= 1.0:
            assert asin(x) == pytest.approx(math.asin(x), rel=1e-14)
            assert acos(x) == pytest.approx(math.acos(x), rel=1e-14)
    for x in EXPONENTS:
        assert ulps(exp(x), math.exp(x)) <= 2.0
    for x in (1e-300, 0.3, 1.0, 7.0, 1e300):
        assert ulps(log(x), math.log(x)) <= 2.0 or x == 1.0
        assert power(x, 0.7) == pytest.approx(x**0.7, rel=1e-12)
    assert log(1.0) == 0.0
    for p, q in (((1.0, 2.0, 3.0), (1.0, 2.0, 4.0)), ((1.0, 2.0), (1.0,))):
        with pytest.raises(ValueError, match="values to unpack"):
            dist(p, q)


def test_angle_of_many_turns_is_reduced_and_none_at_all_is_an_error() -> None:
    assert sin(1e9 * math.tau + 0.5) == pytest.approx(math.sin(0.5), abs=1e-5)
    for x in (sin(math.nan), cos(math.nan), atan2(math.nan, 1.0), atan2(1.0, math.nan), exp(math.nan), log(math.nan)):
        assert math.isnan(x)
    calls: list[tuple[Callable[[float], float], float]] = [
        (sin, math.inf), (cos, -math.inf), (log, 0.0), (log, -1.0), (asin, 2.0), (acos, -2.0),
    ]  # fmt: skip
    for function, value in calls:
        with pytest.raises(ValueError, match=r"math domain error|expected a "):
            function(value)
    with pytest.raises(OverflowError):
        exp(710.0)
    assert (exp(-746.0), exp(-math.inf), log(math.inf)) == (0.0, 0.0, math.inf)


def test_directions_on_the_axes_are_exact() -> None:
    assert [atan2(y, x) for y, x in ((0.0, 1.0), (1.0, 0.0), (-0.0, -1.0), (-1.0, 0.0), (0.0, 0.0))] == [
        0.0, math.pi / 2.0, math.pi, -math.pi / 2.0, 0.0,
    ]  # fmt: skip


# ---------------------------------------------------------------- the guard


GATEWAYS: Final = {"ros_gateway", "record_gateway", "ciber_gateway"}
"""Packages that exchange the numbers of a world with other programs: no run with those repeats by itself."""

MEASURED: Final = {"joystick/input_latency.py", "bridge/luci_readings.py"}
"""Files whose numbers come from clocks and real sensors: they never repeat."""


def mind_code() -> list[Path]:
    """Return every file whose numbers may reach the world: agents, bridges, examples, and the template."""
    agents = ROOT / "agents"
    files = [*(agents / "intellwheels_agents").rglob("*.py"), *(agents / "examples").rglob("*.py")]
    return [
        path
        for path in files
        if path.name != "portable_math.py"
        and not {"__pycache__", *GATEWAYS} & {*path.parts}
        and f"{path.parent.name}/{path.name}" not in MEASURED
    ]


def faults(code: str) -> Iterator[str]:
    """Yield what gives other bits elsewhere, as `line: what`."""
    for node in ast.walk(ast.parse(code)):
        line = getattr(node, "lineno", 0)
        match node:
            case ast.Attribute(value=ast.Name(id="math"), attr=name) if name not in SAME_EVERYWHERE:
                yield f"{line}: math.{name}"
            case ast.ImportFrom(module="math", names=names):
                yield from (f"{line}: math.{each.name}" for each in names if each.name not in SAME_EVERYWHERE)
            case ast.Import(names=names):
                roots = {each.name.partition(".")[0] for each in names}
                yield from (f"{line}: {root}" for root in roots & FORBIDDEN_MODULES)
            case ast.ImportFrom(module=str(module)) if module.partition(".")[0] in FORBIDDEN_MODULES:
                yield f"{line}: {module}"
            case ast.BinOp(op=ast.Pow(), left=left, right=right) if not (_is_whole(left) and _is_whole(right)):
                yield f"{line}: **"
            case ast.Call(func=ast.Name(id="pow" | "sum" as name)):
                yield f"{line}: {name}"
            case ast.Attribute(attr="gauss" | "normalvariate" | "expovariate" as name):
                yield f"{line}: {name}"


NUMPY: Final = "navigation"
"""The package that uses numpy. `navigation/test_array_angles.py` holds what of numpy it may use."""


def _is_whole(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int)


@every_case("path", mind_code(), ids=lambda path: str(path.relative_to(ROOT / "agents")))
def test_no_mind_uses_what_differs_between_machines(path: Path) -> None:
    found = list(faults(path.read_text()))
    if path.parent.name == NUMPY:
        found = [fault for fault in found if not fault.endswith(": numpy")]
    assert found == []


@every_case(
    ("code", "fault"),
    [
        ("import math\nmath.sin(1.0)", "2: math.sin"),
        ("from math import pi, hypot", "1: math.hypot"),
        ("import numpy as np", "1: numpy"),
        ("from statistics import mean", "1: statistics"),
        ("def f(x):\n    return x**2", "2: **"),
        ("pow(2.0, 0.5)", "1: pow"),
        ("sum([0.1, 0.2])", "1: sum"),
        ("random.gauss(0.0, 1.0)", "1: gauss"),
    ],
)
def test_guard_finds_a_planted_fault(code: str, fault: str) -> None:
    assert list(faults(code)) == [fault]


def test_guard_allows_what_the_module_says_is_the_same_everywhere() -> None:
    assert list(faults("import math\nfrom math import sqrt\nx = math.radians(3.0) + 2**31 + math.fsum([1.0])")) == []
    documented = (portable_math.__doc__ or "").split("These of `math` are the same everywhere:")[1].split("and the")[0]
    named = {word.strip("` ,\n") for word in documented.split()} - {""}
    assert named == SAME_EVERYWHERE - {"pi", "tau", "e", "inf", "nan"}
