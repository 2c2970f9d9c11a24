"""A fork of pytest would have its threads and sessions, so each test forks from a small process of its own."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.process

DEADLINE = 30.0

# Long work says that it has begun. The pipe ends when nobody who does it is left.
PROGRAM = """
import os, sys, time
from intellwheels_server.service.side_process import SideProcess

begun, tell = os.pipe()

def work(job):
    if job == "long":
        os.write(tell, b"!")
        time.sleep(3600.0)
    if job == "end":
        os._exit(3)
    if job == "wrong":
        raise ValueError("our bug")
    return job, os.getpid()

side = SideProcess(work)
os.close(tell)

def outcome(job, limit=20.0):
    side.begin(job, limit)
    while (found := side.take()) is None:
        time.sleep(0.001)
    return found

"""


def run(program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", PROGRAM + program],
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        check=False,
    )


def test_each_piece_of_work_has_a_process_of_its_own() -> None:
    done = run("""
pids = [os.getpid()]
for k in range(3):
    code, (job, pid) = outcome(k)
    assert (code, job) == ("done", k)
    pids.append(pid)
assert len(set(pids)) == 4
large = bytes(5_000_000)
assert outcome(large)[1][0] == large
side.close()
""")
    assert (done.returncode, done.stderr) == (0, "")


def test_work_that_takes_too_long_or_ends_early_is_reported_and_the_next_one_is_done() -> None:
    done = run("""
for job, limit in (("long", 0.05), ("end", 20.0), ("wrong", 20.0)):
    print(outcome(job, limit).code)
print(outcome("next").code)
side.close()
""")
    assert done.stdout.split() == ["late", "crashed", "crashed", "done"]
    assert done.stderr.count("ValueError: our bug") == 1
    assert done.returncode == 0


def test_close_ends_work_that_goes_on() -> None:
    done = run("""
side.begin("long", 3600.0)
print(os.read(begun, 1))
side.close()
print(os.read(begun, 1))
try:
    os.waitpid(-1, 0)
except ChildProcessError:
    print("nobody is left")
""")
    assert done.stdout.split("\n")[:3] == ["b'!'", "b''", "nobody is left"]
    assert done.returncode == 0


def test_lost_side_process_is_reported() -> None:
    done = run("""
import signal
os.kill(side._pid, signal.SIGKILL)
print(outcome("work").code, outcome("more").code)
side.close()
""")
    assert done.stdout.split() == ["crashed", "crashed"]
    assert done.returncode == 0


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_side_process_and_its_work_end_with_the_process_that_made_them(number: int) -> None:
    program = 'side.begin("long", 3600.0)\nprint("begun", flush=True)\nsys.stdin.read()\n'
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM + program],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "begun\n"
            process.send_signal(number)
            # Standard error closes when the last process that holds it has ended.
            process.communicate(timeout=DEADLINE)
        finally:
            process.kill()
