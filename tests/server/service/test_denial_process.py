"""A process reads the log from standard output; the router's own lines go where they went before."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.server.service.test_denials import ACTIONS, DROPPED, STUDENT, line

PROGRAM = """
import os, signal, sys
from pathlib import Path
from intellwheels_server.service.denial_process import DenialProcess
report = DenialProcess()
if sys.argv[1] == "killed":
    report._child.kill()
    report._child.wait()
    while not report.has_ended():
        pass
    print(report.has_ended(), file=report.out)
log = sys.stdin.buffer.read()
if sys.argv[1] in ("reader", "watcher"):
    watcher, children = report._child.pid, ""
    while not children:
        children = Path(f"/proc/{watcher}/task/{watcher}/children").read_text()
    reader = int(children)

    def writes():
        return int(Path(f"/proc/{reader}/io").read_text().split("syscw: ")[1].split()[0])

    before = writes()
    stopped = reader if sys.argv[1] == "reader" else watcher
    os.kill(stopped, signal.SIGSTOP)
    # More than any pipe holds.
    for _ in range(400):
        os.write(1, b"x" * 10_000 + b"\\n")
    os.kill(stopped, signal.SIGCONT)
    while writes() < before + (2 if stopped == reader else 1):
        os.write(1, log)
os.write(1, log)
for _ in range(1000):
    os.write(1, b"x" * 10_000 + b"\\n")
print("ready", file=report.out, flush=True)
report.close()
report.close()
print("after")
"""


LOG = line(f"{STUDENT} unauthorized to Put (ingress) on {ACTIONS}") + line(DROPPED)
DENIED = "iw-router: denied why='student1 may not write in/st2-a/actions in world main' times=1\n"


def outcome(how: str) -> tuple[str, str]:
    """Return what the program wrote to standard output and to standard error."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, how], input=LOG, capture_output=True, timeout=60.0, check=True
    )
    return done.stdout.decode(), done.stderr.decode()


@pytest.mark.process
def test_denials_are_reported_beside_the_own_output() -> None:
    assert outcome("lives") == ("ready\nafter\n", DENIED)


@pytest.mark.process
def test_nobody_waits_for_a_reader_that_is_gone() -> None:
    # The router says so, once.
    assert outcome("killed") == ("False\nready\nafter\n", "")


@pytest.mark.process
@pytest.mark.parametrize("stopped", ["reader", "watcher"])
def test_nobody_waits_for_a_process_that_is_stopped(stopped: str) -> None:
    out, errors = outcome(stopped)
    assert out == "ready\nafter\n"
    lines = errors.splitlines(keepends=True)
    assert next(text for text in lines if " denied " in text) == DENIED
    missing = "iw-router: some denials were not reported, as their report had been stopped\n"
    assert [text for text in lines if " denied " not in text] == ([missing] if stopped == "reader" else [])
