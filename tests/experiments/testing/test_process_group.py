"""The faults of a process group, on small programs. Worlds with a simulator are in `test_rig`."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from intellwheels_experiments.run.child_processes import WaitError
from intellwheels_experiments.testing.process_group import ProcessGroup

pytestmark = pytest.mark.process

ENDS_ON_TERM = "print('here', flush=True); import signal; signal.pause()"


class Group(ProcessGroup):
    """A group without a simulator, whose agents are Python programs."""

    def program(self, name: str, program: str, *arguments: str) -> None:
        self._start_agent(name, [sys.executable, "-c", program, *arguments], None, None, "json", {})

    def here(self, name: str) -> None:
        """Wait until a program printed `here`."""
        self.processes.line(f"agent-{name}", "here")


@pytest.fixture
def group(tmp_path: Path) -> Iterator[Group]:
    found = Group(tmp_path / "logs", [], router=False, folder=None)
    yield found
    found.close()


def test_program_gets_name_world_and_endpoint_as_arguments_and_environment(group: Group) -> None:
    program = "import os, sys; print(*sys.argv[1:], os.environ['IW_NAME'], os.environ['IW_WORLD'], '{name}')"
    group.program("chair1", program, "{name}", "{endpoint}")
    assert group.exit("chair1") == 0
    assert group.log("chair1") == f"chair1 {group.endpoint} chair1 test chair1\n"


def test_killed_process_is_gone_and_may_be_so(group: Group) -> None:
    group.program("chair1", ENDS_ON_TERM)
    group.here("chair1")
    group.kill("chair1")
    assert group.exit("chair1") == -signal.SIGKILL
    with pytest.raises(WaitError, match="agent-chair1: expected a running process, got killed by SIGKILL"):
        group.freeze("chair1")


def test_frozen_process_is_not_awake_until_it_is_thawed(group: Group) -> None:
    group.program("chair1", ENDS_ON_TERM)
    group.program("chair2", ENDS_ON_TERM)
    group.freeze("chair1")
    assert group._awake() == ["chair2"]
    group.thaw("chair1")
    assert group._awake() == ["chair1", "chair2"]


def test_close_ends_all_processes_and_may_be_called_again(group: Group) -> None:
    group.program("chair1", ENDS_ON_TERM)
    group.here("chair1")
    group.close()
    group.close()
    assert group.processes.running == ()
    assert [title for title, _ in group.sections()] == ["agent-chair1 (killed by SIGTERM)"]


def test_unknown_name_and_missing_router_are_errors(group: Group) -> None:
    with pytest.raises(LookupError, match=r"expected one of the agents that were started \(none\), got 'chair1'"):
        group.kill("chair1")
    for fault in (group.cut_router, group.mend_router):
        with pytest.raises(ValueError, match="expected a world with router=True"):
            fault()
