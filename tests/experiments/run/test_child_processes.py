"""Children are heard, ended and outlived by nobody. The children here are small Python programs."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from intellwheels_experiments.run.child_processes import ChildProcesses, Exited, Line, News

pytestmark = pytest.mark.process

DEADLINE = 20.0
UNTIL_KILLED = "import signal; signal.alarm(60); signal.pause()"
"""Waits for a signal; the alarm ends it when none comes."""
STUBBORN = f"import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('here', flush=True); {UNTIL_KILLED}"
PATIENT = """
import sys
from intellwheels_schemas.process import SLICE, stop_on_signals
stop = stop_on_signals(int(sys.argv[1]))
print('here', flush=True)
while not stop.wait(SLICE):
    pass
print('left', flush=True)
"""


def start(children: ChildProcesses, name: str, program: str) -> None:
    children.start(name, lambda lifeline: [sys.executable, "-c", program, str(lifeline)])


def hear(children: ChildProcesses, wanted: type[News]) -> News:
    deadline = time.monotonic() + DEADLINE
    while time.monotonic() < deadline:
        news = children.news(0.5)
        if isinstance(news, wanted):
            return news
    pytest.fail(f"no {wanted.__name__} in {DEADLINE} s")


def is_gone(pid: int, within: float = 0.0) -> bool:
    """Return whether a process, anybody's child, ends within so many seconds."""
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    try:
        return bool(select.select([descriptor], [], [], within)[0])
    finally:
        os.close(descriptor)


def test_lines_come_before_the_end(tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        start(children, "a", "print('ready x=1'); print('ended', flush=True); raise SystemExit(3)")
        assert hear(children, Line) == Line("a", "ready x=1")
        assert hear(children, Line) == Line("a", "ended")
        assert hear(children, Exited) == Exited("a", 3)
        assert children.living == ()


def test_log_holds_output_and_errors_and_its_tail_is_short(tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        start(children, "a", "import sys; print('out', flush=True); [print(i, file=sys.stderr) for i in range(100)]")
        hear(children, Exited)
        assert "out" in children.log_of("a").read_text()
        # Output and errors are two streams: which of them is last in the log is nobody's promise.
        assert [line for line in children.tail("a", 4) if line != "out"][-3:] == ["97", "98", "99"]


def test_end_of_a_child_that_a_signal_ended_says_which(tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        start(children, "a", "import os; os.kill(os.getpid(), 9)")
        ended = hear(children, Exited)
        assert isinstance(ended, Exited)
        assert ended.how == "killed by SIGKILL"


def test_child_that_ignores_sigterm_is_killed(tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        start(children, "a", STUBBORN)
        hear(children, Line)
        assert children.end(["a"], grace=0.3) == ["a"]
        assert children.living == ()


def test_child_that_is_stopped_still_leaves_in_words(tmp_path: Path) -> None:
    with ChildProcesses(tmp_path) as children:
        start(children, "a", PATIENT)
        hear(children, Line)
        os.kill(children.pid("a"), signal.SIGSTOP)
        assert children.end(["a"], grace=DEADLINE) == []
        assert children.tail("a", 1) == ["left"]


def test_what_a_child_started_ends_with_it(tmp_path: Path) -> None:
    program = (
        f"import subprocess,sys; p = subprocess.Popen([sys.executable, '-c', {UNTIL_KILLED!r}]); "
        "print(p.pid, flush=True)"
    )
    with ChildProcesses(tmp_path) as children:
        start(children, "a", program)
        line = hear(children, Line)
        assert isinstance(line, Line)
        hear(children, Exited)
        assert is_gone(int(line.text), DEADLINE)


def test_leaving_ends_children_also_after_an_error(tmp_path: Path) -> None:
    children = ChildProcesses(tmp_path)

    def fail() -> None:
        with children:
            start(children, "a", PATIENT)
            hear(children, Line)
            raise RuntimeError("ours")

    with pytest.raises(RuntimeError, match="ours"):
        fail()
    assert is_gone(children.pid("a"))


@pytest.mark.parametrize("stuck", [False, True], ids=["patient", "stuck"])
def test_kill_of_the_parent_ends_the_children(tmp_path: Path, stuck: bool) -> None:
    child = PATIENT.replace("while not stop.wait(SLICE):", "while True:") if stuck else PATIENT
    parent = (
        "import sys\nfrom pathlib import Path\nfrom intellwheels_experiments.run.child_processes import Children\n"
        f"children = Children(Path({str(tmp_path)!r}))\n"
        f"children.start('a', lambda lifeline: [sys.executable, '-c', {child!r}, str(lifeline)])\n"
        "children.news(20)\nprint(children.pid('a'), flush=True)\n"
        f"{UNTIL_KILLED}\n"
    )
    with subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        pid = int(process.stdout.readline())
        assert not is_gone(pid)
        process.kill()
        process.wait(DEADLINE)
        assert is_gone(pid, DEADLINE)
