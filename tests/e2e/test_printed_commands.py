"""Every command that the page prints, run as it stands: afterwards the page shows what it promised."""

from __future__ import annotations

import html
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.e2e.screen import Theatre
from tests.e2e.stage import free_port
from tests.viewer.browser import Browser, opened

SHOWN = 120.0
"""Seconds until the page shows what a command started, on a busy machine."""

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


@pytest.fixture
def theatre(tmp_path: Path) -> Iterator[Theatre]:
    with Theatre(tmp_path, "main") as theatre:
        yield theatre


def commands(browser: Browser, phase: str) -> list[str]:
    """Wait until the page is in a phase and return the commands that it prints."""
    browser.wait(lambda: f'data-phase="{phase}"' in browser.text(), SHOWN)
    found = browser.wait(lambda: re.findall(r"<code>(iw-[^<]*)</code>", browser.text()), SHOWN)
    return [html.unescape(command) for command in dict.fromkeys(found)]


@contextmanager
def running(command: str, folder: Path) -> Iterator[None]:
    """Run a command as a user does who copies it to a terminal."""
    program, *words = shlex.split(command)
    path = shutil.which(program, path=str(Path(sys.executable).parent))
    assert path is not None, f"{program} is not installed"
    with (folder / "command.log").open("wb") as log:
        process = subprocess.Popen([path, *words], stdout=log, stderr=log, cwd=folder)
    try:
        yield
        assert process.poll() is None or process.returncode == 0, (folder / "command.log").read_text()
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(30.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def shows(browser: Browser, agent: str) -> None:
    browser.wait(lambda: f'data-testid="agent-{agent}"' in browser.text(), SHOWN)


def page_of(theatre: Theatre) -> int:
    return int(theatre.viewer().rpartition(":")[2])


def test_without_a_router_the_printed_command_starts_a_run_that_the_page_shows(theatre: Theatre) -> None:
    with opened(page_of(theatre)) as browser:
        (command,) = commands(browser, "no-router")
        with running(command, theatre.folder):
            shows(browser, "chair1")


def test_at_a_router_the_printed_command_starts_a_run_that_the_page_shows(theatre: Theatre) -> None:
    router = theatre.start("router", "intellwheels_server.service.router", "--listen", theatre.endpoint)
    theatre.line(router, "ready")
    with opened(page_of(theatre)) as browser:
        (command,) = commands(browser, "no-world")
        with running(command, theatre.folder):
            shows(browser, "chair1")


def test_in_an_empty_world_the_printed_command_adds_an_agent_that_drives(theatre: Theatre) -> None:
    theatre.server("--map", "room", "--pace", "realtime")
    with opened(page_of(theatre)) as browser:
        (command,) = commands(browser, "live")
        with running(command, theatre.folder), theatre.peer() as peer:
            shows(browser, "chair1")
            peer.entity("chair1", lambda body: abs(body.get("Speed", 0.0)) > 0.02)


def test_at_another_port_and_in_another_world_it_works_too(tmp_path: Path) -> None:
    with Theatre(tmp_path, "ward-7") as theatre:
        theatre.endpoint = f"tcp/localhost:{free_port()}"
        with opened(page_of(theatre)) as browser:
            (command,) = commands(browser, "no-router")
            assert "--world ward-7" in command
            with running(command, theatre.folder):
                shows(browser, "chair1")
