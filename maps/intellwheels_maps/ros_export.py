"""Writes a map for the ROS map server: an image of cells, its YAML file, and a list of places and doors. Pure.

Coordinates are those of the site: the `Offset` of the map is added.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Final, NamedTuple

from intellwheels_maps.check import ring_of, wall_pieces
from intellwheels_maps.crossing import Point
from intellwheels_maps.site_frame import DEGREES, to_site
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Map

MARGIN: Final = 2
"""Free cells around the walls."""

MAX_CELLS: Final = 1 << 24
"""Largest image; the importer reads no larger one."""

_FREE, _WALL = 254, 0


class RosFloor(NamedTuple):
    """The files of a floor.

    Attributes:
        head: The YAML file.
        image: The image, PGM.
        places: The list of places and doorways, YAML.
        columns: Width of the image in cells.
        rows: Height of the image in cells.
    """

    head: str
    image: bytes
    places: str
    columns: int
    rows: int


def export_ros(document: Map, resolution: float, image: str) -> RosFloor:
    """Return the files of a map.

    A cell is a wall if its middle is in a wall or an obstacle, at any height. All others are free. The grid is aligned
    to multiples of the resolution, so that a map that came from cells of this size gets the same cells.

    Args:
        document: The map. It needs numpy and shapely.
        resolution: Length of a cell, m.
        image: The image's name, for the YAML file.

    Raises:
        WireError: The map has no walls, is too large for the resolution, or is in degrees.
    """
    import numpy as np  # noqa: PLC0415 - of an extra
    import shapely  # noqa: PLC0415

    if document.offset is not None and document.offset.epsg == DEGREES:
        raise WireError("value", f"{document.name}: expected a map in metres, got one whose site is in degrees")
    pieces = [piece for wall in document.wall for piece in wall_pieces(wall)]
    pieces += [ring_of(obstacle.corner) for obstacle in document.obstacle]
    if not pieces:
        raise WireError("value", f"{document.name}: expected walls or obstacles, got none")
    xs, ys = [x for piece in pieces for x, _ in piece], [y for piece in pieces for _, y in piece]
    west, south = (_down(min(values), resolution) - MARGIN for values in (xs, ys))
    columns = -_down(-max(xs), resolution) + MARGIN - west
    rows = -_down(-max(ys), resolution) + MARGIN - south
    if columns * rows > MAX_CELLS:
        text = f"--resolution: expected at most {MAX_CELLS:,} cells, got {columns:,} x {rows:,}"
        raise WireError("too-long", text, "--resolution")
    cells = np.zeros((rows, columns), dtype=bool)
    for piece in pieces:
        polygon = shapely.Polygon(piece)
        shapely.prepare(polygon)
        low_x, low_y, high_x, high_y = polygon.bounds
        left, bottom = int(low_x / resolution - west) - 1, int(low_y / resolution - south) - 1
        right, top = int(high_x / resolution - west) + 2, int(high_y / resolution - south) + 2
        x = (np.arange(left, right) + west + 0.5) * resolution
        y = (np.arange(bottom, top) + south + 0.5) * resolution
        inside = shapely.intersects_xy(polygon, *np.meshgrid(x, y))
        cells[bottom:top, left:right] |= inside
    data = np.where(cells[::-1], _WALL, _FREE).astype(np.uint8).tobytes()
    corner = (west * resolution, south * resolution)
    if document.offset is not None:
        corner = (corner[0] + document.offset.x, corner[1] + document.offset.y)
    head = [
        f"image: {json.dumps(image)}",
        "mode: trinary",
        f"resolution: {resolution!r}",
        f"origin: [{_plain(corner[0])}, {_plain(corner[1])}, 0.0]",
        "negate: 0",
        "occupied_thresh: 0.65",
        "free_thresh: 0.25",
    ]
    pgm = f"P5\n{columns} {rows}\n255\n".encode() + data
    return RosFloor("\n".join(head) + "\n", pgm, "\n".join(_places(document)) + "\n", columns, rows)


def _places(document: Map) -> Iterator[str]:
    """Yield the lines of the list of places and doorways, positions in the frame of the site."""
    yield f"map: {json.dumps(document.name)}"
    places = document.grid.position if document.grid else ()
    yield "places:" if places else "places: []"
    for place in places:
        kinds = json.dumps(list(place.kinds))
        pose = _pose(document, (place.x, place.y), place.heading_deg)
        yield f"  - {{name: {json.dumps(place.name)}, {pose}, kinds: {kinds}}}"
    yield "doorways:" if document.doorway else "doorways: []"
    for doorway in document.doorway:
        pose = _pose(document, (doorway.x, doorway.y), doorway.heading_deg)
        door = doorway.door
        leaf = "" if door is None else f", door: {door.kind}, side: {door.side}, swing: {_turn(door.swing_deg)}"
        yield f"  - {{name: {json.dumps(doorway.name)}, {pose}, width: {_plain(doorway.width)}{leaf}}}"


def _pose(document: Map, at: Point, heading_deg: float) -> str:
    x, y = to_site(document, at)
    return f"x: {_plain(x)}, y: {_plain(y)}, yaw: {_turn(heading_deg)}"


def _turn(degrees: float) -> str:
    return _plain(math.radians(degrees))


def _plain(value: float) -> str:
    return repr(round(value, 9) + 0.0)


def _down(value: float, step: float) -> int:
    """Return the whole number of steps below a value; what is a rounding error away counts as reached."""
    return math.floor(value / step + 1e-6)
