"""Reads the list of places and doorways that `ros_export` writes beside a map of the ROS map server. Pure.

The map server does not know this file, and the map is valid without it. So an entry that cannot be read is left out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from pathlib import PurePath
from typing import Any, Final, get_args

from intellwheels_maps.importers.floor_draft import FloorDraft, Leaf
from intellwheels_maps.importers.floor_source import FloorSource
from intellwheels_maps.importers.safe_yaml import read_yaml
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown
from intellwheels_schemas.messages import WORD_PATTERN, Door, DoorKind, Side

ENDING: Final = ".places.yaml"
"""What the file's name ends in, in place of the `.yaml` of the map."""

_FARTHEST: Final = 1e8  # m
_TURN: Final = 1e4  # rad
_WIDEST: Final = 100.0  # m: of a doorway
_WORD: Final = re.compile(WORD_PATTERN)


def add_places(source: FloorSource, draft: FloorDraft) -> None:
    """Add the places and doorways of the list beside a map, if there is one.

    A doorway gets the width of the gap between the walls of the draft.

    Args:
        source: The YAML file of the map.
        draft: The floor. Its coordinates are those of the site, as in the list.
    """
    name = PurePath(source.name).name.removesuffix(".yaml") + ENDING
    try:
        data = source.beside(name)
    except WireError as error:
        if error.code == "too-long":
            draft.leave_out(name, error.text)
        return
    try:
        document = read_yaml(FloorSource(name, data, source.beside))
    except WireError as error:
        draft.leave_out(name, error.text.removeprefix(f"{name}: "))
        return
    parts: dict[Any, Callable[[Mapping[Any, Any], str, FloorDraft], None]] = {"places": _place, "doorways": _doorway}
    for key, value in document.items():
        if key == "map":
            continue  # the name of the map that was exported
        if key not in parts:
            draft.leave_out(f"{name}: {shown(key)}", "key that is not known")
            continue
        if not isinstance(value, list):
            draft.leave_out(f"{name}: {key}", f"expected a list, got {shown(value)}")
            continue
        for index, entry in enumerate(value):
            where = f"{name}: {key}[{index}]"
            try:
                if not isinstance(entry, dict):
                    raise ValueError(f"expected keys and values, got {shown(entry)}")  # noqa: TRY004, TRY301
                parts[key](entry, where, draft)
            except ValueError as error:
                draft.leave_out(where, str(error))


def _place(entry: Mapping[Any, Any], where: str, draft: FloorDraft) -> None:
    _check_keys(entry, "name", "x", "y", "yaw", "kinds")
    kinds = entry.get("kinds", [])
    if not isinstance(kinds, list) or not all(isinstance(kind, str) and _WORD.match(kind) for kind in kinds):
        raise ValueError(f"kinds: expected a list of words, got {shown(kinds)}")
    x, y, yaw = _pose(entry)
    # Rounded first: pi of nine digits is a little more than 180 degrees.
    draft.place(_name(entry), (x, y), where, round(math.degrees(yaw), 4), tuple(kinds))


def _doorway(entry: Mapping[Any, Any], where: str, draft: FloorDraft) -> None:
    _check_keys(entry, "name", "x", "y", "yaw", "width", "door", "side", "swing")
    x, y, yaw = _pose(entry)
    half = _number(entry, "width", 1e-3, _WIDEST) / 2
    across = -math.sin(yaw) * half, math.cos(yaw) * half
    door = None
    if "door" in entry:
        swing = math.degrees(_number(entry, "swing", -math.tau, math.tau, math.pi / 2))
        kind, side = _choice(entry, "door", get_args(DoorKind)), _choice(entry, "side", get_args(Side), "left")
        door = Door(kind=kind, side=side, swing_deg=round(swing, 4))
    draft.door(_name(entry), where, Leaf((x + across[0], y + across[1]), (x - across[0], y - across[1]), door))


def _check_keys(entry: Mapping[Any, Any], *known: str) -> None:
    for key in entry:
        if key not in known:
            raise ValueError(f"expected the keys {', '.join(known)}, got {shown(key)}")


def _name(entry: Mapping[Any, Any]) -> str:
    name = entry.get("name")
    if not isinstance(name, str) or not name:
        raise ValueError(f"name: expected a name, got {shown(name)}")
    return name


def _pose(entry: Mapping[Any, Any]) -> tuple[float, float, float]:
    x, y = (_number(entry, key, -_FARTHEST, _FARTHEST) for key in ("x", "y"))
    return x, y, _number(entry, "yaw", -_TURN, _TURN, 0.0)


def _number(entry: Mapping[Any, Any], key: str, low: float, high: float, default: float | None = None) -> float:
    value = entry.get(key, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ValueError(f"{key}: expected a number in [{low:g}, {high:g}], got {shown(value)}")
    return float(value)


def _choice(entry: Mapping[Any, Any], key: str, choices: tuple[Any, ...], default: str | None = None) -> Any:
    value = entry.get(key, default)
    if value not in choices:
        raise ValueError(f"{key}: expected one of {', '.join(choices)}, got {shown(value)}")
    return value
