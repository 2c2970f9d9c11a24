"""A recording as an MP4 file, for slides: the browser renders its own view, and PyAV encodes it, in simulated time.

The browser sends a picture for each tick that it can follow. A slow browser gives fewer pictures, not a slower run.
"""

from __future__ import annotations

import io
import threading
import traceback
from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

import viser

from intellwheels_schemas.extras import missing_extra

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

LONGEST: Final = 300.0
"""Longest video, in simulated seconds."""
WIDEST: Final = 1280
"""Greatest width of a video in px."""
PATIENCE: Final = 10.0
"""Seconds to wait for a picture; a browser that is hidden sends none."""
_TICKS: Final = 1000
"""Units of a second in the file."""


class VideoRecording:
    """The video of one browser.

    Args:
        client: The browser.
        notify: Shows a notice: its title and its text.
    """

    def __init__(self, client: viser.ClientHandle, notify: Callable[[str, str], None]) -> None:
        self._client, self._notify = client, notify
        self._news = threading.Condition()
        self._newest: Snapshot | None = None
        self._runs = False

    @property
    def runs(self) -> bool:
        """Whether a video has begun and not ended."""
        return self._runs

    def toggle(self) -> None:
        """Begin a video, or end it and let the browser save it."""
        lacking = missing_extra("video")
        if lacking is not None:
            self._notify("No video", f"{lacking}. Record saves a page, which needs no extra.")
            return
        with self._news:
            if self._runs:
                self.close()
                return
            self._runs, self._newest = True, None
        threading.Thread(target=self._work, name="video", daemon=True).start()

    def drawn(self, snapshot: Snapshot) -> None:
        """Take the snapshot that was just drawn."""
        if self._runs:
            with self._news:
                self._newest = snapshot
                self._news.notify()

    def close(self) -> None:
        """End the video."""
        with self._news:
            self._runs = False
            self._news.notify()

    def _work(self) -> None:
        try:
            data, seconds = self._encoded()
        except Exception as error:  # a browser that has left, or one that sends no picture
            if not isinstance(error, TimeoutError):
                traceback.print_exc()
            self._notify("No video", f"The browser sent no picture for {PATIENCE:g} s.")
            return
        finally:
            self.close()
        if not data:
            self._notify("No video", "No run was shown meanwhile.")
            return
        self._client.send_file_download("intellwheels-run.mp4", data, save_immediately=True)
        self._notify("Video saved", f"{seconds:.1f} s of the run, in simulated time.")

    def _encoded(self) -> tuple[bytes, float]:
        """Return the file and its length in simulated seconds."""
        import av  # noqa: PLC0415  # heavy, and in an extra

        file = io.BytesIO()
        run, began, last = "", 0.0, -1
        with av.open(file, "w", format="mp4") as container:
            stream: Any = None
            while (snapshot := self._next()) is not None:
                if stream is not None and snapshot.run != run:
                    break
                at = round((snapshot.time - began) * _TICKS) if stream is not None else 0
                if at <= last:
                    continue
                picture = self._client.get_render(*self._size(), timeout=PATIENCE)
                if stream is None:
                    run, began = snapshot.run, snapshot.time
                    stream = container.add_stream("libx264", rate=20)
                    stream.height, stream.width = picture.shape[:2]
                    stream.pix_fmt = "yuv420p"
                    stream.codec_context.time_base = Fraction(1, _TICKS)
                frame = av.VideoFrame.from_ndarray(picture[..., :3], format="rgb24")
                frame.pts, frame.time_base, last = at, Fraction(1, _TICKS), at
                container.mux(stream.encode(frame))
                if at >= LONGEST * _TICKS:
                    break
            if stream is None:
                return b"", 0.0
            container.mux(stream.encode(None))
        return file.getvalue(), last / _TICKS

    def _next(self) -> Snapshot | None:
        """Wait for a snapshot that was not taken yet; None at the end."""
        with self._news:
            self._news.wait_for(lambda: self._newest is not None or not self._runs)
            newest, self._newest = self._newest, None
            return newest if self._runs else None

    def _size(self) -> tuple[int, int]:
        """Return the height and width of a picture, even numbers, as the encoder wants them."""
        camera = self._client.camera
        share = min(1.0, WIDEST / max(camera.image_width, 1))
        high, wide = (max(2, int(size * share) // 2 * 2) for size in (camera.image_height, camera.image_width))
        return high, wide
