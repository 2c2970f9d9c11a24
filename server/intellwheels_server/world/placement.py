"""Where a body can stand: the place it asked for, or the first that is free for its kind."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Map, Place, Position
from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls, part_rows, radius_of
from intellwheels_server.world.kernels.elementary import wrap
from intellwheels_server.world.kernels.overlap import deepest_body, deepest_wall
from intellwheels_server.world.map_geometry import wall_words

if TYPE_CHECKING:
    from intellwheels_server.world.body_set import BodyModel

TOUCH = 1e-9
"""Metres: the depth up to which two bodies count as touching, as in contact."""


class Crowd:
    """Who stands where, in the order of arrival; arrays are made anew when somebody comes or goes."""

    def __init__(self, walls: Walls, floor: Map) -> None:
        self._walls = walls
        self._floor = floor
        self._parts: dict[str, Floats] = {}
        self._radii: dict[str, float] = {}
        self._poses: dict[str, tuple[float, float, float]] = {}
        self._arrays: tuple[list[str], Floats, Floats, Floats, Ints] | None = None

    def add(self, name: str, figure: BodyModel, x: float, y: float, heading: float) -> None:
        """Put a body somewhere, or somewhere else."""
        self._parts[name] = part_rows(figure.shape.boxes)
        self._radii[name] = radius_of(figure.shape.boxes)
        self._poses[name] = (float(x), float(y), float(heading))
        self._arrays = None

    def remove(self, name: str) -> None:
        """Take a body out."""
        del self._parts[name], self._radii[name], self._poses[name]
        self._arrays = None

    def in_the_way(self, name: str) -> str | None:
        """Return what a body overlaps where it stands, in words, or None."""
        return self._deepest(self._parts[name], self._radii[name], self._poses[name], name)[1]

    def would_hit(self, figure: BodyModel, position: Position) -> str | None:
        """Return what a body would overlap at a position, in words, or None."""
        boxes = figure.shape.boxes
        return self._deepest(
            part_rows(boxes), radius_of(boxes), (position.x, position.y, position.heading), figure.name
        )[1]

    def depth_at(self, name: str) -> float:
        """Return the largest depth to which a body overlaps anything where it stands, m, at least 0."""
        return self._deepest(self._parts[name], self._radii[name], self._poses[name], name)[0]

    def _deepest(
        self, parts: Floats, radius: float, pose: tuple[float, float, float], name: str
    ) -> tuple[float, str | None]:
        names, poses, radii, others, starts = self._blocks()
        skip = names.index(name) if name in self._parts else -1
        wall_depth, wall = deepest_wall(parts, radius, *pose, self._walls.pieces, self._walls.links, self._walls.edges)
        body_depth, body = deepest_body(parts, radius, *pose, poses, radii, others, starts, skip)
        depth = max(wall_depth, body_depth)
        if depth <= TOUCH:
            return depth, None
        if wall_depth >= body_depth:
            return depth, wall_words(self._floor, wall)
        return depth, f"agent '{names[body]}'"

    def _blocks(self) -> tuple[list[str], Floats, Floats, Floats, Ints]:
        if self._arrays is None:
            names = list(self._parts)
            counts = [len(self._parts[name]) for name in names]
            self._arrays = (
                names,
                np.ascontiguousarray(np.array([self._poses[name] for name in names]).reshape(-1, 3).T),
                np.array([self._radii[name] for name in names], dtype=np.float64),
                np.concatenate([self._parts[name] for name in names]) if names else np.empty((0, 6)),
                np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int64),
            )
        return self._arrays


def place(figure: BodyModel, floor: Map, crowd: Crowd) -> Position:
    """Return where a body goes: its Place, its Position, or the first free place.

    A real body is where it is, so nothing is in its way.

    Raises:
        RequestRefusedError: `no-place`, there is no such place or none is free; `overlaps`, something stands there.
    """
    robot = figure.robot
    wanted = None
    if robot.place is not None:
        wanted = position_of(place_named(floor, robot.place))
    if wanted is None:
        wanted = robot.position
    if wanted is not None:
        wanted = in_range(wanted)
        obstacle = None if figure.externally_posed else crowd.would_hit(figure, wanted)
        if obstacle is not None:
            raise RequestRefusedError("overlaps", f"agent '{figure.name}' would overlap {obstacle} {_where(figure)}")
        return wanted
    for spot in places_for(floor, robot.kind):
        position = position_of(spot)
        if crowd.would_hit(figure, position) is None:
            return position
    raise RequestRefusedError(
        "no-place",
        f"no free place for a {robot.kind} on floor '{floor.name}': give Robot.Place or Robot.Position",
    )


def place_named(floor: Map, name: str) -> Place:
    """Return the place of that name.

    Raises:
        RequestRefusedError: `no-place`, with the names there are.
    """
    spots = floor.grid.position if floor.grid is not None else ()
    for spot in spots:
        if spot.name == name:
            return spot
    known = ", ".join(spot.name for spot in spots) or "none"
    raise RequestRefusedError("no-place", f"no place '{name}' on floor '{floor.name}': there are {known}")


def places_for(floor: Map, kind: str) -> list[Place]:
    """Return the places where a body of that kind may start unasked, in the map's order."""
    spots = floor.grid.position if floor.grid is not None else ()
    return [spot for spot in spots if not spot.kinds or kind in spot.kinds]


def position_of(spot: Place) -> Position:
    """Return the place's pose, its heading in (-pi, pi]."""
    degrees = math.remainder(spot.heading_deg, 360.0)
    return Position(x=spot.x, y=spot.y, heading=math.radians(180.0 if degrees == -180.0 else degrees))


def in_range(position: Position) -> Position:
    """Return the pose with its heading in (-pi, pi]: on the wire it may be up to a turn away."""
    return msgspec.structs.replace(position, heading=wrap(position.heading))


def _where(figure: BodyModel) -> str:
    return f"at place '{figure.robot.place}'" if figure.robot.place is not None else "at its position"
