"""Reads maps, robots and scenes by name or by path. Only this file of the package reads files.

A plain word is the name of an included file. Text that contains `/` or ends as the name of a file does is a path. A map
may be in a format of `importers`; `#LEVEL` after the path chooses a level of a building, unless a file has the whole
name. A returned document has passed its schema and its checks. Otherwise a `WireError` gives the file, the line and
what was expected.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Final, Literal, TypeAlias, TypeVar, get_args

from intellwheels_maps import importers
from intellwheels_maps.check import Finding, check_map, check_robot, check_scene
from intellwheels_maps.importers import Imported
from intellwheels_maps.importers.floor_source import MAX_SOURCE_BYTES, FloorSource
from intellwheels_maps.starts import check_starts
from intellwheels_schemas.errors import WireError, got_of
from intellwheels_schemas.explain import did_you_mean, too_long
from intellwheels_schemas.files import read_with_lines
from intellwheels_schemas.messages import Bridge, Map, Record, Robot, Scene

Shelf: TypeAlias = Literal["floors", "robots", "scenes"]

_Document = TypeVar("_Document", bound=Record)

ENDINGS: Final = (".xml", ".py", *importers.ENDINGS)
"""What the name of a file ends in: a map, a robot or a scene, a mind, and a map of another program."""


def is_path(name_or_path: str | Path) -> bool:
    """Return whether a text is the path of a file, otherwise it is the name of an included one.

    A path has a `/`, or ends as the name of a file does. Whatever takes a name or a path asks here.
    """
    if isinstance(name_or_path, Path) or "/" in name_or_path:
        return True
    return name_or_path.endswith(ENDINGS) or _split(name_or_path)[0].endswith(importers.ENDINGS)


def folder_of(name_or_path: str | Path) -> Path | None:
    """Return the absolute folder of a file, from which the paths in it start; None for an included one."""
    return Path(name_or_path).absolute().parent if is_path(name_or_path) else None


def names(shelf: Shelf) -> list[str]:
    """Return the sorted names of the included maps (`floors`), robots or scenes.

    Raises:
        ValueError: `shelf` is not `floors`, `robots` or `scenes`.
    """
    if shelf not in get_args(Shelf):
        raise ValueError(f"shelf: expected one of {', '.join(get_args(Shelf))}, got {shelf!r}")
    return sorted(entry.name[:-4] for entry in _shelf(shelf).iterdir() if entry.name.endswith(".xml"))


def floor(name_or_path: str | Path, *, beside: Path | None = None) -> Map:
    """Return a map.

    Args:
        name_or_path: The name of an included map, or a path.
        beside: The folder from which relative paths start; default: the working directory.

    Raises:
        WireError: There is no such map, or its file is invalid.
    """
    if not is_path(name_or_path):
        return _included_floor(str(name_or_path))
    file = _find("floors", name_or_path, beside)
    if isinstance(file, Path) and is_foreign(file):
        return imported(file).map
    return _load(Map, file, check_map)


@cache
def _included_floor(name: str) -> Map:
    """Return an included map, read once: a document cannot be changed."""
    return _load(Map, _find("floors", name, None), check_map)


def imported(file: Path) -> Imported:
    """Return the map in a file of another program, and what was left out.

    Args:
        file: Its path; `#LEVEL` at the end chooses a level of a building.

    Raises:
        WireError: The file is invalid, or what it describes is no valid map.
    """
    path, level = _file_and_level(file)

    def beside(name: str) -> bytes:
        return _read(Path(path).parent / name)

    found = importers.import_floor(FloorSource(path, _read(Path(path)), beside, level))
    findings = check_map(found.map)
    if findings:
        texts = [f"{path}: {finding.element}: {finding.text}" for finding in findings]
        raise WireError("value", "\n".join(texts), path)
    return found


def is_foreign(file: Path) -> bool:
    """Return whether a file is a floor of another program, which `imported` reads."""
    path = _file_and_level(file)[0]
    return path.endswith(importers.ENDINGS) or (path.endswith(".xml") and importers.is_lab(_start(Path(path))))


def _start(path: Path) -> bytes:
    """Return the first bytes of a file; none if it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(1 << 16)
    except OSError:
        return b""


def _split(path: str) -> tuple[str, str | None]:
    """Return a path without `#LEVEL`, and the level."""
    name, mark, level = path.rpartition("#")
    return (name, level) if mark and name.endswith(importers.ENDINGS) and "/" not in level else (path, None)


def _file_and_level(file: Path) -> tuple[str, str | None]:
    """Return a path without `#LEVEL`, and the level. A file that has the whole name is meant as such."""
    return (str(file), None) if file.is_file() else _split(str(file))


def _read(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            data = file.read(MAX_SOURCE_BYTES + 1)
    except (OSError, ValueError) as error:
        got = got_of(error) if isinstance(error, OSError) else "no path"
        raise WireError("value", f"{path}: expected a file, got {got}", str(path)) from None
    if len(data) > MAX_SOURCE_BYTES:
        raise too_long(str(path), MAX_SOURCE_BYTES, "bytes", path.stat().st_size)
    return data


def robot(name_or_path: str | Path, *, beside: Path | None = None) -> Robot:
    """Return a robot document, without the name, role, instance and place that are set when an agent joins.

    Args:
        name_or_path: The name of an included robot, or a path.
        beside: The folder from which relative paths start; default: the working directory.

    Raises:
        WireError: There is no such robot, or its file is invalid.
    """
    if not is_path(name_or_path):
        return _included_robot(str(name_or_path))
    return _load(Robot, _find("robots", name_or_path, beside), check_robot)


@cache
def _included_robot(name: str) -> Robot:
    return _load(Robot, _find("robots", name, None), check_robot)


def scene(name_or_path: str | Path, *, beside: Path | None = None) -> Scene:
    """Return a scene whose map, robots and places all exist. The minds are not checked.

    Args:
        name_or_path: The name of an included scene, or a path. Paths in a scene start from the folder of the scene.
        beside: The folder from which relative paths start; default: the working directory.

    Raises:
        WireError: There is no such scene, or its file or a file that it uses is invalid.
    """
    file = _find("scenes", name_or_path, beside)
    folder = file.parent if isinstance(file, Path) else None

    def check(document: Scene) -> list[Finding]:
        ground = floor(document.map, beside=folder)
        findings = check_scene(document, ground)
        bodies: dict[str, Robot] = {}
        for index, cast in enumerate(document.cast):
            try:
                if cast.robot:
                    bodies[cast.name] = robot(cast.robot, beside=folder)
            except WireError as error:
                findings.append(Finding(f"Scene.Cast[{index}]", f"agent {cast.name!r}: {error.text}"))
        for where, bridge in _bridges(document):
            try:
                if bridge.chair is not None:
                    robot(bridge.chair, beside=folder)
            except WireError as error:
                findings.append(Finding(where, f"chair of {bridge.agent!r}: {error.text}"))
        for bridge in document.bridge:
            # Real chairs are accepted at any pose.
            bodies.pop(bridge.agent, None)
        return findings or check_starts(document, ground, bodies)

    return _load(Scene, file, check)


def _bridges(document: Scene) -> Iterator[tuple[str, Bridge]]:
    for index, bridge in enumerate(document.bridge):
        yield f"Scene.Bridge[{index}]", bridge
    for number, factor in enumerate(document.experiment.factor if document.experiment else ()):
        for at, level in enumerate(factor.level):
            for index, bridge in enumerate(level.bridge):
                yield f"Scene.Experiment.Factor[{number}].Level[{at}].Bridge[{index}]", bridge


def _shelf(shelf: Shelf) -> Traversable:
    return files("intellwheels_maps").joinpath(shelf)


def _find(shelf: Shelf, name_or_path: str | Path, beside: Path | None) -> Path | Traversable:
    text = str(name_or_path)
    if is_path(name_or_path):
        return (beside or Path()) / text
    known = names(shelf)
    if text not in known:
        kind = "maps" if shelf == "floors" else shelf
        endings = (".xml", *importers.ENDINGS) if shelf == "floors" else (".xml",)
        expected = f"expected one of the {kind} ({', '.join(known)}) or a path ending in {_listed(endings)}"
        raise WireError("value", f"{expected}, got {text!r}{did_you_mean(text, known)}", shelf)
    return _shelf(shelf).joinpath(f"{text}.xml")


def _listed(words: Sequence[str]) -> str:
    return " or ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)


def _load(
    kind: type[_Document], file: Path | Traversable, check: Callable[[_Document], Sequence[Finding]]
) -> _Document:
    document, lines = read_with_lines(kind, file)
    findings = check(document)
    if findings:
        texts = [f"{file}:{lines.at(finding.element)}: {finding.text}" for finding in findings]
        raise WireError("value", "\n".join(texts), f"{file}:{lines.at(findings[0].element)}")
    return document
