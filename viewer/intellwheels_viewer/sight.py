"""What a driver can see: the bodies that no wall, tall obstacle or door leaf hides. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from intellwheels_maps.check import wall_pieces
from intellwheels_maps.plane_geometry import edges
from intellwheels_schemas.messages import Body, Entity, Map
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.body_look import extent

Segments = npt.NDArray[np.float64]


def blinds(floor: Map, height: float) -> Segments:
    """Return the edges of all that reaches as high as an eye, (S, 4): x and y of both ends, in metres."""
    rings = [piece for wall in floor.wall if wall.bottom < height < wall.height for piece in wall_pieces(wall)]
    rings += [[(c.x, c.y) for c in thing.corner] for thing in floor.obstacle if thing.bottom < height < thing.top]
    return np.array([(*a, *b) for ring in rings for a, b in edges(ring)], np.float64).reshape(-1, 4)


def leaves(bodies: Mapping[str, Body], entities: Iterable[Entity], height: float) -> Segments:
    """Return the door leaves that reach as high as an eye, as `blinds` does."""
    found = []
    for entity in entities:
        body = bodies.get(entity.name)
        if body is None or body.robot.kind != "door":
            continue
        hull = extent(parts_of(body.robot))
        if hull.top > height:
            cos, sin = math.cos(entity.heading), math.sin(entity.heading)
            ends = [(entity.x + x * cos, entity.y + x * sin) for x in (hull.rear, hull.front)]
            found.append((*ends[0], *ends[1]))
    return np.array(found, np.float64).reshape(-1, 4)


def in_sight(eye: tuple[float, float], entities: Sequence[Entity], hidden_by: Segments) -> list[Entity]:
    """Return the bodies whose middle is seen from a point.

    Args:
        eye: Where from, in metres.
        entities: The bodies.
        hidden_by: (S, 4), see `blinds`.
    """
    if not entities or not len(hidden_by):
        return list(entities)
    targets = np.array([(each.x, each.y) for each in entities], np.float64)
    start, end = hidden_by[:, :2], hidden_by[:, 2:]
    sight, wall = targets - eye, end - start
    # Two segments cross when the ends of each lie on both sides of the other.
    of_eye = _cross(wall, np.asarray(eye) - start)
    of_target = _cross(wall[None], targets[:, None] - start[None])
    of_start = _cross(sight[:, None], (start - eye)[None])
    of_end = _cross(sight[:, None], (end - eye)[None])
    crossed = (of_eye[None] * of_target < 0.0) & (of_start * of_end < 0.0)
    hidden = np.flatnonzero(np.any(crossed, axis=1)).tolist()
    return [each for index, each in enumerate(entities) if index not in hidden]


def _cross(a: npt.NDArray[np.float64], b: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
