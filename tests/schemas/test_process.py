import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

DEADLINE = 20.0
CHILD = """
import sys, threading
from intellwheels_schemas.process import stop_on_signals
stop = stop_on_signals(int(sys.argv[1]) if len(sys.argv) > 1 else None)
print("ready", flush=True)
for _ in range(100):
    if stop.wait(0.2):
        break
print("stopped", flush=True)
if "stuck" in sys.argv:
    threading.Event().wait(60)
"""


def start(*words: str, lifeline: int | None = None) -> "subprocess.Popen[str]":
    numbers = () if lifeline is None else (lifeline,)
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, *map(str, numbers), *words],
        stdout=subprocess.PIPE,
        text=True,
        pass_fds=numbers,
        start_new_session=True,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "ready\n"
    return child


def outcome(child: "subprocess.Popen[str]") -> tuple[str, int]:
    # Not communicate: what readline has read ahead would be lost to it.
    assert child.stdout is not None
    with child.stdout as stream:
        said = stream.read()
    return said, child.wait(timeout=DEADLINE)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signal_stops(number: signal.Signals) -> None:
    child = start()
    child.send_signal(number)
    assert outcome(child) == ("stopped\n", 0)


def test_end_of_the_lifeline_stops_and_nothing_before_it() -> None:
    reading, writing = os.pipe()
    child = start(lifeline=reading)
    os.close(reading)
    os.write(writing, b"still here")
    os.close(writing)
    assert outcome(child) == ("stopped\n", 0)


def test_process_that_does_not_stop_when_its_lifeline_ends_is_killed() -> None:
    reading, writing = os.pipe()
    child = start("stuck", lifeline=reading)
    os.close(reading)
    os.close(writing)
    assert outcome(child) == ("stopped\n", -signal.SIGKILL)


def test_lifeline_that_is_no_descriptor_stops(tmp_path: Path) -> None:
    reading = os.open(tmp_path, os.O_RDONLY)
    child = start(lifeline=reading)
    os.close(reading)
    assert outcome(child) == ("stopped\n", 0)
