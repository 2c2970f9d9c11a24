"""The layers that one browser shows. The browser stores its choice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any, Final

import msgspec
import viser
from msgspec import Meta

from intellwheels_viewer.head_turn import EYE_RANGE, EYES, FIELD, FIELD_RANGE
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
        senses: Whether the view from the chair shows sensors and trails too.
        eye_height: Of the user in the view from the chair, in metres.
        field_of_view: Vertical angle of the view from the chair, in degrees.
    """

    full_walls: bool = False
    wedges: bool = True
    all_wedges: bool = False
    lidar: bool = True
    trails: bool = True
    labels: bool = True
    goals: bool = True
    plan: bool = True
    senses: bool = False
    eye_height: Annotated[float, Meta(ge=EYE_RANGE[0], le=EYE_RANGE[1])] = EYES
    field_of_view: Annotated[float, Meta(ge=FIELD_RANGE[0], le=FIELD_RANGE[1])] = FIELD

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
    "senses": "Sensors from the chair",
    "eye_height": "Eye height (m)",
    "field_of_view": "Field of view (°)",
}

_RANGES: Final = {"eye_height": (*EYE_RANGE, 0.05), "field_of_view": (*FIELD_RANGE, 1.0)}
"""The smallest and the largest value of what is a number, and its step."""


class LayersPanel:
    """A checkbox for each layer, and a field for what is a number.

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
            field.name: gui.add_checkbox(LABELS[field.name], getattr(layers, field.name))
            for field in fields(Layers)
            if field.name not in _RANGES
        }
        self._numbers = {
            name: gui.add_number(LABELS[name], getattr(layers, name), min=low, max=high, step=step)
            for name, (low, high, step) in _RANGES.items()
        }
        for name, box in self._boxes.items():
            self._listen(name, box)
        for name, box_of_number in self._numbers.items():
            self._listen_number(name, box_of_number)
        self._legend = gui.add_html(legend)

    def _listen(self, name: str, box: viser.GuiCheckboxHandle) -> None:
        def change(value: bool) -> None:
            self._layers = replace(self._layers, **{name: bool(value)})
            self._on_change(self._layers)

        updated(box, change)

    def _listen_number(self, name: str, box: viser.GuiNumberHandle[float]) -> None:
        low, high, _ = _RANGES[name]

        def change(value: float) -> None:
            # A page can send any number.
            if isinstance(value, int | float) and low <= value <= high:
                changed: dict[str, Any] = {name: float(value)}
                self._layers = replace(self._layers, **changed)
                self._on_change(self._layers)

        updated(box, change)
