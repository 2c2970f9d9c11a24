"""ROS maps: modes, thresholds, origin, and what is refused."""

from __future__ import annotations

import io
import struct
import zlib
from typing import Any

import numpy as np
import pytest
import yaml
from PIL import Image

from intellwheels_maps.importers import Imported
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case
from tests.maps.importers.drawn_floors import area_of, read

HEAD = {"image": "m.pgm", "resolution": 1.0, "origin": [0.0, 0.0, 0.0]}


def png(pixels: object, mode: str | None = None) -> bytes:
    data = io.BytesIO()
    Image.fromarray(np.asarray(pixels, dtype=np.uint8), mode).save(data, format="PNG")
    return data.getvalue()


def imported(pixels: bytes, **head: Any) -> Imported:
    return read({"m.yaml": yaml.safe_dump(HEAD | head).encode(), "m.pgm": pixels})


# Shades of one row, from black to white: occupancies 1, 0.7, 0.5, 0.3 and 0.
ROW = [[0, 76, 128, 178, 255]]


@pytest.mark.parametrize(
    ("head", "west", "east", "left_out"),
    [
        ({}, 0.0, 2.0, ["m.pgm: 2 cells, 2.0 m2, unknown"]),
        ({"occupied_thresh": 0.75}, 0.0, 1.0, ["m.pgm: 3 cells, 3.0 m2, unknown"]),
        ({"negate": 1}, 3.0, 5.0, ["m.pgm: 2 cells, 2.0 m2, unknown"]),
        ({"mode": "scale"}, 0.0, 2.0, ["m.pgm: 2 cells, 2.0 m2, neither certainly walls nor certainly free"]),
        ({"mode": "raw"}, 1.0, 2.0, ["m.pgm: 3 cells, 3.0 m2, unknown"]),
        ({"free_thresh": 0.4}, 0.0, 2.0, ["m.pgm: 1 cells, 1.0 m2, unknown"]),
        ({"origin": [10.0, -3.0, 0.0]}, 10.0, 12.0, ["m.pgm: 2 cells, 2.0 m2, unknown"]),
    ],
)
def test_modes_and_thresholds(head: dict[str, object], west: float, east: float, left_out: list[str]) -> None:
    found = imported(png(ROW), **head)
    bounds = area_of(found.map).bounds
    assert (bounds[0], bounds[2]) == (west, east)
    assert list(found.left_out) == left_out


def test_the_first_row_is_the_north() -> None:
    found = imported(png([[0, 255], [255, 255]]), origin=[0.0, 0.0, 0.0])
    assert area_of(found.map).bounds == (0.0, 1.0, 1.0, 2.0)


def test_colours_and_alpha_are_read_as_the_map_server_does() -> None:
    # The mode trinary takes the mean of all channels: opaque black has a shade of a quarter.
    black = [[[0, 0, 0, 255], [0, 0, 0, 0]]]
    assert area_of(imported(png(black), occupied_thresh=0.8).map).bounds[:3:2] == (1.0, 2.0)
    assert area_of(imported(png(black), mode="scale").map).bounds[:3:2] == (0.0, 1.0)
    assert area_of(imported(png([[[0, 0, 0], [255, 255, 255]]])).map).area == 1.0


def test_pgm_as_text_and_of_sixteen_bits() -> None:
    assert area_of(imported(b"P2\n# by hand\n2 1\n255\n0 255\n").map).area == 1.0
    assert area_of(imported(b"P5\n2 1\n65535\n" + struct.pack(">HH", 0, 65535)).map).area == 1.0


def test_far_maps_keep_their_origin_and_small_numbers() -> None:
    found = imported(png([[0, 255]]), origin=[489123.5, 4412345.0, 0.0]).map
    assert found.offset is not None
    assert (found.offset.x, found.offset.y) == (489123.0, 4412345.0)
    assert area_of(found).bounds == (0.5, 0.0, 1.5, 1.0)


@every_case(
    ("head", "text"),
    [
        ({"resolution": 0}, r"m\.yaml: resolution: expected a number in \[0\.0001, 100\], got 0"),
        ({"resolution": "x"}, r"m\.yaml: resolution: expected a number"),
        ({"resolution": float("nan")}, r"m\.yaml: resolution: expected a number"),
        ({"origin": [0, 0]}, r"m\.yaml: origin: expected x, y and yaw, got a list"),
        ({"origin": [0, 0, "a"]}, r"m\.yaml: origin\[2\]: expected a number"),
        ({"mode": "colour"}, r"m\.yaml: mode: expected one of trinary, scale, raw, got 'colour'"),
        ({"negate": 2}, r"m\.yaml: negate: expected 0 or 1, got 2"),
        ({"occupied_thresh": 65}, r"m\.yaml: occupied_thresh: expected a number in \[0, 1\], got 65"),
        ({"image": "none.pgm"}, r"none\.pgm: expected a file"),
        ({"image": 3}, r"m\.yaml: image: expected the path of an image, got 3"),
        ({"resolution": 100.0}, r"m\.yaml: expected at most 9,000 m across, got .* are the units right\?"),
        ({"resolution": 0.001}, r"m\.yaml: expected at least 0\.5 m across, got .* are the units right\?"),
    ],
)
def test_wrong_values_are_refused_with_their_key(head: dict[str, object], text: str) -> None:
    row = np.full((1, 200), 255)
    row[0, [0, -1]] = 0
    with pytest.raises(WireError, match=text):
        imported(png(row), **head)


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def test_images_that_are_too_large_cut_or_ragged_are_refused() -> None:
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 60_000, 60_000, 8, 0, 0, 0, 0))
    bomb = b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(bytes(1 << 20))) + chunk(b"IEND", b"")
    with pytest.raises(WireError, match=r"m\.pgm: expected at most 16,777,216 pixels, got an image of far more"):
        imported(bomb)
    with pytest.raises(WireError, match=r"m\.pgm: expected at most 16,777,216 pixels, got 5,000 x 5,000"):
        imported(b"P5\n5000 5000\n255\n")
    with pytest.raises(WireError, match=r"m\.pgm: expected an image in PGM or PNG"):
        imported(b"P5\n100 100\n255\n" + bytes(50))
    noise = np.random.default_rng(1).integers(0, 2, (3163, 3163), dtype=np.uint8) * 255  # 10^7 pixels
    with pytest.raises(WireError, match=r"m\.pgm: expected walls with at most 300,000 corners, got .* without noise\?"):
        imported(b"P5\n3163 3163\n255\n" + noise.tobytes())
    with pytest.raises(WireError, match="expected at least one wall, got none"):
        imported(png([[255]]))
