"""Records a run as one HTML file that plays without a server: the shared scene without panels, in simulated time.

Viser records what is sent to every browser; we insert the time between two drawn ticks. A file has one run: recording
begins with the first picture and ends when a new run starts.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Final

import viser
from viser.infra import StateSerializer

from intellwheels_schemas.output_paths import write_reserved
from intellwheels_viewer.cameras import FOV, STEEP, corners_of, fit

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

ASPECT: Final = 1.6
"""Width over height of the picture that the first view fits."""


class HtmlRecording:
    """A recording of the shared scene.

    Args:
        server: The web server with the scene.
        seconds: Simulated seconds to record.
        dark: Whether the recorded page uses the dark theme.
    """

    def __init__(self, server: viser.ViserServer, seconds: float, *, dark: bool = False) -> None:
        self._server, self._seconds, self._dark = server, seconds, dark
        self._kept: StateSerializer | None = None
        self._run = ""
        self._began = self._at = 0.0

    @property
    def length(self) -> float:
        """Simulated seconds recorded so far."""
        return self._at - self._began

    def drawn(self, snapshot: Snapshot) -> bool:
        """Record the snapshot that was just drawn, and return whether the recording is complete."""
        if snapshot.phase != "live" or snapshot.floor is None or not snapshot.entities:
            return False
        if self._kept is None:
            self._run, self._began, self._at = snapshot.run, snapshot.time, snapshot.time
            self._frame(snapshot)
            self._kept = self._server.get_scene_serializer()
        elif snapshot.run != self._run or snapshot.time < self._at:
            return True
        else:
            # The new picture is already recorded; viser plays it at the previous time.
            self._kept.insert_sleep(snapshot.time - self._at)
            self._at = snapshot.time
        ended = snapshot.clock is not None and snapshot.clock.state == "ended"
        return ended or self.length >= self._seconds

    def save(self, file: io.FileIO) -> int:
        """Write a reserved file and return its size in bytes; 0, and an empty file, if nothing was recorded.

        Raises:
            OSError: The file cannot be written.
        """
        page = self.page()
        if page:
            write_reserved(file, page)
        return len(page)

    def page(self) -> bytes:
        """Return the recording as a page and end it; nothing if nothing was recorded."""
        if self._kept is None:
            return b""
        kept, self._kept = self._kept, None
        return kept.as_html(dark_mode=self._dark).encode()

    def _frame(self, snapshot: Snapshot) -> None:
        """Set the first view so that it shows the whole map."""
        if snapshot.floor is not None:
            view = fit(corners_of(snapshot.floor), STEEP, FOV, ASPECT)
            first = self._server.initial_camera
            first.position, first.look_at, first.fov = tuple(view.position), tuple(view.look_at), view.fov
