"""Imports the maps of the ROS map server: a YAML file, and an image of cells. Pure.

The value of a cell follows the map server of Nav2. With p the shade of a pixel in [0, 1], its occupancy is 1 - p, or p
with `negate`. In the modes `trinary` and `scale`, a cell is a wall if its occupancy is above `occupied_thresh`. In the
mode `raw`, the pixel itself is the occupancy in percent. Everything else is not known to be a wall and is left out.

Each run of walls in a row is a box; their union has exactly the area of the cells. Its outline is then simplified: it
moves by less than half a cell. The middles of all cells stay on their side, so a map that is exported again has the
same cells.

A list of places and doorways beside the map, as `export` writes it, is read too.
"""

from __future__ import annotations

import io
import math
import warnings
from typing import Any, Final, NamedTuple

from intellwheels_maps.importers.cell_outlines import cell_area, count_corners, simplified
from intellwheels_maps.importers.floor_draft import FloorDraft
from intellwheels_maps.importers.floor_source import FloorSource, Imported, check_no_level
from intellwheels_maps.importers.ros_places import add_places
from intellwheels_maps.importers.safe_yaml import read_yaml
from intellwheels_maps.importers.wall_outlines import outlines
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown

MAX_PIXELS: Final = 1 << 24
"""Largest image, 16.8 million pixels: 200 x 200 m with cells of 5 cm."""

MAX_CELL_CORNERS: Final = 300_000
"""Most corners that the outlines of the cells may have. A map holds some 30,000; straight walls need far fewer."""

MODES: Final = ("trinary", "scale", "raw")


class _Head(NamedTuple):
    image: str
    resolution: float
    origin: tuple[float, float, float]
    negate: bool
    occupied: float
    free: float
    mode: str


def import_ros_map(source: FloorSource) -> Imported:
    """Return the map that a YAML file of the map server, its image and its list of places describe.

    Raises:
        WireError: One of them is invalid or too large.
    """
    check_no_level(source)
    head = _read_head(source)
    image = FloorSource(head.image, source.beside(head.image), source.beside)
    walls, doubtful = _cells(source, head, image)
    corners = count_corners(walls)
    if corners > MAX_CELL_CORNERS:
        text = f"expected walls with at most {MAX_CELL_CORNERS:,} corners, got {corners:,}; is it a map, without noise?"
        raise source.error(head.image, text, "too-long")
    draft = FloorDraft(source, digits=9)
    rows = walls.shape[0]
    cos, sin = math.cos(head.origin[2]), math.sin(head.origin[2])
    for ring in outlines(simplified(cell_area(walls))):
        points = []
        for column, row in ring:
            along, up = column * head.resolution, (rows - row) * head.resolution
            points.append((head.origin[0] + cos * along - sin * up, head.origin[1] + sin * along + cos * up))
        draft.wall(points, head.image)
    for count, what in doubtful:
        if count:
            draft.leave_out(head.image, f"{count:,} cells, {count * head.resolution**2:,.1f} m2, {what}")
    add_places(source, draft)
    return draft.finish()


def _read_head(source: FloorSource) -> _Head:
    document = read_yaml(source)
    lacking = [name for name in ("image", "resolution", "origin") if name not in document]
    if lacking:
        raise source.error(lacking[0], "expected this key of a ROS map, got none")
    image = document["image"]
    if not isinstance(image, str) or not image:
        raise source.error("image", f"expected the path of an image, got {shown(image)}")
    mode = document.get("mode", "trinary")
    if mode not in MODES:
        raise source.error("mode", f"expected one of {', '.join(MODES)}, got {shown(mode)}")
    origin = document["origin"]
    if not isinstance(origin, list) or len(origin) != 3:
        raise source.error("origin", f"expected x, y and yaw, got {shown(origin)}")
    x, y, yaw = (_number(source, f"origin[{at}]", value, -1e8, 1e8) for at, value in enumerate(origin))
    negate = document.get("negate", 0)
    if negate not in (0, 1):
        raise source.error("negate", f"expected 0 or 1, got {shown(negate)}")
    occupied = _number(source, "occupied_thresh", document.get("occupied_thresh", 0.65), 0.0, 1.0)
    free = _number(source, "free_thresh", document.get("free_thresh", 0.25), 0.0, 1.0)
    resolution = _number(source, "resolution", document["resolution"], 1e-4, 100.0)
    return _Head(image, resolution, (x, y, yaw), bool(negate), occupied, free, mode)


def _number(source: FloorSource, where: str, value: object, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise source.error(where, f"expected a number in [{low:g}, {high:g}], got {shown(value)}")
    return float(value)


def _cells(source: FloorSource, head: _Head, image: FloorSource) -> tuple[Any, list[tuple[int, str]]]:
    """Return which cells are walls, bool[rows, columns], and how many of the others are not known to be free."""
    import numpy as np  # noqa: PLC0415 - of an extra

    shade, opaque = _shades(source, head, image)
    if head.mode == "raw":
        percent = np.rint(shade * 255)
        walls = (percent <= 100) & (percent > head.occupied * 100)
        unknown = percent > 100
        between = ~walls & ~unknown & (percent >= head.free * 100) & (percent > 0)
    else:
        occupancy = shade if head.negate else 1.0 - shade
        walls = (occupancy > head.occupied) & opaque
        unknown = ~opaque
        between = ~walls & opaque & (occupancy >= head.free)
    known = int(np.count_nonzero(between))
    return walls, [
        (int(np.count_nonzero(unknown)), "unknown"),
        (known, "unknown" if head.mode == "trinary" else "neither certainly walls nor certainly free"),
    ]


def _too_large(source: FloorSource, image: str, width: int, height: int) -> WireError:
    return source.error(image, f"expected at most {MAX_PIXELS:,} pixels, got {width:,} x {height:,}", "too-long")


def _shades(source: FloorSource, head: _Head, file: FloorSource) -> tuple[Any, Any]:
    """Return the shade of each pixel in [0, 1], float32[rows, columns], and whether it is opaque."""
    import numpy as np  # noqa: PLC0415 - of an extra
    from PIL import Image  # noqa: PLC0415

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a bomb is found by its size, below
            with Image.open(io.BytesIO(file.data)) as image:
                width, height = image.size
                if width * height > MAX_PIXELS:
                    raise _too_large(source, head.image, width, height)
                alpha = "A" in image.getbands() or "transparency" in image.info
                deep = image.mode.startswith("I")
                if deep:
                    pixels = np.asarray(image).astype(np.float32) / 65535
                    return pixels, np.ones(pixels.shape, dtype=bool)
                pixels = np.asarray(image.convert("RGBA" if alpha else "L" if image.mode in "1L" else "RGB"))
    except WireError:
        raise
    except Image.DecompressionBombError:
        text = f"expected at most {MAX_PIXELS:,} pixels, got an image of far more"
        raise source.error(head.image, text, "too-long") from None
    except (OSError, ValueError, SyntaxError) as error:
        text = f"expected an image in PGM or PNG, got {shown(str(error))}"
        raise source.error(head.image, text, "malformed") from None
    opaque = pixels[..., 3] == 255 if alpha else np.ones(pixels.shape[:2], dtype=bool)
    if pixels.ndim == 2:
        return pixels.astype(np.float32) / 255, opaque
    # The map server takes the mean of all channels in the mode trinary, and of the colours in the others.
    if head.mode == "trinary":
        return pixels.mean(axis=2, dtype=np.float32) / 255, np.ones(pixels.shape[:2], dtype=bool)
    return pixels[..., :3].mean(axis=2, dtype=np.float32) / 255, opaque | (head.mode == "raw")
