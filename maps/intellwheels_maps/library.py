"""Reads floors, robots and scenes by name or by path. Only this file of the package reads files.

A plain word is the name of a shipped file. Text with a `/`, or that ends in `.xml`, is a path. A returned document has
passed its schema and its checks; otherwise a `WireError` names the file, the line and what was expected.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Literal, TypeAlias, TypeVar, get_args

from intellwheels_maps.check import Finding, check_map, check_robot, check_scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import read_with_lines
from intellwheels_schemas.messages import Bridge, Map, Record, Robot, Scene

Shelf: TypeAlias = Literal["floors", "robots", "scenes"]

_Document = TypeVar("_Document", bound=Record)


def names(shelf: Shelf) -> list[str]:
    """Return the sorted names of the shipped floors, robots or scenes.

    Raises:
        ValueError: `shelf` is none of these three.
    """
    if shelf not in get_args(Shelf):
        raise ValueError(f"shelf: expected one of {', '.join(get_args(Shelf))}, got {shelf!r}")
    return sorted(entry.name[:-4] for entry in _shelf(shelf).iterdir() if entry.name.endswith(".xml"))


def floor(name_or_path: str | Path, *, beside: Path | None = None) -> Map:
    """Return the map of a floor.

    Args:
        name_or_path: The name of a shipped floor, or a path.
        beside: The folder from which relative paths start; default: the working directory.

    Raises:
        WireError: There is no such floor, or its file is invalid.
    """
    return _load(Map, _find("floors", name_or_path, beside), check_map)


def robot(name_or_path: str | Path, *, beside: Path | None = None) -> Robot:
    """Return a robot document, without the name, role, instance and place that are added at joining.

    Args:
        name_or_path: The name of a shipped robot, or a path.
        beside: The folder from which relative paths start; default: the working directory.

    Raises:
        WireError: There is no such robot, or its file is invalid.
    """
    return _load(Robot, _find("robots", name_or_path, beside), check_robot)


def scene(name_or_path: str | Path, *, beside: Path | None = None) -> Scene:
    """Return a scene whose floor, robots and places all exist. Its minds are not checked.

    Args:
        name_or_path: The name of a shipped scene, or a path. Paths in a scene start from its own folder.
        beside: The folder from which relative paths start; default: the working directory.

    Raises:
        WireError: There is no such scene, or its file, or a file that it names, is invalid.
    """
    file = _find("scenes", name_or_path, beside)
    folder = file.parent if isinstance(file, Path) else None

    def check(document: Scene) -> list[Finding]:
        findings = check_scene(document, floor(document.map, beside=folder))
        for index, cast in enumerate(document.cast):
            try:
                robot(cast.robot, beside=folder)
            except WireError as error:
                findings.append(Finding(f"Scene.Cast[{index}]", f"agent {cast.name!r}: {error.text}"))
        for where, bridge in _bridges(document):
            try:
                if bridge.chair is not None:
                    robot(bridge.chair, beside=folder)
            except WireError as error:
                findings.append(Finding(where, f"chair of {bridge.agent!r}: {error.text}"))
        return findings

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
    if isinstance(name_or_path, Path) or "/" in text or text.endswith(".xml"):
        return (beside or Path()) / text
    known = names(shelf)
    if text not in known:
        kind = "maps" if shelf == "floors" else shelf
        expected = f"expected one of the {kind} ({', '.join(known)}) or a path ending in .xml"
        raise WireError("value", f"{expected}, got {text!r}", shelf)
    return _shelf(shelf).joinpath(f"{text}.xml")


def _load(
    kind: type[_Document], file: Path | Traversable, check: Callable[[_Document], Sequence[Finding]]
) -> _Document:
    document, lines = read_with_lines(kind, file)
    findings = check(document)
    if findings:
        texts = [f"{file}:{lines.at(finding.element)}: {finding.text}" for finding in findings]
        raise WireError("value", "\n".join(texts), f"{file}:{lines.at(findings[0].element)}")
    return document
