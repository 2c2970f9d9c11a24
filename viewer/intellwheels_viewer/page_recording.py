"""A recording that a user begins and ends in the page: the browser downloads it as a page that plays by itself."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

import viser

if TYPE_CHECKING:
    from intellwheels_viewer.html_recording import HtmlRecording
    from intellwheels_viewer.snapshot import Snapshot


class PageRecording:
    """The recording of one browser.

    Args:
        client: The browser.
        recorder: Begins a recording; gets whether it is dark. None: nothing can be recorded.
        notify: Shows a notice: its title and its text.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        recorder: Callable[[bool], HtmlRecording] | None,
        notify: Callable[[str, str], None],
    ) -> None:
        self._client, self._recorder, self._notify = client, recorder, notify
        self._recording: HtmlRecording | None = None
        self._lock = threading.Lock()

    @property
    def runs(self) -> bool:
        """Whether a recording has begun and not ended."""
        return self._recording is not None

    def toggle(self, *, dark: bool) -> None:
        """Begin a recording, or end it and let the browser save it."""
        with self._lock:
            if self._recording is None and self._recorder is not None:
                self._recording = self._recorder(dark)
                return
        self._end()

    def drawn(self, snapshot: Snapshot) -> None:
        """Record the snapshot that was just drawn; a recording that is complete is saved."""
        recording = self._recording
        if recording is not None and recording.drawn(snapshot):
            self._end()

    def _end(self) -> None:
        with self._lock:
            recording, self._recording = self._recording, None
        if recording is not None:
            # It takes a while, in which the drawing goes on.
            threading.Thread(target=self._save, args=(recording,), name="recording", daemon=True).start()

    def _save(self, recording: HtmlRecording) -> None:
        page = recording.page()
        if not page:
            self._notify("Nothing was recorded", "No run was shown meanwhile.")
            return
        self._client.send_file_download("intellwheels-run.html", page, save_immediately=True)
        self._notify("Recording saved", f"{recording.length:.1f} s of the run, as a page that plays by itself.")
