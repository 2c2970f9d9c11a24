"""All panels in a viser server, as a browser's own, and a headless Chromium that looks at them."""

from __future__ import annotations

import shutil
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import viser
from playwright.sync_api import Page, sync_playwright

from intellwheels_viewer.gallery import FLAGS
from intellwheels_viewer.panels.agents import AgentsPanel
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.clock import ClockPanel
from intellwheels_viewer.panels.connection import ConnectionPanel
from intellwheels_viewer.panels.drive_panel import DrivePanel
from intellwheels_viewer.panels.events import EventsPanel
from intellwheels_viewer.panels.layers_panel import Layers, LayersPanel
from intellwheels_viewer.panels.page_keys import PageKeys
from intellwheels_viewer.panels.page_shell import PageShell
from intellwheels_viewer.panels.place import PlacePanel
from intellwheels_viewer.panels.plan_panel import PlanPanel
from intellwheels_viewer.panels.playback import PlaybackPanel
from intellwheels_viewer.panels.scan_panel import ScanPanel
from intellwheels_viewer.panels.selected import SelectedPanel
from intellwheels_viewer.panels.stick_input import StickInput
from intellwheels_viewer.snapshot import Snapshot

CHROMIUM = shutil.which("chromium")


class SteadyClock:
    """A monotonic clock in seconds, on which no more than 0.2 s pass from one call to the next.

    A busy machine may stand still between two messages of a page for longer than the silence that ends a scan.
    """

    def __init__(self) -> None:
        self._read = time.monotonic()
        self._now = 0.0

    def __call__(self) -> float:
        before, self._read = self._read, time.monotonic()
        self._now += min(self._read - before, 0.2)
        return self._now


class Board:
    """One browser's panels; what they call is kept in `calls`, a name and its arguments each."""

    def __init__(self, client: viser.ClientHandle, snapshot: Snapshot, choices: Choices) -> None:
        self.gui = gui = client.gui
        self.calls: list[tuple[Any, ...]] = []
        self.news = threading.Condition()
        side = gui.add_panel()
        with side.add_tab("Selected"):
            self.plan = PlanPanel(gui, self.note("select"))
            self.selected = SelectedPanel(gui)
        with side.add_tab("Events"):
            self.events = EventsPanel(gui)
        side.dock_left()
        side.set_width(280)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(280)
        self.connection = ConnectionPanel(gui, self.note("world"))
        self.clock = ClockPanel(
            gui, on_pause=self.note("pause"), on_resume=self.note("resume"), on_step=self.note("step"),
            on_reset=self.note("reset"), on_speed=self.note("speed"),
        )  # fmt: skip
        self.playback = PlaybackPanel(
            gui, on_seek=self.note("seek"), on_pause=self.note("pause"), on_resume=self.note("resume"),
            on_speed=self.note("speed"),
        )  # fmt: skip
        self.keys = PageKeys(gui)
        self.shell = PageShell(gui, self.note("act"), self.note("window"))
        stick = StickInput(gui)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Agents"):
            self.agents = AgentsPanel(gui, self.note("select"))
        with tabs.add_tab("Drive"):
            self.drive = DrivePanel(gui, stick, on_stick=self.note("stick"), on_say=self.note("say"))
            self.scan = ScanPanel(gui, on_stick=self.note("stick"), now=SteadyClock())
        with tabs.add_tab("Place"):
            self.place = PlacePanel(
                gui, on_choose=self.note("choose"), on_turn=self.note("turn"), on_turn_selected=self.note("turn by"),
                on_remove=self.note("remove"), on_undo=self.note("undo"),
            )  # fmt: skip
        with tabs.add_tab("Layers"):
            self.layers = LayersPanel(gui, Layers(), self.note("layers"))
        self.show(snapshot, choices)

    def note(self, name: str) -> Any:
        def call(*arguments: object) -> None:
            with self.news:
                self.calls.append((name, *arguments))
                self.news.notify_all()

        return call

    def wait(self, there: Callable[[list[tuple[Any, ...]]], object], seconds: float = 10.0) -> None:
        """Wait until the calls are as they should be."""
        with self.news:
            assert self.news.wait_for(lambda: there(self.calls), seconds), self.calls[-20:]

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        self.connection.show(snapshot, choices)
        self.clock.show(snapshot, choices)
        self.playback.show(snapshot, choices)
        self.agents.show(snapshot, choices)
        self.selected.show(snapshot, choices)
        self.events.show(snapshot)
        self.shell.show(snapshot, choices)
        self.plan.show(snapshot, choices)
        self.drive.show(snapshot, choices)
        self.scan.show(snapshot, choices)
        self.place.show(snapshot, choices)


# Text below 11 px, and text wider than the place it has, unless it says so by an ellipsis.
FAULTS = """() => {
  const found = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const text = walk.currentNode.textContent.trim(), at = walk.currentNode.parentElement;
    if (!text || !at.checkVisibility() || at.closest('style,script,title')) continue;
    const style = getComputedStyle(at), box = at.getBoundingClientRect();
    if (!box.width) continue;
    if (parseFloat(style.fontSize) < 11) found.push(`${style.fontSize}: ${text}`);
    if (at.scrollWidth > at.clientWidth + 1 && style.display !== 'inline' && style.textOverflow !== 'ellipsis')
      found.push(`cut ${at.scrollWidth} > ${at.clientWidth}: ${text}`);
  }
  return found;
}"""


@contextmanager
def served(
    snapshot: Snapshot, choices: Choices, *, dark: bool = False
) -> Iterator[tuple[viser.ViserServer, list[Board]]]:
    """A server on a free loopback port; each browser that comes gets a board, in the order they come."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # viser's own use of websockets
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    boards: list[Board] = []
    server.gui.configure_theme(show_logo=False, show_share_button=False, dark_mode=dark)
    server.scene.configure_environment_map(None)
    server.on_client_connect(lambda client: boards.append(Board(client, snapshot, choices)))
    try:
        yield server, boards
    finally:
        server.stop()


@contextmanager
def browser() -> Iterator[Any]:
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield chromium
        finally:
            chromium.close()


def opened(chromium: Any, server: viser.ViserServer, *, width: int = 1280, height: int = 800) -> Page:
    page: Page = chromium.new_page(viewport={"width": width, "height": height}, device_scale_factor=1)
    page.goto(f"http://127.0.0.1:{server.get_port()}/?fixedDpr=1")
    page.wait_for_selector("[data-testid=connection]", timeout=60_000)
    for close in page.query_selector_all(".mantine-Notification-closeButton"):
        close.click()
    return page
