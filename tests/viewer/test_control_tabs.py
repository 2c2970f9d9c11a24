"""The tabs Drive and Place: in a live run, and not in a playback."""

from __future__ import annotations

from dataclasses import replace

import pytest

from intellwheels_viewer.page_rights import EVERYTHING, PageRights
from tests.viewer.opened import SNAPSHOT, Opened

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def labels(here: Opened) -> list[str]:
    groups = [each["_tab_labels"] for each in here.browser.gui.values() if "_tab_labels" in each]
    return [label for group in groups for label in group]


def test_a_playback_has_no_drive_and_no_place(here: Opened) -> None:
    here.browser.wait(lambda: "Drive" in labels(here) and "Place" in labels(here))
    here.show(replace(SNAPSHOT, last_tick=3400))
    here.browser.wait(lambda: "Drive" not in labels(here) and "Place" not in labels(here))
    assert "Agents" in labels(here)
    assert "Layers" in labels(here)


def test_a_live_run_has_them_again(here: Opened) -> None:
    here.show(replace(SNAPSHOT, last_tick=3400))
    here.show(SNAPSHOT)
    here.browser.wait(lambda: "Drive" in labels(here) and "Place" in labels(here))


def test_browser_that_may_only_look_has_neither(here: Opened) -> None:
    here.page._visit = PageRights("guests may only look")
    here.show(SNAPSHOT)
    here.browser.wait(lambda: "Drive" not in labels(here) and "Place" not in labels(here))
    here.page._visit = EVERYTHING
    here.show(SNAPSHOT)
    here.browser.wait(lambda: "Drive" in labels(here))
