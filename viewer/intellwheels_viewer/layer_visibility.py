"""Which layers one browser shows. Its own nodes hide the shared nodes of the same name; the choice is stored there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import viser

from intellwheels_schemas.messages import Map
from intellwheels_viewer.drawings.cut_away import hidden, pieces_of
from intellwheels_viewer.drawings.extruded_walls import Walls
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from intellwheels_viewer.drawings.floor_plate import Floor
from intellwheels_viewer.panels import layers_panel
from intellwheels_viewer.panels.layers_panel import Layers
from intellwheels_viewer.stage import LAYERS

if TYPE_CHECKING:
    from intellwheels_schemas.messages import Entity
    from intellwheels_viewer.snapshot import Snapshot

SENSES: Final = frozenset({"all_wedges", "lidar", "trails"})
"""The layers that a view from the chair does not show unless the user wants them there."""
LAYERS_KEY: Final = "intellwheels.layers"


class LayerVisibility:
    """The layers of one browser. Made first of all parts of a page, as it waits for what the browser stored.

    Args:
        client: The browser.
        dark: Whether the shared building has the colours of the dark theme.

    Attributes:
        dark: Whether this browser's building has the colours of the dark theme; it may change.
        layers: The layers that are shown.
        hidden: The browser's own nodes by layer, for layers that were ever hidden.
    """

    def __init__(self, client: viser.ClientHandle, *, dark: bool = False) -> None:
        self._client = client
        self.dark = self._shared_dark = dark
        self._inside = False
        self.layers = layers_panel.from_json(_kept(client))
        self.hidden: dict[str, viser.FrameHandle] = {}
        # A recording has labels for a camera that is not this browser's, which has its own: see `own_drawings`.
        client.scene.add_frame("/labels", show_axes=False, visible=False)
        self._floor: Floor | None = None
        self._floor_of = (-1, dark)
        self._walls: Walls | None = None
        self._walls_of: tuple[int, bool, bool, frozenset[int]] = (-1, dark, False, frozenset())
        self._pieces_of, self._pieces = -1, pieces_of(Map(format="iw.v1", name="none"))
        self._hide()

    def choose(self, layers: Layers) -> None:
        """Show these layers and remember them in this browser."""
        self.layers = layers
        self._client.local_storage.set_item(LAYERS_KEY, layers.to_json())
        self._hide()

    def hiding(self, snapshot: Snapshot, eye: tuple[float, float, float], entity: Entity) -> frozenset[int]:
        """Return the parts of walls that stand between a camera and a body, for `draw_walls`."""
        if snapshot.floor is None:
            return frozenset()
        if self._pieces_of != snapshot.revision:
            self._pieces_of, self._pieces = snapshot.revision, pieces_of(snapshot.floor)
        height = math.inf if self.layers.full_walls else HALF_HEIGHT
        return hidden(self._pieces, eye, (entity.x, entity.y), height)

    def draw_walls(self, snapshot: Snapshot, *, inside: bool, cut: frozenset[int] = frozenset()) -> None:
        """Draw walls at full height if this browser wants them or its camera is inside a room.

        From inside, sensors and trails are hidden unless the user wants them.

        Args:
            snapshot: The run.
            inside: Whether the camera is inside a room.
            cut: Parts of walls that are cut away, see `hiding`.
        """
        if inside != self._inside:
            self._inside = inside
            self._hide()
        self._draw_floor(snapshot)
        whole = self.layers.full_walls or inside
        wanted = (snapshot.revision, self.dark, whole, cut)
        is_shared = self._walls is None and not whole and not cut and self.dark == self._shared_dark
        if snapshot.floor is None or wanted == self._walls_of or is_shared:
            return
        self._walls_of = wanted
        if self._walls is None:
            self._walls = Walls(self._client.scene)
        # These nodes hide the shared ones, so they stay and must be redrawn at half height and for a new map too.
        self._walls.dark = self.dark
        self._walls.show(snapshot.floor, None if whole else HALF_HEIGHT, cut)

    def _draw_floor(self, snapshot: Snapshot) -> None:
        """Draw the floor in the colours of this browser's theme, if the shared one has or had the other theme."""
        wanted = (snapshot.revision, self.dark)
        is_shared = self._floor is None and self.dark == self._shared_dark
        if snapshot.floor is None or wanted == self._floor_of or is_shared:
            return
        self._floor_of = wanted
        if self._floor is None:
            self._floor = Floor(self._client.scene)
        self._floor.dark = self.dark
        self._floor.show(snapshot.floor)

    def _hide(self) -> None:
        for layer, node in LAYERS.items():
            shown = bool(getattr(self.layers, layer))
            if self._inside:
                shown = shown and (self.layers.senses or layer not in SENSES)
            if not shown and layer not in self.hidden:
                self.hidden[layer] = self._client.scene.add_frame(node, show_axes=False, visible=False)
            elif layer in self.hidden:
                self.hidden[layer].visible = shown


def _kept(client: viser.ClientHandle) -> str | None:
    try:
        return client.local_storage.get_item(LAYERS_KEY, timeout=2.0)
    except (TimeoutError, RuntimeError):
        return None  # it does not answer, cannot store anything, or has left
