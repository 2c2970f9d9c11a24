"""Finds the pose of a new body: the place that it asks for, or the first free place for its kind."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.explain import did_you_mean
from intellwheels_schemas.messages import Map, Place, Position
from intellwheels_server.world.floor_bounds import outside
from intellwheels_server.world.kernels.arrays import Box, Floats, Ints, Walls, part_rows, radius_of
from intellwheels_server.world.kernels.elementary import wrap
from intellwheels_server.world.kernels.overlap import deepest_body, deepest_wall, overlaps_wall
from intellwheels_server.world.map_geometry import describe_wall

if TYPE_CHECKING:
    from intellwheels_server.world.body_set import BodyModel

TOUCH = 1e-9
"""Depth up to which two bodies touch and do not overlap, m; as in contact."""


_Arrays = tuple[list[str], Floats, Floats, Floats, Ints]
"""Of all bodies: the names, the poses, the radii, the parts, and where those of each body start."""


@lru_cache(maxsize=1024)  # a change of the bodies asks for those of all
def _outline(boxes: tuple[Box, ...]) -> tuple[Floats, float]:
    """Return the boxes as a part block, which nobody may change, and the distance of the farthest corner, m."""
    return part_rows(boxes), radius_of(boxes)


class OccupiedSpace:
    """The space that walls and bodies occupy. Its arrays are built again after a body was moved or removed."""

    def __init__(self, walls: Walls, floor: Map) -> None:
        self._walls = walls
        self._floor = floor
        self._parts: dict[str, Floats] = {}
        self._radii: dict[str, float] = {}
        self._poses: dict[str, tuple[float, float, float]] = {}
        self._anchored: set[str] = set()
        self._arrays: _Arrays | None = None
        self._named: dict[str, Place] | None = None
        self._starts: dict[str, tuple[tuple[str, Position], ...]] = {}
        # The starts of a kind at which a shape may fit, by the bytes of its parts. Those at which it overlaps something
        # are left out until a body moves or goes.
        self._open: dict[tuple[str, bytes], dict[int, tuple[str, Position]]] = {}

    def add(self, name: str, model: BodyModel, x: float, y: float, heading: float) -> None:
        """Add a body at a pose, or move it there."""
        known = name in self._parts
        self._parts[name], self._radii[name] = _outline(tuple(model.shape.boxes))
        self._poses[name] = (float(x), float(y), float(heading))
        if model.robot.anchored:
            self._anchored.add(name)
        self._arrays = None if known or self._arrays is None else self._extended(self._arrays, name)
        if known:
            self._open.clear()

    def remove(self, name: str) -> None:
        """Remove a body."""
        del self._parts[name], self._radii[name], self._poses[name]
        self._anchored.discard(name)
        self._arrays = None
        self._open.clear()

    def outside(self, position: Position) -> str | None:
        """Return what is wrong with a position outside a map with outer walls, or None."""
        return outside(self._walls, self._floor, position.x, position.y)

    def overlap_of(self, name: str) -> str | None:
        """Return a description of what a body overlaps at its pose, or None."""
        return self._deepest(self._parts[name], self._radii[name], self._poses[name], name)[1]

    def overlap_at(self, model: BodyModel, position: Position) -> str | None:
        """Return a description of what a body would overlap at a position, or None."""
        parts, radius = _outline(tuple(model.shape.boxes))
        return self._deepest(parts, radius, (position.x, position.y, position.heading), model.name)[1]

    def place_named(self, name: str) -> Place:
        """Return the place of the map with a name.

        Raises:
            RequestRefusedError: `no-place`, with the names of the places.
        """
        if self._named is None:
            spots = self._floor.grid.position if self._floor.grid is not None else ()
            self._named = {spot.name: spot for spot in reversed(spots)}
        return self._named.get(name) or place_named(self._floor, name)

    def first_free(self, model: BodyModel, suits: Callable[[str, Position], bool]) -> Position | None:
        """Return the first start of its kind that suits and at which a new body would overlap nothing, or None.

        Args:
            model: The body.
            suits: Tells whether a start does, by its name and pose.
        """
        walls, kind = self._walls, model.robot.kind
        parts, radius = _outline(tuple(model.shape.boxes))
        _, poses, radii, others, starts = self._blocks()
        if kind not in self._starts:
            self._starts[kind] = tuple((spot.name, position_of(spot)) for spot in places_for(self._floor, kind))
        key = kind, parts.tobytes()
        if key not in self._open:
            self._open[key] = dict(enumerate(self._starts[kind]))
        found, blocked = None, []
        for number, (name, position) in self._open[key].items():
            if not suits(name, position):
                continue
            pose = (position.x, position.y, position.heading)
            if (
                not overlaps_wall(parts, *pose, walls.pieces, walls.links, walls.edges, walls.cells, walls.frame, TOUCH)
                and deepest_body(parts, radius, *pose, poses, radii, others, starts, -1)[0] <= TOUCH
            ):
                found = position
                break
            blocked.append(number)
        for number in blocked:
            del self._open[key][number]
        return found

    def may_be_swept(self, model: BodyModel, position: Position) -> bool:
        """Return whether an anchored body, such as the leaf of a door, might hit a body at a position when it turns.

        Both count as circles around their centres of movement, whichever way they turn.
        """
        if not self._anchored:
            return False
        radius = radius_of(model.shape.boxes)
        for name in self._anchored - {model.name}:
            x, y, _ = self._poses[name]
            if (position.x - x) ** 2 + (position.y - y) ** 2 < (radius + self._radii[name]) ** 2:
                return True
        return False

    def depth_at(self, name: str) -> float:
        """Return the largest depth of overlap of a body with anything at its pose, m; at least 0."""
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
            return depth, describe_wall(self._floor, wall)
        return depth, f"agent '{names[body]}'"

    def _extended(self, arrays: _Arrays, name: str) -> _Arrays:
        """Return the arrays with one more body. To make them anew takes longer the more bodies there are."""
        names, poses, radii, parts, starts = arrays
        pose = np.array(self._poses[name]).reshape(3, 1)
        return (
            [*names, name],
            np.concatenate([poses, pose], axis=1),
            np.append(radii, self._radii[name]),
            np.concatenate([parts, self._parts[name]]),
            np.append(starts, starts[-1] + len(self._parts[name])),
        )

    def _blocks(self) -> _Arrays:
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


def place(model: BodyModel, floor: Map, space: OccupiedSpace, reserved: Collection[str] = ()) -> Position:
    """Return the pose of a new body: its Place, its Position, or the first free place.

    A free place that the leaf of a door might sweep is given away only if there is no other. A real body is accepted at
    any pose, even if it overlaps something.

    Args:
        model: The body.
        floor: The map.
        space: What is there already.
        reserved: Places that are kept for other bodies.

    Raises:
        RequestRefusedError: `no-place`, if there is no such place or none is free; `overlaps`, if something is there
            or will be; `value`, if it would be outside the outer walls of the map.
    """
    robot = model.robot
    spots = floor.grid.position if floor.grid is not None else ()
    kept = {spot.name: position_of(spot) for spot in spots if spot.name in reserved} if reserved else {}
    wanted = None
    if robot.place is not None:
        wanted = position_of(space.place_named(robot.place))
    if wanted is None:
        wanted = robot.position
    if wanted is not None:
        wanted = with_wrapped_heading(wanted)
        beyond = None if model.externally_posed else space.outside(wanted)
        if beyond is not None:
            raise RequestRefusedError("value", f"agent '{model.name}': {beyond}")
        obstacle = None if model.externally_posed else space.overlap_at(model, wanted)
        if obstacle is not None:
            raise RequestRefusedError("overlaps", f"agent '{model.name}' would overlap {obstacle} {_where(model)}")
        near = None if model.externally_posed else _kept_near(model, wanted, kept)
        if near is not None:
            text = f"agent '{model.name}' would be in the way at place '{near}', which is kept for another agent"
            raise RequestRefusedError("overlaps", text)
        return wanted

    def suits(name: str, there: Position, *, swept: bool) -> bool:
        return name not in kept and space.may_be_swept(model, there) is swept and _kept_near(model, there, kept) is None

    for swept in (False, True):
        free = space.first_free(model, partial(suits, swept=swept))
        if free is not None:
            return free
    but = f" besides those kept for other agents ({', '.join(kept)})" if kept else ""
    raise RequestRefusedError(
        "no-place",
        f"no free place for a {robot.kind} on map '{floor.name}'{but}: give a place or a position (Robot.Place or "
        "Robot.Position; --place or --position of iw-agent)",
    )


def _kept_near(model: BodyModel, position: Position, kept: Mapping[str, Position]) -> str | None:
    """Return the place at which a body like this one would overlap it at a position, or None.

    Who will come to the place is not known. Bodies on a map are about as large as each other.
    """
    if not kept:
        return None
    parts, radius = part_rows(model.shape.boxes), radius_of(model.shape.boxes)
    here = position.x, position.y, position.heading
    starts = np.array([0, len(parts)], dtype=np.int64)
    for name, there in kept.items():
        poses = np.array([[there.x], [there.y], [there.heading]])
        if deepest_body(parts, radius, *here, poses, np.array([radius]), parts, starts, -1)[0] > TOUCH:
            return name
    return None


def place_named(floor: Map, name: str) -> Place:
    """Return the place with a name.

    Raises:
        RequestRefusedError: `no-place`, with the names of the places.
    """
    spots = floor.grid.position if floor.grid is not None else ()
    for spot in spots:
        if spot.name == name:
            return spot
    known = [spot.name for spot in spots]
    expected = f"expected one of {', '.join(known) or 'none'}{did_you_mean(name, known)}"
    raise RequestRefusedError("no-place", f"no place '{name}' on map '{floor.name}': {expected}")


def places_for(floor: Map, kind: str) -> list[Place]:
    """Return the places where a body of a kind may start without asking for one, in the order of the map."""
    spots = floor.grid.position if floor.grid is not None else ()
    return [spot for spot in spots if not spot.kinds or kind in spot.kinds]


def position_of(spot: Place) -> Position:
    """Return the pose of a place, with its heading in (-pi, pi]."""
    degrees = math.remainder(spot.heading_deg, 360.0)
    return Position(x=spot.x, y=spot.y, heading=math.radians(180.0 if degrees == -180.0 else degrees))


def with_wrapped_heading(position: Position) -> Position:
    """Return a pose with its heading in (-pi, pi]. On the wire it may be up to a turn away."""
    return msgspec.structs.replace(position, heading=wrap(position.heading))


def _where(model: BodyModel) -> str:
    return f"at place '{model.robot.place}'" if model.robot.place is not None else "at its position"
