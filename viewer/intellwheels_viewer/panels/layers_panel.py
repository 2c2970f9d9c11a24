"""The layers that one browser shows. The browser stores its choice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Final

import msgspec
import viser

from intellwheels_viewer.panels.callbacks import updated
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET


@dataclass(frozen=True)
class Layers:
    """Which layers are shown.

    Attributes:
        full_walls: Walls at full height instead of half height.
        wedges: The readings of the proximity sensors of the selected agent.
        all_wedges: Those of all agents.
        lidar: The points of lidars.
        trails: The path behind each agent.
        labels: Names, speeds and speech.
        goals: The goals of agents.
        plan: The small plan in the panel.
    """

    full_walls: bool = False
    wedges: bool = True
    all_wedges: bool = False
    lidar: bool = True
    trails: bool = True
    labels: bool = True
    goals: bool = True
    plan: bool = True

    def to_json(self) -> str:
        """Return the layers as the JSON that a browser stores."""
        return msgspec.json.encode(self).decode()


def from_json(text: str | None) -> Layers:
    """Return the layers that a browser stored, or the default ones if it stored none or they cannot be read.

    The values of a page are not trusted: unknown names are ignored, and a wrong type gives the default layers.
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
    "all_wedges": "Sensors of all",
    "lidar": "Lidar",
    "trails": "Trails",
    "labels": "Names, speech",
    "goals": "Goals",
    "plan": "Plan",
}


class LayersPanel:
    """A checkbox for each layer.

    Args:
        gui: Makes the elements, in the open container.
        layers: The layers that are shown first.
        on_change: Called with the layers when the user changed one.
        legend: HTML that explains the colours.
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

    def _listen(self, name: str, box: viser.GuiCheckboxHandle) -> None:
        def change(value: bool) -> None:
            self._layers = replace(self._layers, **{name: bool(value)})
            self._on_change(self._layers)

        updated(box, change)
