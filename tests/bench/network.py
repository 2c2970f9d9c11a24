"""Whole processes on the network: late ticks, CPU, memory and delays in real time, ticks a second in lockstep."""

from __future__ import annotations

import os
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final, NamedTuple

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
CHAIRS: Final = "tests.bench.chairs"


class Measured(NamedTuple):
    """Figures of one run.

    Attributes:
        rate: Ticks a second.
        ticks: Ticks that were made.
        late: How many of them were late.
        cpu: CPU time of the simulator, as a share of a core.
        router: That of the router, 0 without one.
        memory: Resident memory of the simulator at the end, MiB.
        delays: Milliseconds from a command to the measures that show its effect, each time that it was tried.
    """

    rate: float
    ticks: int
    late: int
    cpu: float
    router: float
    memory: float
    delays: list[float]


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


def memory_of(pid: int) -> float:
    """Return the resident memory of a process, MiB."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def measure(
    server: str,
    pace: str,
    chairs: int,
    sessions: int,
    seconds: float,
    *,
    host: str = CHAIRS,
    floor: Map | None = None,
    more: Sequence[str] = (),
    router: bool = False,
    xml: bool = False,
    settle: float = 1.0,
) -> Measured:
    """Return the figures of so many seconds, with the chairs in another process.

    Args:
        server: Module of the simulator.
        pace: Its pace.
        chairs: Number of chairs.
        sessions: Number of Zenoh sessions that they share.
        seconds: How long to measure.
        host: Module of the process of the chairs.
        floor: The map; a hospital if it is None.
        more: Further options of the simulator.
        router: Whether all connect through a router.
        xml: Whether the chairs speak XML.
        settle: Seconds before the measurement: the first ticks are not the rule.
    """
    address = endpoint()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        file = Path(folder) / "hospital.xml"
        file.write_text(write_file(hospital(1) if floor is None else floor))
        pids = []
        if router:
            between = stack.enter_context(process("intellwheels_server.service.router", "--listen", address))
            wait_for(between, "ready")
            pids.append(between.pid)
        words = [server, "--map", str(file), "--world", WORLD, "--connect" if router else "--listen", address]
        words += ["--pace", pace, *more]
        if pace == "lockstep":
            words += ["--miss", "elastic"]
        names = ",".join(f"a{k:04d}" for k in range(chairs))
        simulator = stack.enter_context(process(*words, "--expect", names))
        wait_for(simulator, "ready")
        pids.append(simulator.pid)
        words = [host, address, WORLD, str(chairs), str(sessions), *(["--xml"] if xml else [])]
        body_set = stack.enter_context(process(*words))
        wait_for(body_set, "ready")
        session = link.open_session(link.Link(connect=(address,)), threading.Event())
        assert session is not None
        with session:
            threading.Event().wait(settle)
            first, begun, cpu = _clock(session), time.monotonic(), [cpu_of(pid) for pid in pids]
            threading.Event().wait(seconds)
            last, ended = _clock(session), time.monotonic()
            spent = [(cpu_of(pid) - before) / (ended - begun) for pid, before in zip(pids, cpu, strict=True)]
        memory, delays = memory_of(simulator.pid), []
        if host == CHAIRS:
            assert body_set.stdin is not None
            body_set.stdin.close()
            delays = [float(word) for word in wait_for(body_set, "delays").split()[1:]]
    ticks = last.tick - first.tick
    shared = spent[0] if router else 0.0
    return Measured(ticks / (ended - begun), ticks, last.late - first.late, spent[-1], shared, memory, delays)


def _clock(session: object) -> Clock:
    answer = link.query(session, Keys(WORLD).clock)[0]  # type: ignore[arg-type]
    return decode(Clock, answer.data, strict=False)


class Case(NamedTuple):
    """So many chairs in so many sessions, and how they speak."""

    chairs: int
    sessions: int
    xml: bool = False
    router: bool = False


CASES: Final = (
    Case(20, 20),
    Case(100, 20),
    Case(300, 20),
    Case(300, 1),
    Case(300, 20, xml=True),
    Case(1000, 20),
    Case(1000, 20, router=True),
)
"""The runs in real time."""
GOALS: Final = {(100, False): "<= 8", (300, False): "<= 15", (1000, False): "<= 35", (1000, True): "<= 40"}
"""Share of a core for so many chairs, directly or through a router, %."""
ENOUGH: Final = 20
"""Delays that a percentile needs at least."""


def bench(*, seconds: float = 60.0, lockstep_seconds: float = 10.0, small: bool = False) -> list[Row]:
    """Return the rows."""
    rows = []
    settle = 0.2 if small else 1.0
    for case in (Case(2, 1, xml=True, router=True),) if small else CASES:
        found = measure(
            "intellwheels_server",
            "realtime",
            case.chairs,
            case.sessions,
            seconds,
            router=case.router,
            xml=case.xml,
            settle=settle,
        )
        rows += _rows(case, found)
    for chairs in (1,) if small else (1, 4, 20, 100):
        goal = {4: ">= 2200", 20: ">= 1150", 100: ">= 300"}.get(chairs, "")
        for name, server in (("drop, put again", "intellwheels_server"), ("block", "tests.bench.blocking_server")):
            rate = measure(server, "lockstep", chairs, chairs, lockstep_seconds, settle=settle).rate
            rows.append(Row("lockstep", f"{chairs} agents, {name}", "rate", rate, "ticks/s", goal))
    return rows


def _rows(run: Case, found: Measured) -> list[Row]:
    chairs = run.chairs
    case = f"{chairs} chairs, {run.sessions} session{'s' if run.sessions > 1 else ''}, 20 Hz"
    case += ", XML" if run.xml else ""
    case += ", through a router" if run.router else ""
    goal = GOALS.get((chairs, run.router), "")
    rows = [
        Row("network", case, "late ticks", 100.0 * found.late / max(1, found.ticks), "%", "<= 0.1"),
        Row("network", case, "CPU of the simulator", 100.0 * found.cpu, "% of a core", goal),
        Row("network", case, "memory of the simulator", found.memory, "MiB"),
    ]
    if run.router:
        rows.append(Row("network", case, "CPU of the router", 100.0 * found.router, "% of a core"))
    if found.ticks:
        each = 1e6 * found.cpu / found.rate / chairs
        rows.append(Row("network", case, "CPU of the simulator, each agent and tick", each, "µs"))
    if len(found.delays) >= ENOUGH:
        slow = statistics.quantiles(found.delays, n=100, method="inclusive")[98]
        bound = "<= 60" if chairs == max(one.chairs for one in CASES) else ""
        rows.append(Row("network", case, "command to measures, 99th percentile", slow, "ms", bound))
    return rows
