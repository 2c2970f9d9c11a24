"""Imports labs of the Ciber-Rato simulator, the ancestor of this one: an XML file with the root `Lab`. Pure.

A unit is the diameter of that simulator's robot; here it is 1 m, so that the numbers stay the same. The walls of a lab
are solid, and its border is a wall too. A beacon is a place of that name, for beacon sensors, and a target is a zone.
The starts are in a file of their own with the root `Grid`, which is taken from beside the lab: `MyLab.xml` has its
starts in `MyGrid.xml`.
"""

from __future__ import annotations

import math
import re
from pathlib import PurePath
from typing import Any, Final

from intellwheels_maps.importers.floor_draft import FloorDraft
from intellwheels_maps.importers.floor_source import FloorSource, Imported, check_no_level
from intellwheels_schemas import elements
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown

BORDER: Final = 0.1
"""Thickness of the border, m. It is outside the lab's width and height."""

CORNERS: Final = 32
"""Corners of a target, whose outline is a circle."""

MAX_BYTES: Final = 4 << 20
"""Longest file, 4 MiB."""

MAX_ELEMENTS: Final = 50_000
"""Most elements of a file."""

_LAB: Final = re.compile(rb"(?:\xef\xbb\xbf)?(?>\s+|<\?.*?\?>|<!--.*?-->)*+<Lab[\s/>]", re.DOTALL)


def is_lab(data: bytes) -> bool:
    """Return whether the root element of an XML file is `Lab`."""
    return _LAB.match(data) is not None


def import_lab(source: FloorSource) -> Imported:
    """Return the map of a lab, with the starts of the grid beside it if there is one.

    Raises:
        WireError: One of the files is invalid.
    """
    check_no_level(source)
    root = _root(source, "Lab")
    if root.get("Format") is not None:
        raise source.error("", "expected a lab of the Ciber-Rato simulator, got the Lab of a router (iw-router --lab)")
    draft = FloorDraft(source)
    width, height = (_number(source, root, name, 0.1, 5000.0) for name in ("Width", "Height"))
    west, south, east, north = -BORDER / 2, -BORDER / 2, width + BORDER / 2, height + BORDER / 2
    border = [(west, south), (east, south), (east, north), (west, north), (west, south)]
    draft.wall(border, "Lab", thickness=BORDER)
    beacons = 0
    for element in root:
        if not isinstance(element.tag, str):
            continue  # a comment
        where = f"line {element.sourceline}"
        if element.tag == "Wall":
            corners = [
                (_number(source, corner, "X"), _number(source, corner, "Y")) for corner in element.findall("Corner")
            ]
            if len(corners) < 3:
                raise source.error(where, f"expected a wall of at least 3 corners, got {len(corners)}")
            draft.wall(corners, where, height=_number(source, element, "Height", 0.01, 1000.0))
        elif element.tag == "Beacon":
            beacons += 1
            at = (_number(source, element, "X"), _number(source, element, "Y"))
            draft.place(f"beacon{beacons}", at, where, kinds=("beacon",))
        elif element.tag == "Target":
            x, y, radius = (_number(source, element, name) for name in ("X", "Y", "Radius"))
            turns = [2 * math.pi * step / CORNERS for step in range(CORNERS)]
            draft.zone("target", [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in turns], where)
        else:
            draft.leave_out(where, f"element {element.tag}")
    _add_grid(source, draft)
    return draft.finish(str(root.get("Name") or ""))


def _add_grid(source: FloorSource, draft: FloorDraft) -> None:
    name = PurePath(source.name).name
    other = re.sub(r"Lab(?=\.xml\Z)", "Grid", name)
    try:
        data = source.beside(other) if other != name else None
    except WireError:
        data = None
    if data is None:
        draft.leave_out(name, "start grid: there is no file of its name with Grid for Lab")
        return
    file = FloorSource(other, data, source.beside)
    for number, element in enumerate(_root(file, "Grid").findall("Position"), 1):
        at = (_number(file, element, "X"), _number(file, element, "Y"))
        where = f"{other}: line {element.sourceline}"
        draft.place(f"start{number}", at, where, heading_deg=_number(file, element, "Dir", -360.0, 360.0, 0.0))


def _root(source: FloorSource, tag: str) -> Any:
    if len(source.data) > MAX_BYTES:
        raise source.error("", f"expected at most {MAX_BYTES:,} bytes, got {len(source.data):,}", "too-long")
    try:
        root = elements.parse(source.data, tag)
    except WireError as error:
        line = getattr(error.__cause__, "lineno", None) or 1
        raise source.error(f"line {line}", error.text, error.code) from None
    if root.tag != tag:
        raise source.error("", f"expected the root {tag}, got {shown(str(root.tag))}", "malformed")
    if sum(1 for _ in root.iter()) > MAX_ELEMENTS:
        raise source.error("", f"expected at most {MAX_ELEMENTS:,} elements, got more", "too-many")
    return root


def _number(
    source: FloorSource,
    element: Any,
    name: str,
    low: float = -5000.0,
    high: float = 5000.0,
    default: float | None = None,
) -> float:
    text = element.get(name)
    if text is None and default is not None:
        return default
    try:
        value = float(text)
    except (TypeError, ValueError):
        value = math.nan
    if not low <= value <= high:
        where, got = f"line {element.sourceline}", "none" if text is None else shown(text)
        raise source.error(where, f"{element.tag}.{name}: expected a number in [{low:g}, {high:g}], got {got}")
    return value
