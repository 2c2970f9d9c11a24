"""The walls and obstacles of a map, as the kernels need them."""

from __future__ import annotations

from intellwheels_schemas.messages import Corner, Map
from intellwheels_server.world.wall_pieces import Line, Solid, Walls, walls_from


def walls_of(floor: Map) -> Walls:
    """Return the walls of a map, then its obstacles, as wall pieces, indexed in that order.

    Raises:
        ValueError: A wall or obstacle is no polygon or line; the text says which.
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


def describe_wall(floor: Map, index: int) -> str:
    """Return how a message names the wall or obstacle with an index of `walls_of`."""
    if index < len(floor.wall):
        return f"wall {index + 1}"
    return f"obstacle '{floor.obstacle[index - len(floor.wall)].name}'"


def _points(corners: tuple[Corner, ...]) -> list[tuple[float, float]]:
    return [(corner.x, corner.y) for corner in corners]
