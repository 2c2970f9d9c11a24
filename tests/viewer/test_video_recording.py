"""A video of the view of one browser, which here is a function that paints."""

from __future__ import annotations

import io
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from intellwheels_viewer import video_recording
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.video_recording import VideoRecording
from tests.viewer.wire import until


class Client:
    """Renders grey pictures of the size that is wanted."""

    def __init__(self) -> None:
        self.camera = SimpleNamespace(image_width=161, image_height=97)
        self.files: list[tuple[str, bytes]] = []
        self.rendered = 0
        self.fails = False

    def get_render(self, height: int, width: int, *, timeout: float) -> Any:
        if self.fails:
            raise TimeoutError
        assert timeout > 0
        self.rendered += 1
        return np.full((height, width, 3), 20 * self.rendered, np.uint8)

    def send_file_download(self, name: str, data: bytes, *, save_immediately: bool) -> None:
        assert save_immediately
        self.files.append((name, data))


def made() -> tuple[VideoRecording, Client, list[str]]:
    client, said = Client(), []
    return VideoRecording(cast("Any", client), lambda title, _: said.append(title)), client, said


def test_a_video_has_a_picture_of_each_tick_at_its_simulated_time() -> None:
    av = pytest.importorskip("av", reason="the extra `video` is not installed")
    video, client, said = made()
    video.toggle()
    for number, time in enumerate((5.0, 5.05, 5.05, 6.0)):
        before = client.rendered
        video.drawn(replace(Snapshot(), run="a", tick=number, time=time))
        if number != 2:
            until(lambda before=before: client.rendered > before)  # type: ignore[misc]
    video.toggle()
    until(lambda: said == ["Video saved"])
    ((name, data),) = client.files
    assert name.endswith(".mp4")
    with av.open(io.BytesIO(data)) as container:
        times = [float(frame.pts * frame.time_base) for frame in container.decode(video=0)]
        assert (container.streams.video[0].width, container.streams.video[0].height) == (160, 96)
    assert times == pytest.approx([0.0, 0.05, 1.0], abs=0.002)


def test_a_browser_that_sends_no_picture_ends_the_video() -> None:
    pytest.importorskip("av", reason="the extra `video` is not installed")
    video, client, said = made()
    client.fails = True
    video.toggle()
    video.drawn(Snapshot())
    until(lambda: said == ["No video"])
    assert not video.runs
    assert client.files == []


def test_a_page_without_the_extra_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video_recording, "missing_extra", lambda *_: "expected the extra video")
    said: list[str] = []
    video = VideoRecording(cast("Any", Client()), lambda _, text: said.append(text))
    video.toggle()
    assert not video.runs
    assert "expected the extra video" in said[0]
