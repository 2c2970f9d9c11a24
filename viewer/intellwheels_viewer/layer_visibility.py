"""Which layers one browser sees, kept by that browser: its own nodes stand before those of all."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import viser

from intellwheels_viewer.drawings.extruded_walls import Walls
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from intellwheels_viewer.panels import layers_panel
from intellwheels_viewer.panels.layers_panel import Layers
from intellwheels_viewer.stage import LAYERS

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

LAYERS_KEY: Final = "intellwheels.layers"


class LayerVisibility:
    """The layers of one browser. Made before anything else of a page: it waits for what the browser kept.

    Args:
        client: The browser.

    Attributes:
        layers: What is shown.
        hidden: The browser's own nodes, by layer, of those that were hidden ever.
    """

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self.layers = layers_panel.from_json(_kept(client))
        self.hidden: dict[str, viser.FrameHandle] = {}
        self._walls: Walls | None = None
        self._walls_of: tuple[int, bool] = (-1, False)
        self._hide()

    def choose(self, layers: Layers) -> None:
        """Show these layers, in this browser from now on."""
        self.layers = layers
        self._client.local_storage.set_item(LAYERS_KEY, layers.to_json())
        self._hide()

    def draw_walls(self, seen: Snapshot, *, inside: bool) -> None:
        """Draw walls of full height where this browser wants them, or looks from inside a room."""
        whole = self.layers.full_walls or inside
        wanted = (seen.revision, whole)
        if seen.floor is None or wanted == self._walls_of or (self._walls is None and not whole):
            return
        self._walls_of = wanted
        if self._walls is None:
            self._walls = Walls(self._client.scene)
        # Its nodes hide those of all browsers, so they are kept: drawn low again, and of another floor too.
        self._walls.show(seen.floor, None if whole else HALF_HEIGHT)

    def _hide(self) -> None:
        for layer, node in LAYERS.items():
            shown = bool(getattr(self.layers, layer))
            if not shown and layer not in self.hidden:
                self.hidden[layer] = self._client.scene.add_frame(node, show_axes=False, visible=False)
            elif layer in self.hidden:
                self.hidden[layer].visible = shown


def _kept(client: viser.ClientHandle) -> str | None:
    try:
        return client.local_storage.get_item(LAYERS_KEY, timeout=2.0)
    except (TimeoutError, RuntimeError):
        return None  # it does not answer, may not keep anything, or has left
