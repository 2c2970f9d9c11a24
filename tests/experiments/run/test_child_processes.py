"""Children are heard, awaited and ended, and none outlives its parent. The children are small Python programs."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from intellwheels_experiments.run.child_processes import UNREAD_LIMIT, ChildProcesses, Exited, WaitError, parse
from tests.e2e.stage import is_gone

pytestmark = pytest.mark.process

DEADLINE = 20.0
UNTIL_KILLED = "import signal; signal.alarm(60); signal.pause()"
"""Waits for a signal; the alarm ends it when none comes."""
WAITS = f"print('ready port=7 name=a', flush=True); {UNTIL_KILLED}"
PRINTS_AND_FAILS = "print('ready name=b'); print('no such wheel'); raise SystemExit(3)"
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


@pytest.fixture
def children(tmp_path: Path) -> Iterator[ChildProcesses]:
    with ChildProcesses(tmp_path / "logs") as found:
        yield found


def launch(children: ChildProcesses, name: str, program: str, environment: dict[str, str] | None = None) -> str:
    return children.launch(name, lambda lifeline: [sys.executable, "-c", program, str(lifeline)], environment)


# ---------------------------------------------------------------- lines and ends


def test_all_lines_are_there_when_the_exit_is(children: ChildProcesses) -> None:
    child = launch(children, "a", "print('ready x=1'); print('ended', flush=True); raise SystemExit(3)")
    assert children.exit(child, DEADLINE) == 3
    assert children.exits == {"a": Exited("a", 3)}
    assert children.running == ()
    assert children.find_line(child, "ready") == {"x": "1"}
    assert children.find_line(child, "ended") == {}


def test_line_is_given_with_its_values(children: ChildProcesses) -> None:
    child = launch(children, "a", WAITS)
    assert children.line(child, "ready", DEADLINE, name="a") == {"port": "7", "name": "a"}


def test_line_that_was_found_and_those_before_it_are_read_and_others_stay(children: ChildProcesses) -> None:
    child = launch(children, "a", "print('a n=1'); print('b n=1'); print('a n=2'); print('ab n=3')")
    children.exit(child, DEADLINE)
    assert children.find_line(child, "c") is None
    assert children.find_line(child, "b") == {"n": "1"}
    assert children.find_line(child, "a") == {"n": "2"}
    assert children.find_line(child, "a") is None
    assert children.find_line(child, "ab", n="3") == {"n": "3"}


def test_unread_lines_do_not_grow_without_limit(children: ChildProcesses) -> None:
    child = launch(children, "a", f"for n in range({UNREAD_LIMIT} + 1): print(f'line n={{n}}')")
    children.exit(child, DEADLINE)
    assert children.find_line(child, "line") == {"n": "1"}


def test_last_line_of_a_process_that_ended_is_found(children: ChildProcesses) -> None:
    child = launch(children, "a", PRINTS_AND_FAILS)
    assert children.exit(child, DEADLINE) == 3
    assert children.line(child, "ready") == {"name": "b"}


def test_printed_line_is_a_verb_and_values() -> None:
    assert parse("ended tick=812 hash=00ff") == ("ended", {"tick": "812", "hash": "00ff"})
    assert parse("") == ("", {})
    assert parse("words without values") == ("words", {})


# ---------------------------------------------------------------- waits that fail


def test_end_of_the_awaited_process_fails_the_wait_at_once_with_its_log(children: ChildProcesses) -> None:
    child = launch(children, "a", PRINTS_AND_FAILS)
    with pytest.raises(WaitError, match=r"no line 'running' of a: a ended \(exit 3\)\n--- a \(exit 3\)\n(.|\n)*wheel"):
        children.line(child, "running")


def test_wait_that_takes_too_long_fails_with_its_name(children: ChildProcesses) -> None:
    with pytest.raises(WaitError, match=r"no spring within 0\.01 s"):
        children.wait(lambda: None, "spring", 0.01)


# ---------------------------------------------------------------- start


def test_second_process_of_a_name_has_a_number(children: ChildProcesses) -> None:
    assert [launch(children, "a", "") for _ in range(3)] == ["a", "a.2", "a.3"]


def test_environment_is_added_to_ours(children: ChildProcesses) -> None:
    child = launch(children, "a", "import os; print('has', 'x=' + os.environ['IW_X'])", {"IW_X": "5"})
    assert children.line(child, "has") == {"x": "5"}


def test_errors_are_lines_too_when_merged(children: ChildProcesses) -> None:
    program = "import sys; print('a', flush=True); print('b', file=sys.stderr, flush=True); print('c')"
    child = children.launch("a", lambda _: [sys.executable, "-c", program], merge_errors=True)
    children.exit(child, DEADLINE)
    assert children.log(child) == "a\nb\nc\n"
    assert children.find_line(child, "b") == {}


# ---------------------------------------------------------------- logs


def test_log_holds_output_and_errors_and_its_tail_is_short(children: ChildProcesses) -> None:
    child = launch(
        children, "a", "import sys; print('out', flush=True); [sys.stderr.write(f'{i}\\n') for i in range(99)]"
    )
    children.exit(child, DEADLINE)
    assert "out" in children.log(child).splitlines()
    # Output and errors are two streams, and the order of their lines in the log is not defined.
    assert [line for line in children.tail(child, 4) if line != "out"][-3:] == ["96", "97", "98"]


def test_tail_leaves_out_single_steps(children: ChildProcesses) -> None:
    child = launch(children, "a", "print('joined a'); [print(f'asked verb=step tick={n}') for n in range(99)]")
    children.exit(child, DEADLINE)
    assert children.tail(child) == ["joined a"]


def test_signal_ends_a_process_and_the_section_says_how(children: ChildProcesses) -> None:
    child = launch(children, "a", WAITS)
    children.line(child, "ready", DEADLINE)
    assert children.sections()[0][0] == "a (running)"
    children.signal(child, signal.SIGKILL)
    assert children.exit(child) == -signal.SIGKILL
    assert children.sections() == [("a (killed by SIGKILL)", "ready port=7 name=a")]


# ---------------------------------------------------------------- end


def test_child_that_ignores_sigterm_is_killed(children: ChildProcesses) -> None:
    child = launch(children, "a", STUBBORN)
    children.line(child, "here", DEADLINE)
    assert children.end([child], grace=0.3) == [child]
    assert children.running == ()


def test_how_a_child_ended_by_itself_is_known_after_end(children: ChildProcesses) -> None:
    # A process outside its group keeps the pipe open, so the end becomes known a second later.
    outside = "import subprocess; subprocess.Popen(['sleep', '5'], start_new_session=True); raise SystemExit(3)"
    child = launch(children, "a", outside)
    until = time.monotonic() + DEADLINE
    while children.running and time.monotonic() < until:
        os.sched_yield()
    assert children.running == ()
    children.end([child])
    children.receive()
    assert children.exited(child) == Exited("a", 3)


def test_stopped_child_still_ends_by_itself(children: ChildProcesses) -> None:
    child = launch(children, "a", PATIENT)
    children.line(child, "here", DEADLINE)
    os.kill(children.pid(child), signal.SIGSTOP)
    assert children.end([child], grace=DEADLINE) == []
    assert children.tail(child, 1) == ["left"]


def test_what_a_child_started_ends_with_it(children: ChildProcesses) -> None:
    program = (
        f"import subprocess,sys; p = subprocess.Popen([sys.executable, '-c', {UNTIL_KILLED!r}]); "
        "print('started', f'pid={p.pid}', flush=True)"
    )
    child = launch(children, "a", program)
    pid = int(children.line(child, "started", DEADLINE)["pid"])
    children.exit(child, DEADLINE)
    assert is_gone(pid, DEADLINE)


def test_leaving_ends_children_also_after_an_error(tmp_path: Path) -> None:
    children = ChildProcesses(tmp_path)

    def fail() -> None:
        with children:
            children.line(launch(children, "a", PATIENT), "here", DEADLINE)
            raise RuntimeError("ours")

    with pytest.raises(RuntimeError, match="ours"):
        fail()
    assert is_gone(children.pid("a"))


@pytest.mark.parametrize("stuck", [False, True], ids=["patient", "stuck"])
def test_kill_of_the_parent_ends_the_children(tmp_path: Path, stuck: bool) -> None:
    child = PATIENT.replace("while not stop.wait(SLICE):", "while True:") if stuck else PATIENT
    parent = (
        "import sys\nfrom pathlib import Path\n"
        "from intellwheels_experiments.run.child_processes import ChildProcesses\n"
        f"children = ChildProcesses(Path({str(tmp_path)!r}))\n"
        f"children.launch('a', lambda lifeline: [sys.executable, '-c', {child!r}, str(lifeline)])\n"
        "children.line('a', 'here')\nprint(children.pid('a'), flush=True)\n"
        f"{UNTIL_KILLED}\n"
    )
    with subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        pid = int(process.stdout.readline())
        assert not is_gone(pid)
        process.kill()
        process.wait(DEADLINE)
        assert is_gone(pid, DEADLINE)
