"""CONTRIBUTING names files and things as they are."""

from __future__ import annotations

import functools
import re
from importlib.util import find_spec
from pathlib import Path

import pytest

from intellwheels_schemas.channels import CHANNELS
from tests.every_case import every_case

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


def test_files_are_there() -> None:
    named = set(quoted(r"[\w./-]+\.(py|md|xml|csv|json|jsonl|json5|svg|toml)")) - TO_BE_MADE
    assert named
    assert [name for name in named if not any(f"/{file}".endswith(f"/{name}") for file in FILES)] == []


def test_folders_and_packages_are_there() -> None:
    found = {name: name.rstrip("/") for name in quoted(r"\w[\w./-]*/[\w-]+/?") if name not in TO_BE_MADE}
    named = {
        name: folder
        for name, folder in found.items()
        if not re.match(r"(in|out|user|ctl|join|leave|body|state|crew|iw)/", name)
    }
    assert named
    assert [name for name, folder in named.items() if not any(f"/{folder}/" in f"/{file}" for file in FILES)] == []


def test_names_stand_in_the_sources() -> None:
    named = quoted(r"_?[a-z]\w*_\w+|[A-Z]\w+[a-z]\w*|[A-Z]+_[A-Z_]+|rows\.[A-Z_]+")
    assert named
    lacking = []
    for name in named:
        word = name.rpartition(".")[2]
        snake = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", word).lower()  # a field of the wire
        if not {word, snake} & words():
            lacking.append(name)
    assert lacking == []


@every_case("key", [channel.key for channel in CHANNELS.values()])
def test_every_key_has_its_files(key: str) -> None:
    assert f"`{key}`" in TEXT


@every_case("module", sorted(set(re.findall(r"python -m ([\w.]+)", TEXT))))
def test_module_that_is_run_is_there(module: str) -> None:
    assert find_spec(module) is not None


@pytest.mark.parametrize("target", re.findall(r"\]\((?!http)([^)#]+)\)", TEXT))
def test_link_leads_somewhere(target: str) -> None:
    assert (ROOT / target).exists()
