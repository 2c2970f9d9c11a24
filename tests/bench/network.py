"""Whole processes on the network: late ticks and CPU in real time, ticks a second in lockstep."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from intellwheels_maps.hospital import hospital
from intellwheels_schemas import link
from intellwheels_schemas.codec import decode
from intellwheels_schemas.files import write_file
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Clock, Map
from tests.bench.rows import Row
from tests.bench.sink import endpoint

WORLD = "bench"
DEADLINE = 120.0


@contextmanager
def process(*words: str) -> Iterator[subprocess.Popen[str]]:
    """Run a module of Python in its own process group and end it."""
    child = subprocess.Popen(
        [sys.executable, "-m", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    try:
        yield child
    finally:
        os.killpg(child.pid, signal.SIGTERM)
        try:
            child.wait(10.0)
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, signal.SIGKILL)
            child.wait()
        for stream in (child.stdin, child.stdout):
            assert stream is not None
            stream.close()


def wait_for(child: subprocess.Popen[str], word: str) -> str:
    """Read the child's lines until one begins with the word, and return it."""
    assert child.stdout is not None
    for line in child.stdout:
        if line.startswith(word):
            return line
    raise RuntimeError(f"expected a line '{word}' of {child.args!r}, got the end")


def cpu_of(pid: int) -> float:
    """Return the CPU seconds a process has used."""
    numbers = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")


def measure(
    server: str,
    pace: str,
    chairs: int,
    sessions: int,
    seconds: float,
    *,
    host: str = "tests.bench.chairs",
    floor: Map | None = None,
    more: Sequence[str] = (),
    settle: float = 1.0,
) -> tuple[float, int, float, float]:
    """Return ticks a second, late ticks, CPU share of the simulator and ticks, over so many seconds."""
    address = endpoint()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "hospital.xml"
        file.write_text(write_file(hospital(1) if floor is None else floor))
        words = [server, "--map", str(file), "--world", WORLD, "--listen", address, "--pace", pace, *more]
        if pace == "lockstep":
            words += ["--miss", "elastic"]
        names = ",".join(f"a{k:04d}" for k in range(chairs))
        with ExitStack() as stack:
            simulator = stack.enter_context(process(*words, "--expect", names))
            wait_for(simulator, "ready")
            body_set = stack.enter_context(process(host, address, WORLD, str(chairs), str(sessions)))
            wait_for(body_set, "ready")
            session = link.open_session(link.Link(connect=(address,)), threading.Event())
            assert session is not None
            with session:
                threading.Event().wait(settle)  # the first ticks are not the rule
                first, begun, cpu = _clock(session), time.monotonic(), cpu_of(simulator.pid)
                threading.Event().wait(seconds)
                last, ended, spent = _clock(session), time.monotonic(), cpu_of(simulator.pid) - cpu
    span = ended - begun
    ticks = last.tick - first.tick
    return ticks / span, last.late - first.late, spent / span, float(ticks)


def _clock(session: object) -> Clock:
    answer = link.query(session, Keys(WORLD).clock)[0]  # type: ignore[arg-type]
    return decode(Clock, answer.data, strict=False)


def bench(*, seconds: float = 60.0, lockstep_seconds: float = 10.0, small: bool = False) -> list[Row]:
    """Return the rows."""
    rows = []
    settle = 0.2 if small else 1.0
    for chairs, sessions in ((2, 1),) if small else ((20, 20), (100, 20), (300, 20), (1000, 20)):
        _, late, cpu, ticks = measure("intellwheels_server", "realtime", chairs, sessions, seconds, settle=settle)
        case = f"{chairs} chairs, {sessions} sessions, 20 Hz"
        rows.append(Row("network", case, "late ticks", 100.0 * late / ticks, "%", "<= 0.1"))
        goal = {100: "<= 8", 300: "<= 15", 1000: "<= 35"}.get(chairs, "")
        rows.append(Row("network", case, "CPU of the simulator", 100.0 * cpu, "% of a core", goal))
        if ticks:
            per_agent = 1e6 * cpu * seconds / ticks / chairs
            rows.append(Row("network", case, "CPU of the simulator, each agent and tick", per_agent, "µs"))
    for chairs in (1,) if small else (1, 4, 20, 100):
        goal = {4: ">= 2200", 20: ">= 1150", 100: ">= 300"}.get(chairs, "")
        for name, server in (("drop, put again", "intellwheels_server"), ("block", "tests.bench.blocking_server")):
            rate, *_ = measure(server, "lockstep", chairs, chairs, lockstep_seconds, settle=settle)
            rows.append(Row("lockstep", f"{chairs} agents, {name}", "rate", rate, "ticks/s", goal))
    return rows
