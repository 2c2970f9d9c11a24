"""What a page does with the link by which its browser came."""

from __future__ import annotations

from dataclasses import replace

import pytest

from intellwheels_schemas.messages import Seek
from intellwheels_viewer.panels.page_shell import Window
from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.opened import SNAPSHOT, Opened
from tests.viewer.wire import until

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def come(here: Opened, query: str) -> None:
    here.page._resized(Window(query=query))


def selection(here: Opened) -> str | None:
    return here.page.selected


def told(here: Opened, words: str) -> None:
    here.browser.wait(lambda: any(words in str(message) for message in here.browser.heard))


def test_a_link_selects_and_looks_once_there_is_a_run(here: Opened) -> None:
    come(here, "?camera=plan&agent=b&eye=1,2,30&to=1,2.1,0")
    here.show(Snapshot())
    assert selection(here) is None
    here.show(SNAPSHOT)
    assert selection(here) == "b"
    assert here.page.camera.mode == "plan"
    until(lambda: tuple(here.client.camera.position) == pytest.approx((1.0, 2.0, 30.0)))
    here.page.select("a")
    come(here, "?agent=b")
    here.show(SNAPSHOT)
    assert selection(here) == "a"


def test_a_playback_goes_to_the_tick_and_a_live_run_says_that_it_cannot(here: Opened) -> None:
    come(here, "?tick=40")
    here.show(replace(SNAPSHOT, last_tick=100))
    assert here.network.wished() == Seek(tick=40)


def test_a_live_run_says_that_it_cannot_go_back(here: Opened) -> None:
    come(here, "?tick=40&camera=up")
    told(here, "camera: expected one of")
    here.show(SNAPSHOT)
    told(here, "It shows tick 40.")
    assert here.network.asked == []


def test_a_body_that_is_not_there_is_named(here: Opened) -> None:
    come(here, "?agent=nobody")
    here.show(SNAPSHOT)
    told(here, "The link selects a body that is not here")
    assert here.page.selected is None
