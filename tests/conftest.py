"""What holds for every test: the kernels are compiled, and only a test marked `process` leaves its own process."""

from __future__ import annotations

import functools
import gc
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import zenoh

COMPILED = 600.0
"""Seconds for the kernels to be compiled: about 45 of CPU, once for a checkout, on machines that may be busy."""

FOLDERS = (Path(__file__).parent / "e2e",)
"""Every test in these is marked `process`."""

LONG = Path(__file__).parent / "agents" / "minds"
"""The pure tests that take longest: chairs and people drive for minutes of simulated time."""

FIXTURES = {"intellwheels", "here", "chromium"}
"""A test that uses one of these is marked `process`."""

MARKS = ("browser", "docker", "languages")
"""A test with one of these is marked `process` too."""

_FORBIDDEN = {"subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.system", "socket.connect",
              "zenoh.open"}  # fmt: skip
"""Audit events of a child process that is started, or of a connection that is opened."""


class _Guard:
    """Refuses child processes and connections while a test runs that is not marked `process`."""

    test = ""
    """The test that runs, when it is a pure one."""

    def audit(self, event: str, arguments: tuple[Any, ...]) -> None:
        if self.test and event in _FORBIDDEN:
            raise RuntimeError(f"{self.test}: {event} {arguments[:1]}: expected the mark 'process' on such a test")


_guard = _Guard()
sys.addaudithook(_guard.audit)

# Images often set it. Then each of some hundred processes would compile all of our sources again.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


# Nothing of what is collected is garbage, so no search for garbage finds any until all is there.
gc.disable()


def _audited(open_session: Callable[..., zenoh.Session]) -> Callable[..., zenoh.Session]:
    """Return Zenoh's `open` with an audit event; Zenoh itself is not Python, and has none."""

    @functools.wraps(open_session)
    def opened(*arguments: Any, **named: Any) -> zenoh.Session:
        sys.audit("zenoh.open")
        return open_session(*arguments, **named)

    return opened


zenoh.open = _audited(zenoh.open)


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return a process for each core, and one more unless all tests are pure: tests of processes often wait."""
    return len(os.sched_getaffinity(0)) + ("not process" not in config.option.markexpr)


_WARMING = pytest.StashKey[subprocess.Popen[str]]()


def pytest_sessionstart(session: pytest.Session) -> None:
    """Begin to compile the kernels once, while the tests are collected: no test waits for a process that does it."""
    if hasattr(session.config, "workerinput") or session.config.option.collectonly:
        return
    words = [sys.executable, "-c", "from intellwheels_server.world.warmup import warm; warm()"]
    session.config.stash[_WARMING] = subprocess.Popen(
        words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> None:
    """Wait until the kernels are compiled: no test starts before, in this process or in a worker."""
    warming = session.config.stash.get(_WARMING, None)
    if warming is None:
        return
    try:
        _, said = warming.communicate(timeout=COMPILED)
    except subprocess.TimeoutExpired:
        raise pytest.UsageError(f"the kernels are not compiled after {COMPILED:g} s") from None
    if warming.returncode != 0:
        raise pytest.UsageError(f"the kernels cannot be compiled:\n{said}")


def pytest_unconfigure(config: pytest.Config) -> None:
    """End the compiling of a session that ends before its tests."""
    warming = config.stash.get(_WARMING, None)
    if warming is not None and warming.poll() is None:
        os.killpg(warming.pid, signal.SIGKILL)
        warming.communicate()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> Iterator[None]:
    """Mark the tests that start processes, and keep tests that share a module's fixture in one worker."""
    for item in items:
        fixtures = set(getattr(item, "fixturenames", ()))
        in_folder = any(_is_in(item.path, folder) for folder in FOLDERS)
        if in_folder or fixtures & FIXTURES or any(item.get_closest_marker(mark) for mark in MARKS):
            item.add_marker("process")
        if any(definition.scope == "module" for definition in _definitions(item)):
            item.add_marker(pytest.mark.xdist_group(item.nodeid.partition("::")[0]))
    result = yield
    if hasattr(config, "workerinput"):
        # Long tests first: the short ones fill what is left of the last minute. `sort` keeps the order otherwise.
        items.sort(key=lambda item: (item.get_closest_marker("process") is None, not _is_in(item.path, LONG)))
    return result


def pytest_collection_finish() -> None:
    """Leave what was collected, which stays to the end, out of every later search for garbage."""
    gc.enable()
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Hold a test without the mark `process`, and the fixtures that it sets up, to what the mark means."""
    _guard.test = "" if item.get_closest_marker("process") else item.nodeid
    try:
        return (yield)
    finally:
        _guard.test = ""


@functools.cache
def _is_in(path: Path, folder: Path) -> bool:
    """Return whether a test file is in a folder; thousands of tests are in the same files."""
    return folder in path.parents


def _definitions(item: pytest.Item) -> Iterator[Any]:
    info = getattr(item, "_fixtureinfo", None)
    for definitions in info.name2fixturedefs.values() if info else ():
        yield definitions[-1]
