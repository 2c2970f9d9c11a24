"""Late ticks of a run in real time with somebody looking on and without, minute by minute in pairs.

`python -m tests.bench bystanders` takes about 25 minutes. `python -m tests.bench.bystanders PORT COUNT` is the pages.
"""

from __future__ import annotations

import os
import signal
import statistics
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path

from intellwheels_maps.hospital import hospital
from intellwheels_schemas import link
from intellwheels_schemas.codec import decode
from intellwheels_schemas.files import write_file
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Clock
from tests.bench.network import process, wait_for
from tests.bench.rows import Row
from tests.bench.sink import endpoint
from tests.bench.viewer import said
from tests.viewer.browser import opened

WORLD = "bench"
SETTLE = 4.0
"""Seconds until a viewer has fetched everything and its pages are made."""


@contextmanager
def frozen_viewer(address: str, settle: float = SETTLE) -> Iterator[None]:
    """A viewer that has stopped in the middle of everything."""
    with process("intellwheels_viewer", "--connect", address, "--port", "0") as viewer:
        said(viewer, "ready url=")
        threading.Event().wait(settle)
        os.killpg(viewer.pid, signal.SIGSTOP)
        try:
            yield
        finally:
            os.killpg(viewer.pid, signal.SIGCONT)


@contextmanager
def alone(settle: float = SETTLE) -> Iterator[None]:
    """Nobody looks on."""
    threading.Event().wait(settle)
    yield


@contextmanager
def watched(address: str, pages: int, settle: float = SETTLE) -> Iterator[None]:
    """A viewer with so many pages that read everything, in a process of their own."""
    with process("intellwheels_viewer", "--connect", address, "--port", "0") as viewer:
        port = said(viewer, "ready url=").rpartition(":")[2]
        with process("tests.bench.bystanders", port, str(pages)) as readers:
            wait_for(readers, "ready")
            threading.Event().wait(settle)
            yield


def pairs(
    late: Callable[[], int],
    beside: Callable[[], AbstractContextManager[None]],
    without: Callable[[], AbstractContextManager[None]],
    count: int,
    seconds: float,
) -> list[int]:
    """Return for each pair how many ticks more were late beside it. Every other pair begins without."""

    def spent(other: Callable[[], AbstractContextManager[None]]) -> int:
        with other():
            first = late()
            threading.Event().wait(seconds)
            return late() - first

    found = []
    for number in range(count):
        if number % 2:
            alone = spent(without)
            found.append(spent(beside) - alone)
        else:
            more = spent(beside)
            found.append(more - spent(without))
    return found


def bench(
    *, chairs: int = 5, count: int = 5, seconds: float = 60.0, pages: int = 10, settle: float = SETTLE
) -> list[Row]:
    """Return the rows."""
    address = endpoint()
    names = ",".join(f"a{k:04d}" for k in range(chairs))
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        floor = Path(folder) / "hospital.xml"
        floor.write_text(write_file(hospital(1)))
        words = ("--map", str(floor), "--world", WORLD, "--listen", address, "--pace", "realtime", "--expect", names)
        simulator = stack.enter_context(process("intellwheels_server", *words))
        wait_for(simulator, "ready")
        body_set = stack.enter_context(process("tests.bench.chairs", address, WORLD, str(chairs), str(chairs)))
        wait_for(body_set, "ready")
        session = link.open_session(link.Link(connect=(address,)), threading.Event())
        assert session is not None
        stack.enter_context(session)

        def late() -> int:
            return decode(Clock, link.query(session, Keys(WORLD).clock)[0].data, strict=False).late

        rows = []
        for name, beside, without in (
            ("frozen viewer against none", lambda: frozen_viewer(address, settle), lambda: alone(settle)),
            (
                f"{pages} pages against none",
                lambda: watched(address, pages, settle),
                lambda: watched(address, 0, settle),
            ),
        ):
            found = pairs(late, beside, without, count, seconds)
            print(f"{name}: late ticks more in {seconds:g} s, pair by pair: {found}", flush=True)
            case = f"{chairs} chairs, 20 Hz, {count} x {seconds:g} s, {name}"
            rows.append(Row("bystanders", case, "late ticks more, median", float(statistics.median(found)), "", "<= 1"))
    return rows


def main() -> None:
    """Be the pages."""
    with ExitStack() as stack:
        pages = [stack.enter_context(opened(int(sys.argv[1]))) for _ in range(int(sys.argv[2]))]
        for page in pages:
            page.element("Camera")
        print("ready", flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    main()
