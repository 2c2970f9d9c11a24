"""The theme of one browser and where its panels are."""

from __future__ import annotations

from typing import Any, cast

import pytest
import viser

from intellwheels_viewer.page_window import BAR, SLIM, THEME_KEY, WIDTH
from intellwheels_viewer.panels.page_shell import Window
from tests.viewer.browser import opened
from tests.viewer.opened import Opened
from tests.viewer.wire import until

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def newest(here: Opened, kind: str) -> list[dict[str, object]]:
    return [message for message in list(here.browser.heard) if message["type"] == kind]


def is_dark(here: Opened) -> bool:
    themes = newest(here, "ThemeConfigurationMessage")
    return bool(themes) and bool(themes[-1]["dark_mode"])


def test_a_page_is_as_dark_as_the_system_until_the_user_chooses(here: Opened) -> None:
    window = here.page._window
    assert (window.theme, window.is_dark) == ("System", False)
    window.changed(Window(dark=True))
    here.browser.wait(lambda: is_dark(here))
    window.choose("Light")
    here.browser.wait(lambda: not is_dark(here))
    here.browser.wait(lambda: any(message.get("key") == THEME_KEY for message in here.browser.heard))
    window.changed(Window(dark=True))
    assert not window.is_dark


@pytest.mark.process
def test_a_choice_that_a_browser_kept_is_used_again(pages: viser.ViserServer) -> None:
    with opened(pages.get_port(), storage="Dark") as browser:
        made = Opened(pages, browser)
        assert (made.page._window.theme, made.page._window.is_dark) == ("Dark", True)
        made.page.close()
    until(lambda: not pages.get_clients())


class Panel:
    """Keeps where it was put."""

    def __init__(self) -> None:
        self.puts: list[object] = []

    def dock_left(self) -> None:
        self.puts.append("left")

    def set_width(self, width: float) -> None:
        self.puts.append(width)

    def float(self, *, x: float, y: float, width: float, height: float) -> None:
        self.puts.append((x, y + height, width))


def test_panels_are_beside_the_scene_in_a_wide_window_and_below_it_in_a_narrow_one(here: Opened) -> None:
    side = Panel()
    window = here.page._window
    window._side = cast("Any", side)
    for width, height in (
        (1280.0, 800.0),
        (820.0, 1180.0),
        (820.0, 1180.0),
        (390.0, 844.0),
        (1280.0, 800.0),
        (844.0, 390.0),
    ):
        here.page._resized(Window(width=width, height=height))
    # A phone has viser's sheet.
    assert side.puts == [(0, 1180.0 - BAR, 410.0), "left", WIDTH, "left", SLIM]
