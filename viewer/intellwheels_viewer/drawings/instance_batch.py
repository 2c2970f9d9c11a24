"""A node of many equal solids, or of equal surfaces with their own colours.

It is made once; each tick assigns arrays, and unchanged arrays are not sent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeAlias, cast

import numpy as np
import numpy.typing as npt
import viser

from intellwheels_viewer.drawings.glb import Surface, glb
from intellwheels_viewer.drawings.solids import Array, Solid
from intellwheels_viewer.palette import light_bytes

Bytes: TypeAlias = npt.NDArray[np.uint8]


def quaternions(headings: npt.ArrayLike) -> Array:
    """Return rotations about the vertical axis as (N, 4) w, x, y, z."""
    half = np.asarray(headings, np.float64).reshape(-1) / 2
    turned = np.zeros((len(half), 4), np.float32)
    turned[:, 0], turned[:, 3] = np.cos(half), np.sin(half)
    return turned


class InstanceBatch:
    """A node of equal solids at many poses.

    Attributes:
        handle: Viser's handle, for clicks and drags; None until the first instance is shown.
        names: The agent of each instance, in the order of viser's `instance_index`.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        name: str,
        shape: Solid | Surface,
        *,
        opacity: float | None = None,
        side: Literal["front", "double"] = "front",
        shadow: bool = False,
        made: Callable[[InstanceBatch], None] | None = None,
    ) -> None:
        self.handle: viser.BatchedMeshHandle | None = None
        self.names: tuple[str, ...] = ()
        self._scene, self._name = scene, name
        self._shape = shape if isinstance(shape, Solid) else shape.solid
        self._glb = b"" if isinstance(shape, Solid) or not len(self._shape.faces) else glb([shape])
        self._visible = True
        self._assigned: dict[str, npt.NDArray[Any]] = {}
        self._opacity, self._side, self._shadow, self._made = opacity, side, shadow, made

    def show(
        self,
        positions: npt.ArrayLike,
        wxyzs: npt.ArrayLike,
        colours: npt.ArrayLike,
        *,
        scales: npt.ArrayLike | None = None,
        opacities: npt.ArrayLike | None = None,
        names: Sequence[str] = (),
    ) -> None:
        """Show the solid at N poses.

        Args:
            positions: (N, 3), metres.
            wxyzs: (N, 4).
            colours: (N, 3), sRGB bytes.
            scales: (N,) or (N, 3); always or never given for one node.
            opacities: (N,) in [0, 1]; always or never given for one node.
            names: The agent of each instance.
        """
        places = np.asarray(positions, np.float32).reshape(-1, 3)
        turns = np.asarray(wxyzs, np.float32).reshape(-1, 4)
        tints = light_bytes(np.asarray(colours).reshape(-1, 3))
        sizes = None if scales is None else np.asarray(scales, np.float32)
        shares = None if opacities is None else np.asarray(opacities, np.float32)
        self.names = tuple(names)
        if self.handle is None:
            if len(places) and len(self._shape.faces):
                self._make(places, turns, tints, sizes, shares)
            return
        self._see(bool(len(places)))
        if not len(places):
            return
        self._assign("batched_positions", places)
        self._assign("batched_wxyzs", turns)
        if not self._glb:
            self._assign("batched_colors", tints)
        self._assign("batched_scales", sizes)
        self._assign("batched_opacities", shares)

    def _see(self, visible: bool) -> None:
        if self.handle is not None and visible != self._visible:
            self.handle.visible = self._visible = visible

    def _assign(self, name: str, value: npt.NDArray[Any] | None) -> None:
        """Assign an array that changed. Viser compares too, but takes ten times as long."""
        if value is not None and not np.array_equal(value, self._assigned.get(name, ())):
            self._assigned[name] = value
            setattr(self.handle, name, value)

    def _make(self, places: Array, turns: Array, tints: Bytes, sizes: Array | None, shares: Array | None) -> None:
        if self._glb:
            made = self._scene.add_batched_glb(
                self._name,
                self._glb,
                turns,
                places,
                batched_scales=sizes,
                lod="off",
                cast_shadow=self._shadow,
                receive_shadow=self._shadow,
            )
            # Both handles have the same events, and the same arrays but for the colours.
            self.handle = cast("viser.BatchedMeshHandle", made)
        else:
            self.handle = self._simple(places, turns, tints, sizes, shares)
        if self._made is not None:
            self._made(self)

    def _simple(
        self, places: Array, turns: Array, tints: Bytes, sizes: Array | None, shares: Array | None
    ) -> viser.BatchedMeshHandle:
        return self._scene.add_batched_meshes_simple(
            self._name,
            self._shape.vertices,
            self._shape.faces,
            turns,
            places,
            batched_scales=sizes,
            batched_colors=tints,
            batched_opacities=shares,
            lod="off",
            opacity=self._opacity,
            side=self._side,
            cast_shadow=self._shadow,
            receive_shadow=self._shadow,
        )
