"""How the house is kept: one source file, one test file, at the same path."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TESTS = ROOT / "tests"
ROOMS = {
    "intellwheels_schemas": "schemas",
    "intellwheels_maps": "maps",
    "intellwheels_server": "server",
    "intellwheels_agents": "agents",
    "intellwheels_experiments": "experiments",
    "intellwheels_viewer": "viewer",
}
"""The folder of tests of each package."""

TABLES = {
    "intellwheels_server/kernels/rows.py",
    "intellwheels_server/world/kernels/rows.py",
}
"""Files that only give names to numbers: what they say is tested where it is used."""

FOR_USERS = "intellwheels_agents/starter/template"
"""What `iw-agent new` copies: `tests/agents/test_starter.py` runs the copy as a whole."""


def packages() -> Iterator[tuple[str, Path]]:
    for package, room in ROOMS.items():
        (folder,) = ROOT.glob(f"*/{package}")
        yield room, folder


def has_code(path: Path) -> bool:
    """Return whether a file defines or does anything: beside its docstring, imports and plain names."""
    plain = (ast.Import, ast.ImportFrom, ast.Expr, ast.Assign, ast.AnnAssign)
    return not all(isinstance(node, plain) for node in ast.parse(path.read_text()).body)


def expected_tests(room: str, inside: Path) -> list[Path]:
    """Return where the tests of a source file may be, the path inside its package given."""
    folder, name = TESTS / room / inside.parent, inside.stem
    if name == "__main__":
        return [folder / "test_main.py"]
    if name == "__init__":
        # What a package itself does is tested beside its files or above them; the entry of a command, with the command.
        package = inside.parent.name
        return [folder / f"test_{package}.py", folder.parent / f"test_{package}.py", folder / "test_main.py"]
    return [folder / f"test_{name}.py"]


SOURCES = [
    (room, package, path.relative_to(package))
    for room, package in packages()
    for path in sorted(package.rglob("*.py"))
    if not path.is_relative_to(package.parent / FOR_USERS)
]


@pytest.mark.parametrize(
    ("room", "package", "inside"), SOURCES, ids=[f"{package.name}/{inside}" for _, package, inside in SOURCES]
)
def test_every_source_file_has_the_test_file_of_its_path(room: str, package: Path, inside: Path) -> None:
    if f"{package.name}/{inside}" in TABLES or (inside.name == "__init__.py" and not has_code(package / inside)):
        return
    expected = expected_tests(room, inside)
    assert any(path.exists() for path in expected), f"expected {expected[0].relative_to(ROOT)}"


def test_a_table_has_no_code() -> None:
    found = [
        package.parent / table for _, package in packages() for table in TABLES if (package.parent / table).exists()
    ]
    assert found
    assert [path for path in found if has_code(path)] == []
