"""Processes by the names of their agents: faults reach the right one, and a wrong name says which there are.

Agents here are small Python programs; with the project's own agents and a simulator it is `test_rig.py`.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from intellwheels_experiments.run.run_processes import AwaitedError
from intellwheels_experiments.testing.process_group import WORLD, ProcessGroup
from intellwheels_schemas.errors import WireError

pytestmark = pytest.mark.process

UNTIL_KILLED = "print('here', flush=True); import signal; signal.alarm(60); signal.pause()"


@pytest.fixture
def ensemble(tmp_path: Path) -> Iterator[ProcessGroup]:
    made = ProcessGroup(tmp_path / "logs", [], router=False, folder=None)
    yield made
    made.close()


def start(ensemble: ProcessGroup, name: str, program: str, *words: str) -> None:
    ensemble._start_agent(name, [sys.executable, "-c", program, *words], None, None, "json", {})


def wait(ensemble: ProcessGroup, name: str, verb: str = "here") -> dict[str, str]:
    return ensemble.processes.line(ensemble._child(name), verb)


def test_a_command_is_told_its_name_world_and_endpoint(ensemble: ProcessGroup) -> None:
    program = (
        "import os, sys; print('told', 'name=' + sys.argv[1], 'at=' + sys.argv[2], 'world=' + os.environ['IW_WORLD'])"
    )
    start(ensemble, "a", program, "{name}", "{endpoint}")
    assert wait(ensemble, "a", "told") == {"name": "a", "at": ensemble.endpoint, "world": WORLD}
    assert ensemble.exit("a") == 0


def test_agents_are_awake_until_they_are_frozen_or_killed(ensemble: ProcessGroup) -> None:
    for name in ("b", "a"):
        start(ensemble, name, UNTIL_KILLED)
        wait(ensemble, name)
    assert ensemble._awake() == ["a", "b"]
    ensemble.freeze("a")
    assert ensemble._awake() == ["b"]
    ensemble.thaw("a")
    ensemble.kill("b")
    assert ensemble._awake() == ["a"]


def test_a_killed_agent_may_end_and_cannot_be_killed_again(ensemble: ProcessGroup) -> None:
    start(ensemble, "a", UNTIL_KILLED)
    wait(ensemble, "a")
    ensemble.kill("a")
    assert ensemble.exit("a") == -signal.SIGKILL
    with pytest.raises(AwaitedError, match=r"agent-a: expected a process that runs, got killed by SIGKILL(.|\n)*here"):
        ensemble.kill("a")


def test_an_agent_that_fails_by_itself_is_named_with_its_last_words(ensemble: ProcessGroup) -> None:
    start(ensemble, "a", "raise SystemExit('no such wheel')")
    ensemble.processes.exit(ensemble._child("a"))
    # The simulator of this ensemble was never started, and so did not end.
    with pytest.raises(AwaitedError, match=r"agent-a: exit 1; its last lines:\nno such wheel"):
        ensemble._check()


def test_a_name_that_was_not_started_says_which_were(ensemble: ProcessGroup) -> None:
    with pytest.raises(LookupError, match=r"expected an agent that was started \(none\), got 'a'"):
        ensemble.log("a")
    start(ensemble, "b", UNTIL_KILLED)
    with pytest.raises(LookupError, match=r"\(b\), got 'a'"):
        ensemble.freeze("a")


def test_a_name_that_is_none_is_refused(ensemble: ProcessGroup) -> None:
    with pytest.raises(WireError):
        start(ensemble, "No Name", "")


def test_a_command_has_no_robot_of_ours(ensemble: ProcessGroup) -> None:
    with pytest.raises(ValueError, match="agent 'a': a command has neither robot, place nor options"):
        ensemble._start_agent("a", [sys.executable, "-c", ""], "rear-wheel", None, "json", {})


def test_without_a_router_none_can_be_cut(ensemble: ProcessGroup) -> None:
    assert not ensemble.has_router
    for fault in (ensemble.cut_router, ensemble.mend_router):
        with pytest.raises(ValueError, match="expected a world with router=True"):
            fault()


def test_closing_ends_what_runs_and_may_be_done_twice(ensemble: ProcessGroup) -> None:
    start(ensemble, "a", UNTIL_KILLED)
    wait(ensemble, "a")
    ensemble.close()
    assert ensemble.processes.children.living == ()
    ensemble.close()
    assert dict(ensemble.sections())["agent-a (killed by SIGTERM)"] == "here"
