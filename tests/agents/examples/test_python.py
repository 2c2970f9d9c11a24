"""The Python agent without the harness, as a process, against a real simulator."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.e2e.stage import DEADLINE, Stage

pytestmark = pytest.mark.process

EXAMPLE = Path(__file__).parents[3] / "agents" / "examples" / "other_languages" / "python" / "avoid.py"


@pytest.fixture
def stage(tmp_path: Path) -> Iterator[Stage]:
    with Stage(tmp_path, "main") as stage:
        yield stage


def start(stage: Stage, name: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, str(EXAMPLE), name, stage.endpoint], stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def end(child: subprocess.Popen[str]) -> None:
    child.kill()
    child.communicate(timeout=DEADLINE)


def test_chair_drives_through_a_corridor_without_contact(stage: Stage) -> None:
    stage.server("--map", "corner", "--pace", "lockstep", "--expect", "chair1")
    child = start(stage, "chair1")
    try:
        with stage.peer() as peer:
            peer.tick(600)  # half a minute
            entity = peer.entities()["chair1"]
            assert entity["X"] > 8.0
            assert entity.get("Contacts", 0) == 0
    finally:
        end(child)


def test_refusal_is_shown_with_the_simulators_text(stage: Stage) -> None:
    stage.server("--map", "corner", "--pace", "realtime")
    stage.agent("chair1", "drive")
    child = start(stage, "chair1")
    try:
        _, words = child.communicate(timeout=DEADLINE)
        assert child.returncode == 1
        assert "agent 'chair1' is already here" in words
    finally:
        end(child)
