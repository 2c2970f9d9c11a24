"""The leaves of the doors of a map, as agents: where each starts, its robot, and the options of its mind. Pure.

A leaf that turns stands in its doorway, with its edges at least 5 cm from the jambs. A leaf that slides moves beside
the wall, at the smallest distance at which nothing is in its way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import msgspec

from intellwheels_maps.starts import Box, overlap, wall_boxes
from intellwheels_schemas.messages import Cast, Door, Doorway, Grid, Map, Option, Place, Robot
from intellwheels_schemas.rules import parts_of

NARROWEST: Final = 0.5
"""Width of the narrowest doorway that gets leaves, m."""

_GAPS: Final = (0.05, 0.1, 0.15)  # m: from the edges of a leaf that turns to the jambs; the first that is free
_BEHIND: Final = 0.01  # m: part of a leaf behind its hinge
_BETWEEN: Final = 0.04  # m: between two leaves that turn
_OVER: Final = 0.05  # m: by which a sliding leaf covers each jamb
_THIN: Final = 0.05  # m: thickness of a leaf
_CLEAR: Final = 0.03  # m: between a sliding leaf and the wall
_MARGIN: Final = 0.005  # m: around a closed leaf, so that rounding never lets it touch
_OFFSETS: Final = tuple(0.05 + 0.02 * step for step in range(25))  # m: from the middle of the wall to that of the leaf


class Leaves(NamedTuple):
    """The leaves of a map.

    Attributes:
        floor: The map with a place for each leaf.
        cast: The agents, each with the name of its robot.
        robots: The robots by that name.
        left_out: A line for each door that gets no leaves, with the reason.
    """

    floor: Map
    cast: tuple[Cast, ...]
    robots: dict[str, Robot]
    left_out: tuple[str, ...]


class _Leaf(NamedTuple):
    x: float
    y: float
    heading: float
    robot: Robot
    options: tuple[Option, ...]


def door_leaves(floor: Map, model: Robot) -> Leaves:
    """Return the leaves of all doors of a map.

    Args:
        floor: The map.
        model: The included robot `door`, a leaf of 1 m, which is scaled to the width of each.
    """
    walls = [box for _, box in wall_boxes(floor)]
    places = list(floor.grid.position) if floor.grid else []
    taken = {place.name for place in places}
    cast: list[Cast] = []
    robots: dict[str, Robot] = {}
    left_out = []
    closed: list[Box] = []
    for doorway in floor.doorway:
        if doorway.door is None:
            continue
        try:
            leaves = list(_leaves(doorway, model, walls))
        except ValueError as error:
            left_out.append(f"doorway {doorway.name!r}: {error}")
            continue
        boxes = [_closed(leaf) for leaf in leaves]
        if any(overlap(box, other) for box in boxes for other in (*walls, *closed)):
            left_out.append(f"doorway {doorway.name!r}: expected room for its leaves, got a wall or another leaf there")
            continue
        closed += boxes
        for leaf in leaves:
            name = f"door{len(cast) + 1}"
            place = _free(f"{name}-leaf", taken)
            kind = "slide" if not leaf.robot.anchored else "leaf"
            file = f"{kind}-{round((leaf.robot.length or 0.0) * 1000)}"
            robots[file] = leaf.robot
            heading = round(math.degrees(math.remainder(leaf.heading, math.tau)), 4) + 0.0
            places.append(
                Place(name=place, x=round(leaf.x, 4), y=round(leaf.y, 4), heading_deg=heading, kinds=("door",))
            )
            cast.append(Cast(name=name, robot=file, mind="door", place=place, option=leaf.options))
    grid = Grid(position=tuple(places)) if places else None
    return Leaves(msgspec.structs.replace(floor, grid=grid), tuple(cast), robots, tuple(left_out))


def _leaves(doorway: Doorway, model: Robot, walls: Sequence[Box]) -> Iterator[_Leaf]:
    """Yield the leaves of a doorway.

    Raises:
        ValueError: It can have none; the text says why.
    """
    if doorway.door is None or doorway.width < NARROWEST:
        raise ValueError(f"expected at least {NARROWEST:g} m for a door, got {doorway.width:g} m")
    double = doorway.door.kind.startswith("double")
    sides = ("left", "right") if double else (doorway.door.side,)
    if doorway.door.kind.endswith("sliding"):
        yield from _sliding(doorway, model, walls, sides)
        return
    angle = abs(doorway.door.swing_deg)
    if not 10.0 <= angle <= 180.0:
        raise ValueError(f"expected a swing of 10 to 180 degrees, got {angle:g}")
    for gap in _GAPS:
        leaves = [_turning(doorway, side, gap, model, double=double) for side in sides]
        if not any(overlap(_closed(leaf), wall) for leaf in leaves for wall in walls):
            break
    yield from leaves


def _turning(doorway: Doorway, side: str, gap: float, model: Robot, *, double: bool) -> _Leaf:
    """Return a leaf that turns, with a gap between its edges and the jambs."""
    door = doorway.door or Door()
    heading = math.radians(doorway.heading_deg)
    length = doorway.width - 2 * gap
    length = (length - _BETWEEN) / 2 if double else length
    turn = 1.0 if side == "left" else -1.0
    along = doorway.width / 2 - gap - _BEHIND
    swing = "left" if (door.swing_deg > 0) == (side == "left") else "right"
    return _Leaf(
        doorway.x - math.sin(heading) * turn * along,
        doorway.y + math.cos(heading) * turn * along,
        # The x axis of a leaf points from its free edge to its hinge.
        heading + turn * math.pi / 2,
        _scaled(model, length, (length - _BEHIND) / length, _THIN, 0.0),
        (Option(name="swing", value=swing), Option(name="angle", value=f"{abs(door.swing_deg):g}")),
    )


def _closed(leaf: _Leaf) -> Box:
    """Return the box of a closed leaf, with a margin all around."""
    part = parts_of(leaf.robot)[0]
    cos, sin = math.cos(leaf.heading), math.sin(leaf.heading)
    corners = []
    for along, across in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        x, y = part.x + along * (part.length / 2 + _MARGIN), across * (part.width / 2 + _MARGIN)
        corners.append((leaf.x + cos * x - sin * y, leaf.y + sin * x + cos * y))
    return corners, part.bottom, part.top


def _sliding(doorway: Doorway, model: Robot, walls: Sequence[Box], sides: Sequence[str]) -> Iterator[_Leaf]:
    heading = math.radians(doorway.heading_deg)
    travel = doorway.width / len(sides)
    length = travel + _OVER * (2 if len(sides) == 1 else 1)
    for offset in (sign * step for step in _OFFSETS for sign in (1.0, -1.0)):
        found = []
        for side in sides:
            turn = 1.0 if side == "left" else -1.0
            # Two leaves meet in the middle; a single one covers both jambs.
            along = turn * (length / 2 + _CLEAR / 2) if len(sides) == 2 else 0.0
            x = doorway.x - math.sin(heading) * along + math.cos(heading) * offset
            y = doorway.y + math.cos(heading) * along + math.sin(heading) * offset
            found.append((x, y, heading + turn * math.pi / 2))
        if all(_is_clear(leaf, length, travel, model, walls) for leaf in found):
            robot = msgspec.structs.replace(_scaled(model, length, 0.5, _THIN, length / 2), anchored=False)
            for x, y, ahead in found:
                yield _Leaf(x, y, ahead, robot, (Option(name="slide", value=f"{travel:.4f}"),))
            return
    raise ValueError(f"expected room beside the wall for a leaf that slides {travel:.2f} m, got none")


def _is_clear(
    leaf: tuple[float, float, float], length: float, travel: float, model: Robot, walls: Sequence[Box]
) -> bool:
    """Return whether nothing is where a leaf slides."""
    x, y, heading = leaf
    cos, sin = math.cos(heading), math.sin(heading)
    half = _THIN / 2 + _CLEAR
    swept = [
        (x + cos * along - sin * across, y + sin * along + cos * across)
        for along, across in (
            (-length / 2, -half), (length / 2 + travel, -half), (length / 2 + travel, half), (-length / 2, half),
        )
    ]  # fmt: skip
    return not any(overlap((swept, 0.0, model.top or 2.0), wall) for wall in walls)


def _scaled(model: Robot, length: float, center: float, width: float, shift: float) -> Robot:
    """Return a leaf of another size. Its sensors keep their share of the length and stay on its faces."""
    thin = width / (model.width or width)
    sensors = []
    for sensor in model.proximity:
        farthest = length + 0.2 if sensor.y == 0.0 else sensor.max_range
        sensors.append(
            msgspec.structs.replace(
                sensor, x=round(sensor.x * length + shift, 4), y=round(sensor.y * thin, 4), max_range=round(farthest, 4)
            )
        )
    return msgspec.structs.replace(
        model, length=round(length, 4), width=width, center=round(center, 6), proximity=tuple(sensors)
    )


def _free(name: str, taken: set[str]) -> str:
    """Return a name that no other place has."""
    found, number = name, 1
    while found in taken:
        number += 1
        found = f"{name}-{number}"
    taken.add(found)
    return found
