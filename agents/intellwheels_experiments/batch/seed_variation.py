"""What differs from seed to seed: the offsets that an experiment draws, and the row and the map that they give.

An offset is drawn from the seed and from what it is added to, and from nothing else. So every row that varies a number
gets the same offset for a seed, and a row added later changes no other row.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.run.launch_spec import is_robot_field
from intellwheels_maps.check import check_map
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Corner, Map, Option, Uniform

MAP_DECIMALS: Final = 6
"""Of coordinates, as in all messages."""
OPTION_DECIMALS: Final = 12
"""Of options: the variance of a wheel is about 1e-7 m."""
_FRACTIONS: Final = 2.0**53


def offset_of(uniform: Uniform, seed: str) -> float:
    """Return the offset of a number for a seed, in [low, high]: 53 bits of a BLAKE2b digest."""
    digest = hashlib.blake2b(f"{seed}/{label_of(uniform)}".encode(), digest_size=8).digest()
    share = (int.from_bytes(digest, "big") >> 11) / _FRACTIONS
    return round(uniform.low + (uniform.high - uniform.low) * share, OPTION_DECIMALS)


def label_of(uniform: Uniform) -> str:
    """Return what a number is called in files and reports, such as `chair.WheelRatio` or `place start.X`."""
    if uniform.agent is not None:
        return f"{uniform.agent}.{uniform.name}"
    kind, name = ("place", uniform.place) if uniform.place is not None else ("obstacle", uniform.obstacle)
    return f"{kind} {name}.{uniform.name}"


def drawn(row: Row, seed: str) -> dict[str, float]:
    """Return the offsets of a row for a seed, by their labels. One that follows another includes it."""
    return _with_followed(row.uniform, {label_of(one): offset_of(one, seed) for one in row.uniform})


def varied_row(row: Row, seed: str) -> Row:
    """Return a row with the options of its agents and bridges as a seed has them.

    Raises:
        WireError: An agent lacks an option that is varied, or it is not a number, or what an option follows is not
            varied.
    """
    _check_followed(row)
    return _varied_row(row, drawn(row, seed))


def varied_floor(floor: Map, row: Row, seed: str) -> Map:
    """Return a map with its places and obstacles as a seed has them.

    Raises:
        WireError: The map has no such place or obstacle, or a moved obstacle makes it invalid.
    """
    return _varied_floor(floor, row.uniform, drawn(row, seed))


def check_variation(rows: Sequence[Row], floor: Map) -> None:
    """Check what the rows vary, before anything starts: that it is there, and that the map is valid at both ends.

    Raises:
        WireError: As `varied_row` and `varied_floor`.
    """
    for row in rows:
        _check_followed(row)
        for ends in ([one.low for one in row.uniform], [one.high for one in row.uniform]):
            own = {label_of(one): end for one, end in zip(row.uniform, ends, strict=True)}
            offsets = _with_followed(row.uniform, own)
            _varied_row(row, offsets)
            _varied_floor(floor, row.uniform, offsets)


def write_scene(folder: Path, row: Row, seed: str, floor: Map) -> tuple[Path, Row]:
    """Write the scene and the map of one run, and return the scene's file and the row that names this map.

    Args:
        folder: A folder for the two files.
        row: The row, already as the seed has it.
        seed: The seed.
        floor: The map, already as the seed has it.
    """
    map_file, scene_file = (folder / "map.xml").absolute(), folder / "scene.xml"
    map_file.write_text(write_file(floor))
    scene = msgspec.structs.replace(row.scene, map=str(map_file), seed=seed)
    scene_file.write_text(write_file(scene))
    return scene_file, dataclasses.replace(row, scene=scene)


def _with_followed(uniforms: Sequence[Uniform], own: Mapping[str, float]) -> dict[str, float]:
    return {
        label_of(one): own[label_of(one)] + (own[f"{one.agent}.{one.follows}"] if one.follows is not None else 0.0)
        for one in uniforms
    }


def _check_followed(row: Row) -> None:
    labels = {label_of(one): one for one in row.uniform}
    for one in row.uniform:
        followed = None if one.follows is None else labels.get(f"{one.agent}.{one.follows}")
        if one.follows is not None and (followed is None or followed.follows is not None):
            text = f"Uniform.Follows: expected an option of {one.agent!r} that row {row.name!r} draws by itself"
            raise WireError("value", f"{text}, got {one.follows!r}", "Uniform.Follows")


def _varied_row(row: Row, offsets: Mapping[str, float]) -> Row:
    cast = {one.name: one for one in row.scene.cast}
    bridges = dict(row.bridges)
    for one in row.uniform:
        if one.agent is None:
            continue
        offset = offsets[label_of(one)]
        bridge = bridges.get(one.agent)
        # The body of an agent with a bridge is the bridge's chair.
        if bridge is not None and any(option.name == one.name for option in bridge.option):
            bridges[one.agent] = msgspec.structs.replace(bridge, option=_added(bridge.option, one, offset, row))
        elif one.agent in cast and not (bridge is not None and is_robot_field(one.name)):
            member = cast[one.agent]
            cast[one.agent] = msgspec.structs.replace(member, option=_added(member.option, one, offset, row))
        else:
            raise _missing(one, row)
    scene = msgspec.structs.replace(row.scene, cast=tuple(cast.values()))
    return dataclasses.replace(row, scene=scene, bridges=bridges)


def _varied_floor(floor: Map, uniforms: Sequence[Uniform], offsets: Mapping[str, float]) -> Map:
    moved = [one for one in uniforms if one.agent is None]
    if not moved:
        return floor
    obstacles = {one.name: one for one in floor.obstacle}
    places = {one.name: one for one in (floor.grid.position if floor.grid is not None else ())}
    for one in moved:
        offset = offsets[label_of(one)]
        if one.place is not None:
            if one.place not in places:
                raise _unknown("Place", one.place, list(places), floor)
            place = places[one.place]
            if one.name == "HeadingDeg":
                change = {"heading_deg": math.remainder(round(place.heading_deg + offset, MAP_DECIMALS), 360.0)}
            else:
                name = one.name.lower()
                change = {name: round(getattr(place, name) + offset, MAP_DECIMALS)}
            places[one.place] = msgspec.structs.replace(place, **change)
        else:
            name = str(one.obstacle)
            if name not in obstacles:
                raise _unknown("Obstacle", name, list(obstacles), floor)
            dx, dy = (offset, 0.0) if one.name == "X" else (0.0, offset)
            corners = tuple(
                Corner(x=round(corner.x + dx, MAP_DECIMALS), y=round(corner.y + dy, MAP_DECIMALS))
                for corner in obstacles[name].corner
            )
            obstacles[name] = msgspec.structs.replace(obstacles[name], corner=corners)
    grid = None if floor.grid is None else msgspec.structs.replace(floor.grid, position=tuple(places.values()))
    found = msgspec.structs.replace(floor, obstacle=tuple(obstacles.values()), grid=grid)
    findings = check_map(found)
    if findings:
        raise WireError("value", f"Uniform: expected ranges in which the map stays valid, got {findings[0].text}")
    return found


def _added(options: tuple[Option, ...], one: Uniform, offset: float, row: Row) -> tuple[Option, ...]:
    values = {option.name: option.value for option in options}
    if one.name not in values:
        raise _missing(one, row)
    try:
        number = float(values[one.name])
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        text = f"Uniform.Name: expected an option of {one.agent!r} that is a number in row {row.name!r}"
        raise WireError("value", f"{text}, got {one.name}={values[one.name]!r}", "Uniform.Name")
    values[one.name] = repr(round(number + offset, OPTION_DECIMALS))
    return tuple(Option(name=name, value=value) for name, value in values.items())


def _missing(one: Uniform, row: Row) -> WireError:
    text = f"Uniform.Name: expected an option of {one.agent!r} that row {row.name!r} sets, got {one.name!r}"
    return WireError("value", text, "Uniform.Name")


def _unknown(field: str, name: str, known: list[str], floor: Map) -> WireError:
    listed = ", ".join(known) or "it has none"
    text = f"Uniform.{field}: expected one of map {floor.name!r} ({listed}), got {name!r}"
    return WireError("value", text, f"Uniform.{field}")
