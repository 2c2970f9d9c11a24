"""A run as one HTML file that plays by itself: what all browsers see, without panels, in the run's own time.

Viser keeps what is sent to every browser; between two drawn ticks we say how long they are apart. It is recorded from
the first picture of a run on, and a run that begins anew ends it: its file shows one run.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import viser
from viser.infra import StateSerializer

from intellwheels_viewer.cameras import FOV, STEEP, corners_of, fit

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

ASPECT: Final = 1.6
"""Width over height of the picture that the first view is made for."""


class HtmlRecording:
    """What is drawn, kept.

    Args:
        server: Whose scene.
        seconds: How much of the run, in simulated seconds.
        dark: Whether the page of the file is dark.
    """

    def __init__(self, server: viser.ViserServer, seconds: float, *, dark: bool = False) -> None:
        self._server, self._seconds, self._dark = server, seconds, dark
        self._kept: StateSerializer | None = None
        self._run = ""
        self._began = self._at = 0.0

    @property
    def length(self) -> float:
        """How much of the run is kept, in simulated seconds."""
        return self._at - self._began

    def drawn(self, seen: Snapshot) -> bool:
        """Note that this was drawn, and return whether enough is kept. On the thread that draws."""
        if seen.phase != "live" or seen.floor is None or not seen.entities:
            return False
        if self._kept is None:
            self._run, self._began, self._at = seen.run, seen.time, seen.time
            self._frame(seen)
            self._kept = self._server.get_scene_serializer()
        elif seen.run != self._run or seen.time < self._at:
            return True
        else:
            # What was just drawn is in already: viser plays it at the time before.
            self._kept.insert_sleep(seen.time - self._at)
            self._at = seen.time
        ended = seen.clock is not None and seen.clock.state == "ended"
        return ended or self.length >= self._seconds

    def save(self, path: Path) -> int:
        """Write the file and return its bytes; 0 and no file when there was nothing to see.

        Raises:
            OSError: It cannot be written.
        """
        if self._kept is None:
            return 0
        kept, self._kept = self._kept, None
        page = kept.as_html(dark_mode=self._dark).encode()
        path.write_bytes(page)
        return len(page)

    def _frame(self, seen: Snapshot) -> None:
        """Show the floor whole to who opens the file."""
        if seen.floor is not None:
            view = fit(corners_of(seen.floor), STEEP, FOV, ASPECT)
            first = self._server.initial_camera
            first.position, first.look_at, first.fov = tuple(view.position), tuple(view.look_at), view.fov
