"""The fixture in a user's own pytest: a failure shows what the processes printed, and all of them end."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.process

USER = """
from pathlib import Path

def test_passes(intellwheels):
    sim = intellwheels(floor="corner")
    sim.agent("chair1", mind="mine.py", left=0.3)
    sim.run_until(lambda now: now["chair1"].speed > 0.1)

def test_fails(intellwheels):
    for _ in range(2):
        sim = intellwheels(floor="corner")
        sim.agent("chair1", mind="mine.py")
        print("PIDS", *map(sim.processes.pid, sim.processes.running))
    sim.run_until(lambda now: now["chair1"].x > 99.0, seconds=0.5)

def test_start_fails(intellwheels):
    intellwheels(floor="nowhere.xml")
"""
MINE = """
from intellwheels_agents.minds.drive import Mind as Drive
class Mind(Drive):
    def __init__(self, context):
        print("a word of mine", flush=True)
        super().__init__(context)
"""


def pytest_of_a_user(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    # By the file and not by the entry point: a checkout may be newer than what is installed.
    plugin = ["-p", "no:intellwheels", "-p", "intellwheels_experiments.testing.plugin", "-p", "no:cacheprovider"]
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-W", "error", "-p", "no:randomly", *plugin, *words],
        cwd=folder, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip


def test_failing_test_shows_what_its_processes_printed_and_all_end(tmp_path: Path) -> None:
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "test_user.py").write_text(USER)
    (tmp_path / "tests" / "mine.py").write_text(MINE)
    done = pytest_of_a_user(tmp_path, "tests")
    assert "1 passed" in done.stdout, done.stdout
    assert "2 failed" in done.stdout
    # The traceback ends at the user's own line and shows none of ours.
    assert re.search(
        r"seconds=0.5\)\nE +intellwheels_experiments.run.child_processes.WaitError: run_until: the condition",
        done.stdout,
    )
    assert done.stdout.count("intellwheels: agent-chair1 (running)") == 2
    assert "a word of mine" in done.stdout
    assert "intellwheels: server (exit 2)" in done.stdout
    assert "nowhere.xml" in done.stdout
    pids = [int(pid) for line in re.findall(r"PIDS ([\d ]+)", done.stdout) for pid in line.split()]
    assert len(pids) == 4
    assert [pid for pid in pids if Path(f"/proc/{pid}").exists()] == []


def test_pytest_that_does_not_use_it_loads_nothing_of_ours(tmp_path: Path) -> None:
    (tmp_path / "test_other.py").write_text(
        "import sys\n"
        "def test_other():\n"
        "    for heavy in ('zenoh', 'numpy', 'msgspec', 'lxml', 'intellwheels_schemas', 'intellwheels_agents'):\n"
        "        assert heavy not in sys.modules\n"
    )
    done = pytest_of_a_user(tmp_path)
    assert "1 passed" in done.stdout, done.stdout + done.stderr


def test_missing_extra_is_named(tmp_path: Path) -> None:
    (tmp_path / "test_user.py").write_text("def test_user(intellwheels):\n    intellwheels(floor='corner')\n")
    program = "import sys; sys.modules['numba'] = None; import pytest; sys.exit(pytest.main(sys.argv[1:]))"
    words = ["-p", "no:intellwheels", "-p", "intellwheels_experiments.testing.plugin", "-p", "no:cacheprovider"]
    done = subprocess.run(
        [sys.executable, "-c", program, *words, str(tmp_path)],
        cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False, env=dict(os.environ),
    )  # fmt: skip
    assert "pip install '.[server]'" in done.stdout, done.stdout + done.stderr
