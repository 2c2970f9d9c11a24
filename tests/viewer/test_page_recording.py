"""A recording that begins and ends in the page."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

from intellwheels_viewer.page_recording import PageRecording
from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.wire import until


class Recording:
    """Complete after two pictures."""

    length = 1.5

    def __init__(self, page: bytes = b"<html>") -> None:
        self.count, self._page = 0, page

    def drawn(self, _: Snapshot) -> bool:
        self.count += 1
        return self.count >= 2

    def page(self) -> bytes:
        return self._page


class Client:
    def __init__(self) -> None:
        self.files: list[tuple[str, bytes]] = []

    def send_file_download(self, name: str, data: bytes, *, save_immediately: bool) -> None:
        assert save_immediately
        self.files.append((name, data))


def made(recording: Recording) -> tuple[PageRecording, Client, list[str]]:
    client, said = Client(), []
    recorder = cast("Any", lambda dark: recording)
    return PageRecording(cast("Any", client), recorder, lambda title, _: said.append(title)), client, said


def test_a_second_press_saves_the_recording() -> None:
    page, client, said = made(Recording())
    page.drawn(Snapshot())
    page.toggle(dark=False)
    assert page.runs
    page.toggle(dark=False)
    assert not page.runs
    until(lambda: said == ["Recording saved"])
    assert client.files == [("intellwheels-run.html", b"<html>")]


def test_a_recording_that_is_complete_is_saved_by_itself() -> None:
    page, client, said = made(Recording())
    page.toggle(dark=True)
    for tick in (1, 2, 3):
        page.drawn(replace(Snapshot(), tick=tick))
    until(lambda: said)
    assert len(client.files) == 1


def test_nothing_recorded_is_said() -> None:
    page, client, said = made(Recording(b""))
    page.toggle(dark=False)
    page.toggle(dark=False)
    until(lambda: said == ["Nothing was recorded"])
    assert client.files == []


def test_a_page_without_a_recorder_records_nothing() -> None:
    page = PageRecording(cast("Any", Client()), None, lambda *_: None)
    page.toggle(dark=False)
    assert not page.runs
