"""`iw-run SCENE --view`: it prints the address, waits for the page, runs again from the page, and ends with Ctrl-C."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Link, open_session, query
from tests.e2e.stage import free_port
from tests.viewer.browser import opened

DEADLINE = 240.0
_SCENE = """<Scene Format="iw.v1" Name="seen" Map="room">
  <Cast Name="chair1" Robot="rear-wheel" Mind="drive" Place="start1"/>
  <End><Timeout Seconds="{seconds}"/></End>
</Scene>"""

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


class Command:
    """A running `iw-run`."""

    def __init__(self, process: subprocess.Popen[str], endpoint: str) -> None:
        self.process, self.endpoint = process, endpoint

    def line(self, words: str) -> str:
        """Wait for a line with these words and return it."""
        assert self.process.stdout is not None
        found = []
        for line in self.process.stdout:
            found.append(line)
            if words in line:
                return line
        raise AssertionError(f"no line with {words!r} in {found}")

    def address(self) -> str:
        """Wait for the address of the page."""
        match = re.search(r"view it at (http://[\d.]+:\d+)", self.line("view it at"))
        assert match is not None
        return match[1]

    def interrupt(self) -> str:
        """End the command as Ctrl-C does; return what it prints until it has ended."""
        self.process.send_signal(signal.SIGINT)
        return str(self.process.communicate(timeout=60.0)[0])


@contextmanager
def viewed(folder: Path, seconds: float) -> Iterator[Command]:
    """Run a scene that ends after so many simulated seconds."""
    scene, endpoint = folder / "seen.xml", f"tcp/127.0.0.1:{free_port()}"
    scene.write_text(_SCENE.format(seconds=seconds))
    process = subprocess.Popen(
        [sys.executable, "-m", "intellwheels_experiments", str(scene), "--view", "--view-port", "0",
         "--logs", str(folder / "logs"), "--listen", endpoint],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    watchdog = threading.Timer(DEADLINE, process.kill)
    watchdog.start()
    try:
        yield Command(process, endpoint)
    finally:
        watchdog.cancel()
        if process.poll() is None:
            process.kill()
        process.communicate()


def test_a_scene_with_a_view_prints_its_address_serves_the_page_and_ends_it(tmp_path: Path) -> None:
    with viewed(tmp_path, 300.0) as command:
        address = command.address()
        command.line("started")
        with urllib.request.urlopen(address, timeout=20.0) as page:
            assert page.status == 200
            assert b"<html" in page.read().lower()
        command.interrupt()
        with pytest.raises(urllib.error.URLError):
            urllib.request.urlopen(address, timeout=5.0)


def test_a_scene_waits_for_its_page_and_runs_again_after_its_end(tmp_path: Path) -> None:
    with viewed(tmp_path, 1.0) as command:
        port = int(command.address().rpartition(":")[2])
        command.line("started")
        session = open_session(Link(connect=(command.endpoint,)), threading.Event(), timeout=30.0)
        assert session is not None
        with session:

            def clock() -> Any:
                return json.loads(query(session, Keys("main").clock, timeout=20.0)[0].data)

            waiting = clock()
            while waiting["State"] == "waiting":  # for chair1; the watchdog is the deadline
                waiting = clock()
            assert (waiting["State"], waiting["Tick"]) == ("paused", 0)
            with opened(port) as browser:
                command.line("the run has ended")
                assert clock()["Run"] == waiting["Run"]
                browser.wait(lambda: "The run is over" in browser.text(), 60.0)
                browser.enter("Run again", True)
                assert "all conditions hold" in command.line("run 2:")
                assert clock()["Run"] != waiting["Run"]
                assert command.process.poll() is None
        assert "note this is the result of run 1; 1 further run was started from the page" in command.interrupt()
        assert command.process.returncode == 0
