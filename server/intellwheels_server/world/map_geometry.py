"""From a map to what the kernels need: walls and obstacles as solids and lines, in that order."""

from __future__ import annotations

from intellwheels_schemas.messages import Corner, Map
from intellwheels_server.world.wall_pieces import Line, Solid, Walls, walls_from


def walls_of(floor: Map) -> Walls:
    """Return the map's walls, then its obstacles, as wall pieces; a wall's index is its place in that order.

    Raises:
        ValueError: A wall or obstacle is no polygon or line; the text names it.
    """
    solids: list[Solid | Line] = []
    for wall in floor.wall:
        corners = _points(wall.corner)
        if wall.thickness is None:
            solids.append(Solid(corners=corners, bottom=wall.bottom, top=wall.height))
        else:
            solids.append(Line(corners=corners, thickness=wall.thickness, bottom=wall.bottom, top=wall.height))
    solids.extend(
        Solid(corners=_points(obstacle.corner), bottom=obstacle.bottom, top=obstacle.top) for obstacle in floor.obstacle
    )
    return walls_from(solids)


def wall_words(floor: Map, index: int) -> str:
    """Return how to speak of the wall or obstacle with an index of `walls_of`."""
    if index < len(floor.wall):
        return f"wall {index + 1}"
    return f"obstacle '{floor.obstacle[index - len(floor.wall)].name}'"


def _points(corners: tuple[Corner, ...]) -> list[tuple[float, float]]:
    return [(corner.x, corner.y) for corner in corners]
