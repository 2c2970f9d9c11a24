"""What the viewer costs: the whole process fed at 20 Hz, and drawing alone; one raw page reads.

`python -m tests.bench.viewer CHAIRS SECONDS` draws alone and prints the share of a core.
"""

from __future__ import annotations

import os
import shutil
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from tests.bench.frames import AGENTS, SIZE
from tests.bench.network import cpu_of, process
from tests.bench.rows import Row
from tests.bench.sink import endpoint
from tests.viewer.browser import Browser, opened

WORLD = "bench"
RATE = 20.0
SETTLE = 4.0
"""Seconds until the page is made and everything was fetched."""


def said(child: object, word: str) -> str:
    """Return the rest of a child's first line that begins with the word."""
    for line in child.stdout:  # type: ignore[attr-defined]
        if line.startswith(word):
            return str(line[len(word) :]).strip()
    raise RuntimeError(f"expected a line '{word}', got the end")


@contextmanager
def reader(port: int) -> Iterator[Browser]:
    """A page that reads all and decodes it."""
    with opened(port) as browser:
        yield browser


def measure(pid: int, browser: Browser, seconds: float) -> tuple[float, float]:
    """Return a process's share of a core and the bytes a second that the page got.

    A short measurement on a busy machine goes on until the page gets something.
    """
    begun, cpu, received = time.monotonic(), cpu_of(pid), browser.received
    threading.Event().wait(seconds)
    browser.wait(lambda: browser.received > received)
    span = time.monotonic() - begun
    return (cpu_of(pid) - cpu) / span, (browser.received - received) / span


def whole(chairs: int, seconds: float, settle: float) -> tuple[float, float]:
    """Measure the viewer as a process of its own."""
    address = endpoint()
    with process("tests.bench.feed", address, WORLD, str(chairs)) as feed:
        said(feed, "ready")
        with process("intellwheels_viewer", "--connect", address, "--port", "0") as viewer:
            port = int(said(viewer, "ready url=").rpartition(":")[2])
            with reader(port) as browser:
                browser.element("Camera")
                threading.Event().wait(settle)
                return measure(viewer.pid, browser, seconds)


def drawing(chairs: int, seconds: float, settle: float) -> tuple[float, float]:
    """Measure drawing and sending alone."""
    with process("tests.bench.viewer", str(chairs), str(seconds + 2 * settle)) as child:
        port = int(said(child, "ready"))
        with reader(port) as browser:
            threading.Event().wait(settle / 2)
            _, sent = measure(child.pid, browser, seconds)
            # A busy machine draws less often: what a tick costs says what 20 a second would.
            return float(said(child, "milliseconds a tick:")) / 1000 * RATE, sent


def draw(chairs: int, seconds: float) -> None:
    """Draw as many chairs at 20 Hz; all is reckoned before."""
    from intellwheels_viewer.origin_guard import open_server
    from intellwheels_viewer.snapshot import Snapshot
    from intellwheels_viewer.stage import Stage
    from tests.bench.feed import body, entities, measures

    server = open_server("127.0.0.1", 0)
    stage = Stage(server)
    names = [f"a{number:04d}" for number in range(chairs)]
    bodies = {name: body(name) for name in names}
    made = [
        Snapshot(
            phase="live", run="0" * 16, tick=tick, time=tick / RATE, bodies=bodies,
            entities=tuple(entities(names, tick)), version=tick,
            measures={name: measures(tick, number) for number, name in enumerate(names)},
        )
        for tick in range(1, 41)
    ]  # fmt: skip
    stage.show(made[0], ())
    print(f"ready {server.get_port()}", flush=True)
    begun, tick, cpu = time.monotonic(), 0, time.process_time()
    while time.monotonic() - begun < seconds:
        tick += 1
        seen = made[tick % len(made)]
        stage.show(seen, ())  # nobody is selected, as when a page has just been opened
        threading.Event().wait(max(begun + tick / RATE - time.monotonic(), 0.0))
    print(f"milliseconds a tick: {1000 * (time.process_time() - cpu) / tick:.3f}", flush=True)
    os._exit(0)


def drawn(count: int) -> list[Row]:
    """Return how fast a browser draws; no rows without Chromium."""
    if shutil.which("chromium") is None:
        return []
    with process("tests.bench.frames", str(count)) as child:
        shown, of_cpu = said(child, "frames a second:").split(", of CPU time: ")
    case = f"ward, {AGENTS} agents that move, {SIZE[0]} x {SIZE[1]}, in software"
    return [
        Row("viewer", case, "frames of the browser", float(shown), "1/s"),
        Row("viewer", case, "frames a second of its CPU time", float(of_cpu), "1/s"),
    ]


def bench(
    chairs: tuple[int, ...] = (10, 100, 1000), *, seconds: float = 10.0, settle: float = SETTLE, frames: int = 10
) -> list[Row]:
    """Return the rows."""
    rows = drawn(frames)
    for count in chairs:
        case = f"{count} chairs with 6 wedges, 20 Hz, 1 page"
        share, sent = drawing(count, seconds, settle)
        rows.append(Row("viewer", case, "CPU of drawing and sending", 100.0 * share, "% of a core", _goal(count, 10)))
        rows.append(Row("viewer", case, "sent while drawing alone", sent / 1000, "kB/s"))
        share, sent = whole(count, seconds, settle)
        rows.append(Row("viewer", case, "CPU of the viewer", 100.0 * share, "% of a core", _goal(count, 20)))
        rows.append(Row("viewer", case, "sent", sent / 1000, "kB/s"))
    return rows


def _goal(chairs: int, share: int) -> str:
    return f"< {share}" if chairs == 100 else ""


if __name__ == "__main__":
    draw(int(sys.argv[1]), float(sys.argv[2]))
