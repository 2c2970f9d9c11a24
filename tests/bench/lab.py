"""Networked chairs through the router of a lab: with rules and passwords, and with TLS too, beside a router without.

All cases have the same chairs, sessions and map. They take turns, so that the load of the machine is the same for all.
"""

from __future__ import annotations

import io
import tempfile
import threading
from collections.abc import Iterable
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Final, NamedTuple

from intellwheels_experiments.run.endpoints import free_port
from intellwheels_maps.hospital import hospital
from intellwheels_schemas import link
from intellwheels_schemas.codec import decode
from intellwheels_schemas.files import write_file
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Clock, Identity, Lab, May
from intellwheels_server.service import lab_keys
from tests.bench.network import WORLD, process, wait_for
from tests.bench.rows import Row

FLOOD: Final = "rules, one student floods the simulator with queries"
CASES: Final = ("no rules", "rules", "rules and TLS", FLOOD)
BESIDE: Final = {"rules": "no rules", "rules and TLS": "rules", FLOOD: "rules"}
"""What each case is compared with."""
RATE: Final = 20.0  # Hz


class Measured(NamedTuple):
    """Figures of one run: late ticks as a share of all, and CPU seconds of simulator and router for each tick."""

    late: float
    simulator: float
    router: float


def write_lab(folder: Path, sessions: int) -> Path:
    """Write a lab with a simulator, a teacher and a student for each session of chairs; return its document."""
    students = (
        Identity(name=f"student{number}", may=(May(role="agent", world=WORLD, agents=(f"st{number}-*",)),))
        for number in range(sessions)
    )
    identities = (
        Identity(name="simulator", may=(May(role="simulator", world=WORLD),)),
        Identity(name="teacher", may=(May(role="operator", world=WORLD, agents=("*",)),)),
        *students,
    )
    file = folder / "lab.xml"
    file.write_text(write_file(Lab(format="iw.v1", name="bench", identity=identities)))
    written = [["keys", "--host", "127.0.0.1"]]
    written += [["invite", one.name, "--out", str(folder / f"{one.name}.iwid")] for one in identities]
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        for words in written:
            if lab_keys.main([*words, "--lab", str(file)]) != 0:
                raise RuntimeError(f"expected files of a lab, got none of iw-lab {words[0]}")
    return file


def cpu_of(pid: int) -> float:
    """Return the CPU seconds that the threads of a process have used: finer than the count of the whole process."""
    threads = Path(f"/proc/{pid}/task").glob("*/schedstat")
    return sum(int(thread.read_text().split()[0]) for thread in threads) / 1e9


def measure(case: str, folder: Path, chairs: int, sessions: int, ticks: int, settle: float) -> Measured:
    """Return the figures of so many ticks at 20 Hz. The folder has the files of `write_lab`, and the map."""
    address = f"{'tls' if 'TLS' in case else 'tcp'}/127.0.0.1:{free_port()}"
    rules = case != "no rules"
    lab = ("--lab", str(folder / "lab.xml")) if rules else ()
    names = ",".join(f"st{number}-{k}" for number in range(sessions) for k in range(chairs // sessions))
    with ExitStack() as stack:
        router = stack.enter_context(process("intellwheels_server.service.router", "--listen", address, *lab))
        wait_for(router, "ready")
        shown = ("--identity", str(folder / "simulator.iwid")) if rules else ()
        words = ("--map", str(folder / "hospital.xml"), "--world", WORLD, "--pace", "realtime", "--connect", address)
        simulator = stack.enter_context(process("intellwheels_server", *words, *shown, "--expect", names))
        wait_for(simulator, "ready")
        students = (str(folder),) if rules else ("",)
        driving = ("tests.bench.chairs", address, WORLD, str(chairs), str(sessions), *students)
        wait_for(stack.enter_context(process(*driving)), "ready")
        if case == FLOOD:
            flood = ("tests.bench.flood", address, WORLD, str(folder / "student0.iwid"), "st0-0")
            wait_for(stack.enter_context(process(*flood)), "ready")
        route = link.Link(WORLD, connect=(address,), identity=folder / "teacher.iwid" if rules else None)
        session = link.open_session(route, threading.Event(), timeout=60.0)
        assert session is not None
        with session:
            threading.Event().wait(settle)  # the first ticks are not the rule
            first, before = _clock(session), (cpu_of(simulator.pid), cpu_of(router.pid))
            last = first
            while last.tick < first.tick + ticks:
                threading.Event().wait(max(first.tick + ticks - last.tick, 1) / RATE)
                last = _clock(session)
            spent = cpu_of(simulator.pid) - before[0], cpu_of(router.pid) - before[1]
    made = last.tick - first.tick
    return Measured((last.late - first.late) / made, spent[0] / made, spent[1] / made)


def _clock(session: object) -> Clock:
    answer = link.query(session, Keys(WORLD).clock, timeout=30.0)[0]  # type: ignore[arg-type]
    return decode(Clock, answer.data, strict=False)


def bench(
    chairs: Iterable[int] = (100, 300),
    cases: tuple[str, ...] = CASES,
    *,
    sessions: int = 20,
    ticks: int = 200,
    rounds: int = 3,
    settle: float = 2.0,
) -> list[Row]:
    """Return the rows: the least CPU and late ticks of all rounds, as other work can only add to them; and ratios."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "hospital.xml").write_text(write_file(hospital(1)))
        write_lab(folder, sessions)
        for count in chairs:
            found: dict[str, list[Measured]] = {case: [] for case in cases}
            for _ in range(rounds):
                for case in cases:
                    found[case].append(measure(case, folder, count, sessions, ticks, settle))
            rows += _rows(f"{count} chairs, {sessions} sessions, 20 Hz", found)
    return rows


def _rows(load: str, found: dict[str, list[Measured]]) -> list[Row]:
    rows = []
    least = {case: Measured(*(min(column) for column in zip(*runs, strict=True))) for case, runs in found.items()}
    for case, one in least.items():
        where = f"{load}, {case}"
        rows.append(Row("lab", where, "late ticks", 100.0 * one.late, "%"))
        rows.append(Row("lab", where, "CPU of the simulator", 1e3 * one.simulator, "ms/tick"))
        rows.append(Row("lab", where, "CPU of the router", 1e3 * one.router, "ms/tick"))
        if (other := BESIDE.get(case)) in least:
            beside, where = least[other], f"{load}, {case} / {other}"
            rows.append(Row("lab", where, "CPU of the simulator", one.simulator / beside.simulator, "ratio"))
            rows.append(Row("lab", where, "CPU of the router", one.router / beside.router, "ratio"))
    return rows
