"""Which layers are shown, and how they are remembered."""

from __future__ import annotations

from dataclasses import asdict, fields

import pytest
import viser

from intellwheels_viewer.panels.layers_panel import LABELS, Layers, LayersPanel, from_json
from tests.viewer.panels.panel import Calls, enter


def test_layers_come_back_from_a_browser_as_they_went() -> None:
    layers = Layers(full_walls=True, trails=False)
    assert from_json(layers.to_json()) == layers


@pytest.mark.parametrize(
    "text", [None, "", "[]", '{"wedges":"no"}', "{", '{"wedges":null}', '{"eye_height":99}', "\ud800"]
)
def test_what_cannot_be_read_gives_the_usual_layers(text: str | None) -> None:
    assert from_json(text) == Layers()


def test_layers_of_another_version_are_taken_as_far_as_they_go() -> None:
    assert from_json('{"trails":false,"rainbows":true}') == Layers(trails=False)


def test_every_layer_has_a_label() -> None:
    assert LABELS.keys() == {field.name for field in fields(Layers)}


def test_a_box_changes_its_layer_only(gui: viser.GuiApi, calls: Calls) -> None:
    panel = LayersPanel(gui, Layers(lidar=False), calls.to("layers"), legend="<i>legend</i>")
    enter(panel._boxes["wedges"], False)
    assert calls == [("layers", Layers(lidar=False, wedges=False))]
    assert panel._legend.content == "<i>legend</i>"


def test_boxes_are_ticked_as_the_layers_are(gui: viser.GuiApi, calls: Calls) -> None:
    panel = LayersPanel(gui, Layers(goals=False), calls.to("layers"))
    values = {name: box.value for name, box in (panel._boxes | panel._numbers).items()}
    assert values == asdict(Layers(goals=False))
    assert calls == []


def test_a_field_changes_its_number_and_a_page_can_send_no_other(gui: viser.GuiApi, calls: Calls) -> None:
    panel = LayersPanel(gui, Layers(), calls.to("layers"))
    enter(panel._numbers["eye_height"], 1.4)
    assert calls == [("layers", Layers(eye_height=1.4))]
    enter(panel._numbers["eye_height"], 1e9)
    enter(panel._numbers["field_of_view"], "wide")
    assert len(calls) == 1
