"""What is waited for comes, or the failure says what did not and what was printed."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from intellwheels_experiments.run.run_processes import AwaitedError, RunProcesses

pytestmark = pytest.mark.process

WAITS = "print('ready port=7 name=a', flush=True); import signal; signal.alarm(60); signal.pause()"
SAYS_AND_FAILS = "print('ready name=b'); print('no such wheel'); raise SystemExit(3)"


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[RunProcesses]:
    found = RunProcesses(tmp_path / "logs")
    yield found
    found.close()


def launch(processes: RunProcesses, name: str, program: str, environment: dict[str, str] | None = None) -> str:
    return processes.launch(name, lambda _: [sys.executable, "-c", program], environment)


def test_line_is_given_with_its_values(processes: RunProcesses) -> None:
    child = launch(processes, "a", WAITS)
    assert processes.line(child, "ready", name="a") == {"port": "7", "name": "a"}


def test_last_line_of_a_process_that_ended_is_heard(processes: RunProcesses) -> None:
    child = launch(processes, "a", SAYS_AND_FAILS)
    assert processes.exit(child) == 3
    assert processes.line(child, "ready") == {"name": "b"}


def test_end_of_the_process_that_should_have_said_it_fails_at_once_with_its_log(processes: RunProcesses) -> None:
    child = launch(processes, "a", SAYS_AND_FAILS)
    with pytest.raises(
        AwaitedError, match=r"line 'running' of a did not come: a: exit 3\n--- a \(exit 3\)\n(.|\n)*wheel"
    ):
        processes.line(child, "running")


def test_wait_that_is_too_long_fails_with_its_name(processes: RunProcesses) -> None:
    with pytest.raises(AwaitedError, match=r"spring did not come in 0\.01 s"):
        processes.wait(lambda: None, "spring", 0.01)


def test_second_process_of_a_name_has_a_number(processes: RunProcesses) -> None:
    assert [launch(processes, "a", "") for _ in range(3)] == ["a", "a.2", "a.3"]


def test_environment_is_added_to_ours(processes: RunProcesses) -> None:
    child = launch(processes, "a", "import os; print('has', 'x=' + os.environ['IW_X'])", {"IW_X": "5"})
    assert processes.line(child, "has") == {"x": "5"}


def test_signal_ends_a_process_and_the_section_says_how(processes: RunProcesses) -> None:
    child = launch(processes, "a", WAITS)
    processes.line(child, "ready")
    assert processes.sections()[0][0] == "a (runs)"
    processes.signal(child, signal.SIGKILL)
    assert processes.exit(child) == -signal.SIGKILL
    assert processes.sections() == [("a (killed by SIGKILL)", "ready port=7 name=a")]


def test_tail_leaves_out_steps_that_were_asked_for(processes: RunProcesses) -> None:
    child = launch(processes, "a", "print('joined a'); [print(f'asked verb=step tick={n}') for n in range(99)]")
    processes.exit(child)
    assert processes.tail(child) == "joined a"
