"""Binary glTF: meshes with a colour for each vertex or a repeated picture, which viser's simple meshes cannot have.

Pure. A surface is one draw call. Source: glTF 2.0 specification (Khronos, 2021), chapters 3 and 4.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from intellwheels_viewer.drawings.solids import Array, Solid, join
from intellwheels_viewer.palette import RGB, light_bytes, linear

Bytes = npt.NDArray[np.uint8]

WHITE: Final[RGB] = (255, 255, 255)
_FLOAT: Final = 5126
_UNSIGNED_INT: Final = 5125
_UNSIGNED_BYTE: Final = 5121
_REPEAT: Final = 10497
_LINEAR: Final = 9729
_LINEAR_MIPMAP_LINEAR: Final = 9987


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles with one material.

    Attributes:
        solid: The triangles.
        rgb: The colour by which all others are multiplied, sRGB.
        colours: A colour for each vertex, sRGB bytes, (V, 3), or (V, 4) with the opacity; None for none.
        uv: The place in the picture of each vertex, (V, 2), 1 for its whole width; beyond it the picture repeats.
        picture: The bytes of a PNG or JPEG file.
        blend: Whether the opacities of vertices and picture count.
        glows: Whether it has its full colour without any light.
    """

    solid: Solid
    rgb: RGB = WHITE
    colours: Bytes | None = None
    uv: Array | None = None
    picture: bytes | None = None
    blend: bool = False
    glows: bool = False


def painted(solids: Mapping[RGB, Solid]) -> Surface:
    """Return solids by colour as one surface."""
    colours = [np.tile(np.array(rgb, np.uint8), (len(solid.vertices), 1)) for rgb, solid in solids.items()]
    return Surface(join(solids.values()), colours=np.concatenate([np.zeros((0, 3), np.uint8), *colours]))


def glb(surfaces: Sequence[Surface]) -> bytes:
    """Return surfaces as a GLB file; those without triangles are left out."""
    maker = _Maker()
    for surface in surfaces:
        if len(surface.solid.faces):
            maker.add(surface)
    return maker.file()


def normals(solid: Solid) -> Array:
    """Return the mean direction of the faces at each vertex, weighted by their areas, (V, 3)."""
    a, b, c = (solid.vertices[solid.faces[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a)
    summed = np.zeros_like(solid.vertices)
    for corner in range(3):
        np.add.at(summed, solid.faces[:, corner], across)
    length = np.linalg.norm(summed, axis=1, keepdims=True)
    return np.where(length > 0.0, summed / np.maximum(length, 1e-12), np.array([0, 0, 1], np.float32)).astype(
        np.float32
    )


class _Maker:
    def __init__(self) -> None:
        self._data = bytearray()
        self._tree: dict[str, Any] = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "buffers": [{}], "bufferViews": [], "accessors": [], "materials": [], "meshes": [{"primitives": []}],
        }  # fmt: skip

    def add(self, surface: Surface) -> None:
        solid = surface.solid
        places = self._accessor(solid.vertices.astype("<f4"), _FLOAT, "VEC3")
        lowest, highest = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
        self._tree["accessors"][places] |= {"min": lowest.tolist(), "max": highest.tolist()}
        attributes = {"POSITION": places, "NORMAL": self._accessor(normals(solid).astype("<f4"), _FLOAT, "VEC3")}
        if surface.uv is not None:
            attributes["TEXCOORD_0"] = self._accessor(surface.uv.astype("<f4"), _FLOAT, "VEC2")
        if surface.colours is not None:
            attributes["COLOR_0"] = self._accessor(_opaque(surface.colours), _UNSIGNED_BYTE, "VEC4", normalized=True)
        indices = self._accessor(solid.faces.astype("<u4").reshape(-1), _UNSIGNED_INT, "SCALAR")
        self._tree["meshes"][0]["primitives"].append(
            {"attributes": attributes, "indices": indices, "material": self._material(surface)}
        )

    def file(self) -> bytes:
        if not self._data:
            raise ValueError("glb: expected a surface with triangles, got none")
        self._tree["buffers"][0]["byteLength"] = len(self._data)
        text = json.dumps(self._tree, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + 8 + len(self._data)
        head = struct.pack("<4sII", b"glTF", 2, size)
        chunks = ((b"JSON", text), (b"BIN\0", bytes(self._data)))
        return head + b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)

    def _view(self, data: bytes) -> int:
        self._tree["bufferViews"].append({"buffer": 0, "byteOffset": len(self._data), "byteLength": len(data)})
        self._data += data + b"\0" * (-len(data) % 4)
        return len(self._tree["bufferViews"]) - 1

    def _accessor(self, values: npt.NDArray[Any], kind: int, shape: str, *, normalized: bool = False) -> int:
        made = {"bufferView": self._view(values.tobytes()), "componentType": kind, "count": len(values), "type": shape}
        self._tree["accessors"].append(made | ({"normalized": True} if normalized else {}))
        return len(self._tree["accessors"]) - 1

    def _material(self, surface: Surface) -> int:
        shade: dict[str, Any] = {
            "baseColorFactor": [*linear(surface.rgb).tolist(), 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0,
        }  # fmt: skip
        if surface.picture is not None:
            shade["baseColorTexture"] = {"index": self._texture(surface.picture)}
        made: dict[str, Any] = {"pbrMetallicRoughness": shade}
        if surface.blend:
            made["alphaMode"] = "BLEND"
        if surface.glows:
            made["extensions"] = {"KHR_materials_unlit": {}}
            self._tree["extensionsUsed"] = ["KHR_materials_unlit"]
        self._tree["materials"].append(made)
        return len(self._tree["materials"]) - 1

    def _texture(self, picture: bytes) -> int:
        tree = self._tree
        wrap = {"wrapS": _REPEAT, "wrapT": _REPEAT, "magFilter": _LINEAR, "minFilter": _LINEAR_MIPMAP_LINEAR}
        tree.setdefault("samplers", [wrap])
        kind = "image/png" if picture.startswith(b"\x89PNG") else "image/jpeg"
        tree.setdefault("images", []).append({"bufferView": self._view(picture), "mimeType": kind})
        tree.setdefault("textures", []).append({"sampler": 0, "source": len(tree["images"]) - 1})
        return len(tree["textures"]) - 1


def _opaque(colours: Bytes) -> Bytes:
    """Return sRGB bytes as linear RGBA bytes."""
    opacity = colours[:, 3:4] if colours.shape[1] == 4 else np.full((len(colours), 1), 255, np.uint8)
    return np.concatenate([light_bytes(colours[:, :3]), opacity.astype(np.uint8)], axis=1)
