"""What of the scene is drawn for one browser, and remembered there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Final

import msgspec
import viser

from intellwheels_viewer.panels.callbacks import assign, updated
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET


@dataclass(frozen=True)
class Layers:
    """Which layers are shown.

    Attributes:
        full_walls: Walls at their full height, else half of it.
        wedges: What the proximity sensors see.
        lidar: Points of lidars.
        trails: The way behind each agent.
        labels: Names and speeds, and what is said: one label each.
        goals: Where agents want to be.
        plan: The small plan in the panel.
    """

    full_walls: bool = False
    wedges: bool = True
    lidar: bool = True
    trails: bool = True
    labels: bool = True
    goals: bool = True
    plan: bool = True

    def to_json(self) -> str:
        """Return the layers as a browser keeps them."""
        return msgspec.json.encode(self).decode()


def from_json(text: str | None) -> Layers:
    """Return the layers that a browser kept; the usual ones where it kept none or what cannot be read.

    What a page sends is a stranger's: another type is no layer, another name is left out.
    """
    if text is None:
        return Layers()
    try:
        return msgspec.json.decode(text.encode(), type=Layers)
    except (msgspec.DecodeError, UnicodeEncodeError):
        return Layers()


LABELS: Final = {
    "full_walls": "Full walls",
    "wedges": "Sensors",
    "lidar": "Lidar",
    "trails": "Trails",
    "labels": "Names, speech",
    "goals": "Goals",
    "plan": "Plan",
}


class LayersPanel:
    """A checkbox a layer.

    Args:
        gui: Where the elements are made, in the container that is open.
        layers: What is shown first.
        on_change: Gets the layers whenever a page changed one.
        legend: HTML of our own that explains the colours.
    """

    def __init__(
        self, gui: viser.GuiApi, layers: Layers, on_change: Callable[[Layers], None], *, legend: str = ""
    ) -> None:
        gui.add_html(STYLE_SHEET)
        self._layers = layers
        self._on_change = on_change
        self._boxes = {
            field.name: gui.add_checkbox(LABELS[field.name], getattr(layers, field.name)) for field in fields(Layers)
        }
        for name, box in self._boxes.items():
            self._listen(name, box)
        self._legend = gui.add_html(legend)

    @property
    def layers(self) -> Layers:
        """What is shown."""
        return self._layers

    def show(self, layers: Layers) -> None:
        """Tick the boxes as the layers are."""
        self._layers = layers
        for name, box in self._boxes.items():
            assign(box, getattr(layers, name))

    def _listen(self, name: str, box: viser.GuiCheckboxHandle) -> None:
        def change(value: bool) -> None:
            self._layers = replace(self._layers, **{name: bool(value)})
            self._on_change(self._layers)

        updated(box, change)
