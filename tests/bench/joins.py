"""Many agents that join at once: how long it takes until all are in."""

from __future__ import annotations

import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import zenoh

from intellwheels_maps.hospital import hospital
from intellwheels_schemas import link
from intellwheels_schemas.codec import encode
from intellwheels_schemas.files import write_file
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.names import new_hex
from tests.bench.chairs import chair
from tests.bench.network import WORLD, cpu_of, process, wait_for
from tests.bench.rows import Row
from tests.bench.sink import endpoint

SESSIONS = 20
DEADLINE = 300.0


def measure(count: int) -> tuple[float, float]:
    """Return the seconds until so many agents have joined that ask at the same time, and the simulator's CPU time."""
    address, keys = endpoint(), Keys(WORLD)
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        floor = Path(folder) / "hospital.xml"
        floor.write_text(write_file(hospital(1)))
        words = ("intellwheels_server", "--map", str(floor), "--world", WORLD, "--listen", address)
        simulator = stack.enter_context(process(*words, "--expect", "nobody"))
        wait_for(simulator, "ready")
        sessions = []
        for _ in range(min(SESSIONS, count)):
            session = link.open_session(link.Link(connect=(address,)), threading.Event())
            assert session is not None
            sessions.append(stack.enter_context(session))
        answers: list[bool] = []
        done = threading.Event()

        def take(reply: zenoh.Reply) -> None:
            answers.append(reply.ok is not None)
            if len(answers) == count:
                done.set()

        asked = []
        for number in range(count):
            session, name, instance = sessions[number % len(sessions)], f"a{number:04d}", new_hex()
            stack.callback(link.declare_token(session, keys.token(name, "both", instance)).undeclare)
            asked.append((session, name, encode(chair(name, instance))))
        begun, cpu = time.monotonic(), cpu_of(simulator.pid)
        for session, name, data in asked:
            session.get(keys.join(name), take, payload=data, timeout=DEADLINE)
        assert done.wait(DEADLINE), f"{len(answers)} of {count} have joined"
        assert all(answers), f"{answers.count(False)} were refused"
        return time.monotonic() - begun, cpu_of(simulator.pid) - cpu


def bench(counts: tuple[int, ...] = (300, 1000)) -> list[Row]:
    """Return the rows."""
    rows = []
    for count in counts:
        spent, cpu = measure(count)
        goal = "<= 3" if count == 1000 else ""
        rows.append(Row("joins", f"{count} agents at once", "until all are in", spent, "s", goal))
        rows.append(Row("joins", f"{count} agents at once", "CPU of the simulator", cpu, "s"))
    return rows
