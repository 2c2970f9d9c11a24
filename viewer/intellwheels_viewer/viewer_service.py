"""The viewer's life: the page's server, the link, and the loop that draws. It holds nothing that a restart could lose.

One thread draws the newest of what is seen, at most 30 times a second, skipping what it missed; panels go slower. Pages
come and go on viser's threads.
"""

from __future__ import annotations

import contextlib
import io
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import viser

from intellwheels_schemas.link import Link
from intellwheels_viewer.html_recording import HtmlRecording
from intellwheels_viewer.origin_guard import open_server
from intellwheels_viewer.page import Page
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.stage import MANY, Stage, watched
from intellwheels_viewer.viewer_peer import Network

FRAME: Final = 1 / 30
"""Seconds of wall time between two drawn ticks."""
PANELS: Final = 0.22
"""Seconds of wall time between two fillings of the panels."""
PANELS_OF_MANY: Final = 0.5
"""The same of many bodies, whose table and plan are long."""
FAREWELL: Final = 1.0
"""Seconds that pages have, in all, to give back what they drive."""
FAULTS_TOLD: Final = 20


@dataclass(frozen=True)
class Options:
    """What the command was told.

    Attributes:
        host, port: Where the page is served; port 0 is any free one.
        allowed: Further names by which browsers may reach us.
        dark: Whether the page is dark.
        chosen: Whether the world was named; else the only one there is is taken.
        record: Where the run is kept as an HTML file, which ends the viewer; None: it is not.
        seconds: How much of it, in simulated seconds.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    allowed: frozenset[str] = field(default_factory=frozenset)
    dark: bool = False
    chosen: bool = False
    record: Path | None = None
    seconds: float = 20.0


class Viewer:
    """Pages, stage and loop.

    Args:
        options: Of the page.
        link: Of the simulator.
        stop: Set when it must end.

    Raises:
        ConnectionError: The port is taken.
    """

    def __init__(self, options: Options, link: Link, stop: threading.Event) -> None:
        self._stop, self._link = stop, link
        self.server = open_server(options.host, options.port, options.allowed)
        self.server.gui.configure_theme(
            show_logo=False,
            show_share_button=False,
            dark_mode=options.dark,
            brand_color=(45, 135, 210) if options.dark else (0, 90, 158),
        )
        self.server.gui.set_panel_label("IntellWheels")
        self._stage = Stage(self.server, dark=options.dark)
        self._network = Network(link, stop, chosen=options.chosen)
        self._faults: set[str] = set()
        self._recording = HtmlRecording(self.server, options.seconds, dark=options.dark) if options.record else None
        self._pages: dict[int, Page] = {}
        self._lock = threading.Lock()
        self._stage.on_pick(self._picked)
        self._stage.bodies.on_drag(self._dragged)
        self.server.on_client_connect(self._came)
        self.server.on_client_disconnect(self._went)

    @property
    def endpoint(self) -> str:
        """Where it looks for worlds."""
        return self._link.where()

    @property
    def failure(self) -> str:
        """Why there can be no link, in words; empty while there can."""
        return self._network.failure

    def run(self) -> None:
        """Draw until told to stop."""
        self._network.start()
        drawn: tuple[object, ...] = ()
        filled = 0.0
        try:
            while not self._stop.wait(FRAME):
                seen = self._network.pour()
                pages = self._present()
                outlooks = tuple((number, page.outlook) for number, page in pages.items())
                state = (seen.world, seen.run, seen.version, seen.revision, seen.phase, outlooks)
                if state != drawn:
                    drawn = state
                    self._draw(seen, pages)
                now = time.monotonic()
                if now - filled >= filling(len(seen.entities)):
                    filled = now
                    for page in pages.values():
                        self._shield(page.panels, seen)
        finally:
            self._end()

    def _draw(self, seen: Snapshot, pages: Mapping[int, Page]) -> None:
        wanted = {page.selected for page in pages.values() if page.selected is not None}
        # Also while nobody looks: a page that comes to a paused run must show what was measured before.
        self._network.watch(watched(seen, wanted))
        self._shield(self._stage.show, seen, wanted)
        for page in pages.values():
            self._shield(page.draw, seen)
        if self._recording is not None and self._recording.drawn(seen):
            self._stop.set()

    def save(self, path: Path) -> int:
        """Write what was recorded, see `HtmlRecording.save`."""
        return 0 if self._recording is None else self._recording.save(path)

    def _end(self) -> None:
        # First what is driven is given back, while there is a link.
        pages = self._present().values()
        for page in pages:
            page.close()
        deadline = time.monotonic() + FAREWELL
        for page in pages:
            page.join(max(deadline - time.monotonic(), 0.0))
        self._network.close()
        with contextlib.redirect_stdout(io.StringIO()):  # our lines are read by programs; viser says a word of its own
            self.server.stop()

    def _shield(self, call: Callable[..., None], *arguments: object) -> None:
        """Draw; a fault of ours is told with its trace, once, and ends neither other drawings nor the pages."""
        try:
            call(*arguments)
        except Exception:
            fault = traceback.format_exc()
            if fault not in self._faults and len(self._faults) < FAULTS_TOLD:
                self._faults.add(fault)
                sys.stderr.write(fault)

    def _present(self) -> dict[int, Page]:
        with self._lock:
            return dict(self._pages)

    def _came(self, client: viser.ClientHandle) -> None:
        page = Page(client, self._network, self._stage.colours)
        with self._lock:
            self._pages[client.client_id] = page
        if client.client_id not in self.server.get_clients():
            self._went(client)  # while its page was made

    def _went(self, client: viser.ClientHandle) -> None:
        with self._lock:
            page = self._pages.pop(client.client_id, None)
        if page is not None:
            page.close()

    def _page(self, number: int) -> Page | None:
        with self._lock:
            return self._pages.get(number)

    def _picked(self, number: int, name: str) -> None:
        page = self._page(number)
        if page is not None:
            page.select(name)

    def _dragged(self, name: str, event: viser.SceneNodeDragEvent[viser.SceneNodeHandle]) -> None:
        page = self._page(event.client_id)
        if page is not None:
            page.drag(name, event)


def filling(bodies: int) -> float:
    """Return the seconds of wall time between two fillings of the panels with so many bodies."""
    return PANELS if bodies <= MANY else PANELS_OF_MANY


def serve(options: Options, link: Link, stop: threading.Event) -> int:
    """Serve the page until told to stop and return the exit code."""
    try:
        viewer = Viewer(options, link, stop)
    except ConnectionError as error:
        sys.stderr.write(f"iw-viewer: {error}\n")
        return 1
    host = "localhost" if options.host in ("0.0.0.0", "::") else options.host  # noqa: S104
    sys.stdout.write(f"ready url=http://{host}:{viewer.server.get_port()}\n")
    sys.stdout.flush()
    viewer.run()
    if viewer.failure:
        sys.stderr.write(f"iw-viewer: {viewer.failure}\n")
        return 1
    return 0 if options.record is None else _save(viewer, options.record)


def _save(viewer: Viewer, path: Path) -> int:
    try:
        size = viewer.save(path)
    except OSError as error:
        sys.stderr.write(f"iw-viewer: cannot write {path}: {error.strerror}\n")
        return 1
    if not size:
        sys.stderr.write(f"iw-viewer: nothing to record: no world was seen at {viewer.endpoint}\n")
        return 1
    sys.stdout.write(f"recorded file={path} bytes={size}\n")
    sys.stdout.flush()
    return 0
