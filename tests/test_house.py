"""How the house is kept: a test file for each source file, short files, nothing left at an old place."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
TESTS = ROOT / "tests"
ROOMS = {
    "intellwheels_schemas": "schemas",
    "intellwheels_maps": "maps",
    "intellwheels_server": "server",
    "intellwheels_gym": "gym",
    "intellwheels_agents": "agents",
    "intellwheels_experiments": "experiments",
    "intellwheels_viewer": "viewer",
}
"""The folder of tests of each package."""

TABLES = {
    "intellwheels_agents/bridge/timeouts.py",
    "intellwheels_schemas/defaults.py",
    "intellwheels_server/world/kernels/rows.py",
    "intellwheels_viewer/range_bands.py",
}
"""Files that only give names to numbers: what they say is tested where it is used."""

LONGEST = 400
"""Lines of a source file."""

LONG_TABLES = {"intellwheels_schemas/messages.py", "intellwheels_schemas/vectors.py"}
"""Tables that may be longer: every message with its fields, and every golden vector."""

REPLACED = """
    server: admission anew cadence changes complaint conductor desk fleet floor hiding intake log membership
        parts placing player publication reception recording reported reports ring service slots
        state step trace tray verbs walls
        warming kernels sensors world.py
    server/world: inputs
    agents/experiments: batch.py children check ensemble film keep page plan plugin processes record
        report rig rows run.py stand trace trial watch what_if
    agents: chair equipment network path pilot projection ring seen surroundings user
    agents/bridge: chair driver estimate faults laboratory motors offset outfit pairing port protocol pump source stick
    agents/joystick: grip hand keys network script window wish words
    viewer: aiming fold guard hand hover layering moving network placing recording seen service
    viewer/drawings: batch car chair contacts door floor footprints forms layers lidar model models person
        plain table walls
    viewer/panels: footprints layers plan sheet figures
"""
"""Names of files and packages that a renaming replaced, by folder."""

FOLDERS = {
    "server": "server/intellwheels_server",
    "server/world": "server/intellwheels_server/world",
    "agents/experiments": "agents/intellwheels_experiments",
    "agents": "agents/intellwheels_agents",
    "agents/bridge": "agents/intellwheels_agents/bridge",
    "agents/joystick": "agents/intellwheels_agents/joystick",
    "viewer": "viewer/intellwheels_viewer",
    "viewer/drawings": "viewer/intellwheels_viewer/drawings",
    "viewer/panels": "viewer/intellwheels_viewer/panels",
}

FOR_USERS = "intellwheels_agents/starter/template"
"""What `iw-agent new` copies: `tests/agents/test_starter.py` runs the copy as a whole."""


def packages() -> Iterator[tuple[str, Path]]:
    for package, room in ROOMS.items():
        (folder,) = ROOT.glob(f"*/{package}")
        yield room, folder


def has_code(path: Path) -> bool:
    """Return whether a file defines or does anything: beside its docstring, imports and plain names."""
    return not all(_declares(node) for node in ast.parse(path.read_text()).body)


def _declares(node: ast.stmt) -> bool:
    """Return whether a statement is an import, a name or text, or a class without code: a record or a protocol."""
    if isinstance(node, ast.ClassDef):
        return all(_declares(part) or (isinstance(part, ast.FunctionDef) and _is_empty(part)) for part in node.body)
    return isinstance(node, (ast.Import, ast.ImportFrom, ast.Expr, ast.Assign, ast.AnnAssign))


def _is_empty(function: ast.FunctionDef) -> bool:
    return all(isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) for node in function.body)


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


def test_every_source_file_has_the_test_file_of_its_path() -> None:
    lacking = []
    for room, package, inside in SOURCES:
        expected = expected_tests(room, inside)
        if not any(path.exists() for path in expected) and has_code(package / inside):
            lacking.append(f"{package.name}/{inside}: expected {expected[0].relative_to(ROOT)}")
    assert lacking == []


def test_a_table_has_no_code() -> None:
    found = [
        package.parent / table for _, package in packages() for table in TABLES if (package.parent / table).exists()
    ]
    assert found
    assert [path for path in found if has_code(path)] == []


def test_source_files_are_short() -> None:
    long = {}
    for _, package, inside in SOURCES:
        lines = len((package / inside).read_text().splitlines())
        if lines > LONGEST and f"{package.name}/{inside}" not in LONG_TABLES:
            long[f"{package.name}/{inside}"] = f"expected at most {LONGEST} lines, got {lines}"
    assert long == {}


def test_nothing_is_left_at_an_old_place() -> None:
    left, folder = [], ""
    for word in REPLACED.split():
        if word.endswith(":"):
            folder = FOLDERS[word[:-1]]
            continue
        # A name with its ending was a file only: the package of that name is new.
        names = [word] if word.endswith(".py") else [f"{word}.py", word]
        for name in names:
            path = ROOT / folder / name
            if path.is_file() or (path.is_dir() and any(path.rglob("*.py")) and name not in {"log", "service"}):
                left.append(str(path.relative_to(ROOT)))
    assert left == []


def test_no_two_source_files_have_one_name() -> None:
    """A name tells which file is meant, wherever it is read."""
    places: dict[str, list[str]] = {}
    for _, package, inside in SOURCES:
        if inside.name not in {"__init__.py", "__main__.py"}:
            places.setdefault(inside.name, []).append(f"{package.name}/{inside}")
    assert {name: files for name, files in places.items() if len(files) > 1} == {}
