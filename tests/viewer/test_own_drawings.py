"""What one browser draws for itself: labels for its camera, and the wedges of its selection."""

from __future__ import annotations

from dataclasses import replace

import pytest

from intellwheels_viewer.own_drawings import LABELS, WEDGES
from intellwheels_viewer.panels.layers_panel import Layers
from tests.viewer.opened import SNAPSHOT, Opened
from tests.viewer.panels import made_up

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def test_a_browser_has_labels_of_its_own(here: Opened) -> None:
    here.browser.wait(lambda: f"{LABELS}/a" in here.browser.scene)
    assert f"{LABELS}/b" in here.browser.scene


def test_wedges_are_those_of_the_selected_until_the_user_wants_all(here: Opened) -> None:
    run = made_up.snapshot()
    here.show(run)
    assert not any(name.startswith(f"{WEDGES}/") for name in here.browser.scene)
    here.page.select("chair1")
    here.show(run)
    here.browser.wait(lambda: f"{WEDGES}/bars" in here.browser.scene)
    own = here.page._own
    assert own._frames[WEDGES].visible
    assert not here.page.shows_all_wedges
    here.page._layers.choose(replace(Layers(), all_wedges=True))
    here.show(run)
    assert not own._frames[WEDGES].visible
    assert here.page.shows_all_wedges


def test_labels_that_are_hidden_are_not_drawn(here: Opened) -> None:
    here.page._layers.choose(replace(Layers(), labels=False))
    here.show(SNAPSHOT)
    assert not here.page._own._frames[LABELS].visible
