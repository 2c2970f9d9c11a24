"""The cost of importing floors of other programs."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec

import numpy as np

from intellwheels_maps.importers import FloorSource, import_floor
from intellwheels_schemas.errors import WireError
from tests.bench.rows import Row
from tests.maps.importers import drawn_floors as floors


def office(side: int) -> dict[str, bytes]:
    """Return a ROS map of an office with so many cells on each side: walls, doors, furniture and specks."""
    draw = random.Random(1)
    cells = np.zeros((side, side), dtype=bool)
    for at in range(0, side, 100):
        cells[at : at + 3] = True
    for at in range(0, side, 120):
        cells[:, at : at + 3] = True
    for row in range(0, side, 100):
        for column in range(40, side, 120):
            cells[row : row + 3, column : column + 20] = False
    for _ in range(side * side // 12_000):
        row, column = draw.randrange(side - 40), draw.randrange(side - 40)
        cells[row : row + draw.randrange(5, 40), column : column + draw.randrange(5, 40)] = True
    cells ^= np.random.default_rng(1).random((side, side)) < 0.0002
    image = b"P5\n%d %d\n255\n" % (side, side) + np.where(cells, 0, 254).astype(np.uint8).tobytes()
    return {"m.yaml": b"image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nfree_thresh: 0.2\n", "m.pgm": image}


def _beside(files: dict[str, bytes], name: str) -> bytes:
    if name not in files:
        raise WireError("value", f"{name}: expected a file, got none", name)
    return files[name]


def bench(side: int = 1300, floor: int = 7) -> list[Row]:
    """Import a ROS map, and a floor of a few rooms in each other format.

    Args:
        side: Cells on each side of the ROS map; 1300 makes 1.7 million pixels.
        floor: Seed of the other floor.
    """
    drawn = floors.drawn(floor)
    writers: dict[str, Callable[[floors.DrawnFloor], dict[str, bytes]]] = {
        "rmf": floors.write_rmf, "dxf": floors.write_dxf, "geojson": floors.write_geojson, "lab": floors.write_lab,
    }  # fmt: skip
    if find_spec("ifcopenshell") is not None:
        writers["ifc"] = floors.write_ifc
    files = {f"ros, {side * side / 1e6:.1f} million pixels": office(side)}
    files |= {f"{name}, {len(drawn.walls)} walls": write(drawn) for name, write in writers.items()}
    rows = []
    for case, given in files.items():
        name = next(iter(given))
        source = FloorSource(name, given[name], partial(_beside, given))
        import_floor(source)  # the libraries are loaded
        began = time.perf_counter()
        import_floor(source)
        goal = "<= 1" if case.startswith("ros") else ""
        rows.append(Row("imports", case, "import", round(time.perf_counter() - began, 4), "s", goal))
    return rows
