from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import pytest

from intellwheels_viewer.drawings.glb import Surface, glb, normals, painted
from intellwheels_viewer.drawings.solids import Solid, box, sheet
from intellwheels_viewer.palette import light_bytes

CUBE = box(0.0, 1.0, 0.0, 1.0, 0.5, 1.5)
FLAT = sheet([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)], 0.25)


def opened(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the tree and the buffer of a GLB file."""
    magic, version, size = struct.unpack_from("<4sII", data)
    assert (magic, version, size) == (b"glTF", 2, len(data))
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def values(data: bytes, index: int, kind: str) -> np.ndarray[tuple[int, ...], np.dtype[Any]]:
    tree, buffer = opened(data)
    accessor = tree["accessors"][index]
    view = tree["bufferViews"][accessor["bufferView"]]
    return np.frombuffer(buffer[view["byteOffset"] :][: view["byteLength"]], kind)


def test_a_file_has_the_triangles_of_its_surfaces_and_leaves_empty_ones_out() -> None:
    data = glb([Surface(CUBE), Surface(Solid()), Surface(FLAT)])
    first, second = opened(data)[0]["meshes"][0]["primitives"]
    assert values(data, first["attributes"]["POSITION"], "<f4").reshape(-1, 3) == pytest.approx(CUBE.vertices)
    assert values(data, second["indices"], "<u4").reshape(-1, 3).tolist() == FLAT.faces.tolist()


def test_solids_by_colour_have_their_colours_in_linear_light() -> None:
    surface = painted({(200, 100, 50): CUBE, (10, 20, 30): FLAT})
    data = glb([surface])
    (made,) = opened(data)[0]["meshes"][0]["primitives"]
    colours = values(data, made["attributes"]["COLOR_0"], "u1").reshape(-1, 4)
    assert colours[0].tolist() == [*light_bytes([200, 100, 50]).tolist(), 255]
    assert colours[-1].tolist() == [*light_bytes([10, 20, 30]).tolist(), 255]


def test_a_picture_repeats_and_letters_are_blended_and_a_lamp_needs_no_light() -> None:
    uv = FLAT.vertices[:, :2].copy()
    tree, _ = opened(glb([Surface(FLAT, uv=uv, picture=b"\x89PNG", blend=True), Surface(CUBE, glows=True)]))
    assert tree["images"][0]["mimeType"] == "image/png"
    assert tree["samplers"][0]["wrapS"] == 10497
    assert tree["materials"][0]["alphaMode"] == "BLEND"
    assert "KHR_materials_unlit" in tree["materials"][1]["extensions"]
    assert tree["extensionsUsed"] == ["KHR_materials_unlit"]


def test_normals_point_away_from_the_solid() -> None:
    assert normals(FLAT).tolist() == [[0.0, 0.0, 1.0]] * 4


def test_nothing_is_no_file() -> None:
    with pytest.raises(ValueError, match="expected a surface with triangles"):
        glb([Surface(Solid())])
