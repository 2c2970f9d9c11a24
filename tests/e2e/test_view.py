"""`iw-run SCENE --view` says where its page is before anything moves, serves it, and takes it along when it ends."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from tests.e2e.stage import free_port

DEADLINE = 120.0
_SCENE = """<Scene Format="iw.v1" Name="seen" Map="room">
  <Cast Name="chair1" Robot="rear-wheel" Mind="drive" Place="start1"/>
  <End><Timeout Seconds="300.0"/></End>
</Scene>"""


def test_a_scene_with_a_view_says_its_address_serves_it_and_ends_it(tmp_path: Path) -> None:
    scene = tmp_path / "seen.xml"
    scene.write_text(_SCENE)
    process = subprocess.Popen(
        [sys.executable, "-m", "intellwheels_experiments", str(scene), "--view", "--view-port", "0",
         "--logs", str(tmp_path / "logs"), "--listen", f"tcp/127.0.0.1:{free_port()}"],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    watchdog = threading.Timer(DEADLINE, process.kill)
    watchdog.start()
    try:
        assert process.stdout is not None
        told: list[str] = []
        for line in process.stdout:
            told.append(line)
            if line.startswith("started"):
                break
        addresses = [line.partition("view it at ")[2].strip() for line in told if "view it at " in line]
        assert len(addresses) == 1, told
        assert addresses[0].startswith("http://127.0.0.1:")
        with urllib.request.urlopen(addresses[0], timeout=20.0) as page:
            assert page.status == 200
            assert b"<html" in page.read().lower()
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30.0)
        with pytest.raises(urllib.error.URLError):
            urllib.request.urlopen(addresses[0], timeout=5.0)
    finally:
        watchdog.cancel()
        if process.poll() is None:
            process.kill()
        process.communicate()
