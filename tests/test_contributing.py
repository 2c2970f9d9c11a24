"""CONTRIBUTING names files and things as they are."""

from __future__ import annotations

import functools
import re
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "CONTRIBUTING.md").read_text()
ROOMS = ("schemas", "server", "agents", "viewer", "maps", "tests")

TO_BE_MADE = {
    "minds/wander.py", "floors/hall.xml", "plan.svg", "agents/intellwheels_agents/NAME_gateway.py", "router.json5",
    "run.jsonl", "input.jsonl", "trace.jsonl", "maps/intellwheels_maps/importers/", "tests/maps/importers/",
}  # fmt: skip
"""What a reader of it makes, or a command writes."""

FILES = [str(path.relative_to(ROOT)) for room in ROOMS for path in (ROOT / room).rglob("*") if path.is_file()]
FILES += [path.name for path in ROOT.iterdir() if path.is_file()]
SOURCES = [
    file
    for file in FILES
    if file.endswith((".py", ".toml")) and file not in ("tests/test_house.py", "tests/test_contributing.py")
]


@functools.cache
def words() -> set[str]:
    """Return the words of all sources."""
    return {word for file in SOURCES for word in re.findall(r"\w+", (ROOT / file).read_text())}


def quoted(pattern: str) -> list[str]:
    """Return what stands between backquotes in the text, outside blocks of code, and matches."""
    text = re.sub(r"```.*?```", "", TEXT, flags=re.DOTALL)
    return sorted({word for word in re.findall(r"`([^`\n]+)`", text) if re.fullmatch(pattern, word)})


@pytest.mark.parametrize("name", quoted(r"[\w./-]+\.(py|md|xml|csv|json|jsonl|json5|svg|toml)"))
def test_file_is_there(name: str) -> None:
    if name not in TO_BE_MADE:
        assert [file for file in FILES if file == name or file.endswith(f"/{name}")], name


@pytest.mark.parametrize("name", quoted(r"\w[\w./-]*/[\w-]+/?"))
def test_folder_or_package_is_there(name: str) -> None:
    folder = name.rstrip("/")
    if name in TO_BE_MADE or re.match(r"(in|out|user|ctl|join|leave|body|state|crew|iw)/", name):
        return
    assert any(f"/{folder}/" in f"/{file}" for file in FILES), name


@pytest.mark.parametrize("name", quoted(r"_?[a-z]\w*_\w+|[A-Z]\w+[a-z]\w*|[A-Z]+_[A-Z_]+|rows\.[A-Z_]+"))
def test_name_stands_in_the_sources(name: str) -> None:
    word = name.rpartition(".")[2]
    snake = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", word).lower()  # a field of the wire
    assert {word, snake} & words(), name


@pytest.mark.parametrize("module", sorted(set(re.findall(r"python -m ([\w.]+)", TEXT))))
def test_module_that_is_run_is_there(module: str) -> None:
    assert find_spec(module) is not None


@pytest.mark.parametrize("target", re.findall(r"\]\((?!http)([^)#]+)\)", TEXT))
def test_link_leads_somewhere(target: str) -> None:
    assert (ROOT / target).exists()
