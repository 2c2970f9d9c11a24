"""A process reads the log from standard output; the router's own lines go where they went before."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.server.service.test_denials import ACTIONS, DROPPED, STUDENT, line

PROGRAM = """
import os, sys
from intellwheels_server.service.denial_process import DenialProcess
report = DenialProcess()
if sys.argv[1] == "killed":
    report._child.kill()
    report._child.wait()
    print(report.has_ended(), report.has_ended(), file=report.out)
for _ in range(1000):
    os.write(1, sys.stdin.buffer.read() or b"x" * 10_000 + b"\\n")
print("ready", file=report.out, flush=True)
report.close()
report.close()
print("after")
"""


@pytest.mark.process
@pytest.mark.parametrize(
    ("how", "out", "words"),
    [
        ("lives", "ready\nafter\n", "denied why='student1 may not write in/st2-a/actions in world main' times=1"),
        # Nobody waits for a reader that is gone, and there is no more than a line about it.
        ("killed", "True False\nready\nafter\n", ""),
    ],
)
def test_denials_are_reported_beside_the_own_output(how: str, out: str, words: str) -> None:
    log = line(f"{STUDENT} unauthorized to Put (ingress) on {ACTIONS}") + line(DROPPED)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, how], input=log, capture_output=True, timeout=60.0, check=True
    )
    assert done.stdout.decode() == out
    assert done.stderr.decode() == (f"iw-router: {words}\n" if words else "")
