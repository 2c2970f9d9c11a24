"""A program under a guard ends with the run that it belongs to, and its end is told as it was."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_experiments.run.foreign_program import launch_program
from tests.e2e.stage import is_gone

pytestmark = pytest.mark.process

DEADLINE = 20.0
UNTIL_KILLED = "import signal; signal.alarm(60); signal.pause()"
PRINTS_PID = f"import os; print('here', f'pid={{os.getpid()}}', flush=True); {UNTIL_KILLED}"
STUBBORN = f"import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); {PRINTS_PID}"
LEAVES = (
    "import signal, sys; signal.signal(signal.SIGTERM, lambda *_: (print('left', flush=True), sys.exit(7))); "
    f"{PRINTS_PID}"
)


def guarded(children: ChildProcesses, program: str) -> str:
    return launch_program(children, "a", [sys.executable, "-c", program], {}, Path.cwd())


@pytest.mark.parametrize(
    ("program", "code"),
    [("print('x'); raise SystemExit(3)", 3), ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", -11)],
)
def test_end_of_a_program_is_told_as_it_was(program: str, code: int, tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        assert children.exit(guarded(children, program), DEADLINE) == code


def test_program_that_cannot_be_started_is_named(tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        child = launch_program(children, "a", ["./nowhere"], {}, tmp_path)
        assert children.exit(child, DEADLINE) == 127
        assert children.tail(child) == [
            "./nowhere: expected a program that can be started, got No such file or directory"
        ]


def test_program_hears_sigterm_and_leaves_by_itself(tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        child = guarded(children, LEAVES)
        children.line(child, "here", DEADLINE)
        assert children.end([child], grace=DEADLINE) == []
        assert children.exit(child, DEADLINE) == 7
        assert children.tail(child, 1) == ["left"]


def test_program_goes_with_its_guard(tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        child = guarded(children, PRINTS_PID)
        pid = int(children.line(child, "here", DEADLINE)["pid"])
        children.signal(child, signal.SIGKILL)
        assert children.exit(child, DEADLINE) == -signal.SIGKILL
        assert is_gone(pid, DEADLINE)


@pytest.mark.parametrize("program", [PRINTS_PID, STUBBORN], ids=["plain", "stubborn"])
def test_kill_of_the_parent_ends_the_program(program: str, tmp_path: Path) -> None:
    parent = (
        "import sys\nfrom pathlib import Path\n"
        "from intellwheels_experiments.run.child_processes import ChildProcesses\n"
        "from intellwheels_experiments.run.foreign_program import launch_program\n"
        f"children = ChildProcesses(Path({str(tmp_path)!r}))\n"
        f"launch_program(children, 'a', [sys.executable, '-c', {program!r}], {{}}, Path.cwd())\n"
        "print(children.line('a', 'here')['pid'], flush=True)\n"
        f"{UNTIL_KILLED}\n"
    )
    with subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        pid = int(process.stdout.readline())
        assert not is_gone(pid)
        process.kill()
        process.wait(DEADLINE)
        assert is_gone(pid, DEADLINE)
