"""The viewer service: the web server, the link to the simulator, and the drawing loop. A restart loses nothing.

One thread draws the newest snapshot, at most 30 times a second, and skips the ones it missed. Panels are updated less
often. Browsers connect and disconnect on viser's threads.
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
from intellwheels_schemas.output_paths import reserved_output
from intellwheels_viewer.html_recording import HtmlRecording
from intellwheels_viewer.origin_guard import admit, open_server
from intellwheels_viewer.page import Page
from intellwheels_viewer.page_hosts import url_of
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.stage import MANY, Stage, watched
from intellwheels_viewer.viewer_peer import Network
from intellwheels_viewer.visits import Door

FRAME: Final = 1 / 30
"""Seconds of wall time between two drawn ticks."""
PANELS: Final = 0.22
"""Seconds of wall time between two updates of the panels."""
PANELS_OF_MANY: Final = 0.5
"""The same with many bodies, whose table and plan are long."""
PAGE_SECONDS: Final = 300.0
"""Longest recording that a page makes, in simulated seconds."""
SHUTDOWN_LIMIT: Final = 1.0
"""Seconds that all pages together have to release the bodies that they drive."""
FAULTS_SHOWN: Final = 20
"""Different faults that are printed; the rest are dropped."""


@dataclass(frozen=True)
class Options:
    """The options of the command.

    Attributes:
        host, port: Where the page is served; port 0 picks a free one.
        allowed: Further host names that browsers may use, perhaps with a port.
        door: Which browsers may do more than look.
        dark: Whether the page uses the dark theme.
        chosen: Whether the user named the world. If not, the only running world is shown.
        record: The HTML file to record to, after which the viewer exits; None for no recording.
        seconds: Simulated seconds to record.
        overwrite: Whether the recording may replace a file.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    allowed: frozenset[str] = field(default_factory=frozenset)
    door: Door = field(default_factory=Door)
    dark: bool = False
    chosen: bool = False
    record: Path | None = None
    seconds: float = 20.0
    overwrite: bool = False


class Viewer:
    """The pages, the scene and the drawing loop.

    Args:
        options: The options of the command.
        link: The link to the simulator.
        stop: Set when the viewer must end.

    Raises:
        ConnectionError: The port is in use.
    """

    def __init__(self, options: Options, link: Link, stop: threading.Event) -> None:
        self._stop, self._link, self._door, self._dark = stop, link, options.door, options.dark
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
        self.server.on_client_connect(self._connected)
        self.server.on_client_disconnect(self._disconnected)

    @property
    def endpoint(self) -> str:
        """The endpoint at which it looks for worlds."""
        return self._link.where()

    @property
    def failure(self) -> str:
        """Why no link is possible, in words; empty while one is."""
        return self._network.failure

    def run(self) -> None:
        """Draw until `stop` is set."""
        self._network.start()
        drawn: tuple[object, ...] = ()
        filled = 0.0
        try:
            while not self._stop.wait(FRAME):
                snapshot = self._network.update()
                pages = self._open_pages()
                outlooks = tuple((number, page.view_state) for number, page in pages.items())
                state = (snapshot.world, snapshot.run, snapshot.version, snapshot.revision, snapshot.phase, outlooks)
                if state != drawn:
                    drawn = state
                    self._draw(snapshot, pages)
                now = time.monotonic()
                if now - filled >= panel_period(len(snapshot.entities)):
                    filled = now
                    for page in pages.values():
                        self._guarded(page.panels, snapshot)
        finally:
            self._end()

    def _draw(self, snapshot: Snapshot, pages: Mapping[int, Page]) -> None:
        wanted = {page.selected for page in pages.values() if page.selected is not None}
        # Even without a page: one that opens during a pause must show the measures from before it.
        self._network.watch(watched(snapshot, wanted))
        records = self._recording is not None or any(page.records for page in pages.values())
        wedges = records or any(page.shows_all_wedges for page in pages.values())
        self._guarded(lambda: self._stage.show(snapshot, wanted, wedges=wedges, labels=records))
        for page in pages.values():
            self._guarded(page.draw, snapshot)
            self._guarded(page.drawn, snapshot)
        if self._recording is not None and self._recording.drawn(snapshot):
            self._stop.set()

    def save(self, file: io.FileIO) -> int:
        """Write the recording, see `HtmlRecording.save`."""
        return 0 if self._recording is None else self._recording.save(file)

    def _end(self) -> None:
        # Release driven bodies first, while there still is a link.
        pages = self._open_pages().values()
        for page in pages:
            page.close()
        deadline = time.monotonic() + SHUTDOWN_LIMIT
        for page in pages:
            page.join(max(deadline - time.monotonic(), 0.0))
        self._network.close()
        with contextlib.redirect_stdout(io.StringIO()):  # programs read our output, and viser prints a line too
            self.server.stop()

    def _guarded(self, call: Callable[..., None], *arguments: object) -> None:
        """Call, and print the trace of an exception once. A fault in one drawing must not stop the others."""
        try:
            call(*arguments)
        except Exception:
            fault = traceback.format_exc()
            if fault not in self._faults and len(self._faults) < FAULTS_SHOWN:
                self._faults.add(fault)
                sys.stderr.write(fault)

    def _open_pages(self) -> dict[int, Page]:
        with self._lock:
            return dict(self._pages)

    def _connected(self, client: viser.ClientHandle) -> None:
        try:
            rights = self._door.rights(admit(client, self.server))
        except KeyError:
            return  # it has left already
        page = Page(
            client,
            self._network,
            self._stage.colours,
            rights,
            dark=self._dark,
            recorder=lambda dark: HtmlRecording(self.server, PAGE_SECONDS, dark=dark),
        )
        with self._lock:
            self._pages[client.client_id] = page
        if client.client_id not in self.server.get_clients():
            self._disconnected(client)  # it left while its page was made

    def _disconnected(self, client: viser.ClientHandle) -> None:
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


def panel_period(bodies: int) -> float:
    """Return the seconds of wall time between two updates of the panels for a number of bodies."""
    return PANELS if bodies <= MANY else PANELS_OF_MANY


def serve(options: Options, link: Link, stop: threading.Event) -> int:
    """Serve the page until `stop` is set and return the exit code."""
    with contextlib.ExitStack() as stack:
        file = None
        try:
            # From the start: what is recorded must not be lost because another viewer wrote the file meanwhile.
            if options.record is not None:
                file = stack.enter_context(reserved_output(options.record, overwrite=options.overwrite))
        except OSError as error:
            sys.stderr.write(f"iw-viewer: cannot write {options.record}: {error.strerror}\n")
            return 1
        return _serve(options, link, stop, file)


def _serve(options: Options, link: Link, stop: threading.Event, record: io.FileIO | None) -> int:
    try:
        viewer = Viewer(options, link, stop)
    except ConnectionError as error:
        sys.stderr.write(f"iw-viewer: {error}\n")
        return 1
    if options.door.warning:
        sys.stderr.write(f"iw-viewer: {options.door.warning}\n")
    sys.stdout.write(f"ready url={url_of(options.host, viewer.server.get_port())}\n")
    sys.stdout.flush()
    viewer.run()
    if viewer.failure:
        sys.stderr.write(f"iw-viewer: {viewer.failure}\n")
        return 1
    return 0 if record is None else _save(viewer, record, options.record)


def _save(viewer: Viewer, file: io.FileIO, path: Path | None) -> int:
    try:
        size = viewer.save(file)
    except OSError as error:
        sys.stderr.write(f"iw-viewer: cannot write {path}: {error.strerror}\n")
        return 1
    if not size:
        sys.stderr.write(f"iw-viewer: nothing was recorded: no world was found at {viewer.endpoint}\n")
        return 1
    sys.stdout.write(f"recorded file={path} bytes={size}\n")
    sys.stdout.flush()
    return 0
