"""Crews as processes: they come and go, and what one of them does wrong disturbs no other."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from typing import Any

import pytest

from tests.e2e.stage import DEADLINE, Peer, Stage, run

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Stage, Peer]]:
    with Stage(tmp_path_factory.mktemp("crews"), "crews") as stage:
        stage.server("--map", "ward", "--pace", "realtime", "--log", str(stage.folder / "run.jsonl"))
        crew(stage, "stay", 3)
        with stage.peer() as peer:
            yield stage, peer


def crew(stage: Stage, name: str, count: int, *words: str, mind: str = "avoid") -> str:
    """Start a crew and wait until its last agent joined."""
    child = stage.start(
        name, "intellwheels_agents", mind, "--count", str(count), "--name", name,
        "--connect", stage.endpoint, "--world", stage.world, *words,
    )  # fmt: skip
    stage.wait(
        lambda: stage.log(child).count("joined agent=") >= count or None, f"{count} agents of {name}", unless=child
    )
    return child


def names(peer: Peer, start: str) -> set[str]:
    return {name for name in peer.entities() if name.startswith(start)}


def test_killed_crew_is_lost_and_another_one_goes_on(world: tuple[Stage, Peer]) -> None:
    stage, peer = world
    child = crew(stage, "gone", 3, "--encoding", "xml")
    assert names(peer, "gone") == {"gone1", "gone2", "gone3"}
    stage.signal(child, signal.SIGKILL)
    stage.exit(child)
    for name in ("gone1", "gone2", "gone3"):
        peer.event("lost", name)
        peer.event("left", name)
    assert names(peer, "gone") == set()
    assert names(peer, "stay") == {"stay1", "stay2", "stay3"}
    # The name is free again.
    child = crew(stage, "gone", 2)
    stage.signal(child, signal.SIGTERM)
    assert stage.exit(child) == 0
    assert stage.log(child).count("left agent=") == 2


def test_wrong_messages_have_named_errors_and_disturb_nobody(world: tuple[Stage, Peer]) -> None:
    stage, peer = world
    errors = peer.hear("crew/stay/error")
    moving = peer.hear("crew/stay/measures")
    strange: list[dict[str, Any]] = [
        {"Crew": "stay", "Actions": [{"Agent": "stay1", "LeftMotor": 1.0}]},
        {"Crew": "stay", "Actions": [{"Agent": "stay1", "Session": "0" * 16, "LeftMotor": 1.0}]},
        {"Crew": "stay", "Actions": [{"Agent": "operator", "Session": "0" * 16}]},
        {"Crew": "other", "Actions": []},
    ]
    for payload in strange:
        peer.put("crew/stay/actions", payload)
    peer.put("crew/stay/actions", b"?")
    stage.wait(lambda: len(errors) >= 5 or None, "five errors")
    assert [json.loads(data)["Code"] for _, data in errors] == ["field", "session", "not-joined", "value", "malformed"]
    moving.clear()
    stage.wait(lambda: len(moving) >= 5 or None, "measures of the crew")
    assert names(peer, "stay") == {"stay1", "stay2", "stay3"}


def test_second_process_with_the_name_of_a_crew_is_refused(world: tuple[Stage, Peer]) -> None:
    stage, peer = world
    words = ("--connect", stage.endpoint, "--world", stage.world, "--retry-for", f"{DEADLINE:g}")
    done = run("intellwheels_agents", "avoid", "--count", "2", "--name", "other", "--crew", "stay", *words)
    assert done.returncode == 1
    assert "already-here" in done.stderr
    assert names(peer, "other") == set()


def test_agent_of_a_crew_is_found_like_any_other(world: tuple[Stage, Peer]) -> None:
    stage, _ = world
    words = ("--connect", stage.endpoint, "--world", stage.world)
    assert run("intellwheels_schemas.present", "--agent", "stay1", *words).returncode == 0
    assert run("intellwheels_schemas.present", "--agent", "nobody", *words).returncode == 1


def test_crew_joins_again_when_its_simulator_was_replaced_and_its_log_runs_again(world: tuple[Stage, Peer]) -> None:
    stage, _ = world
    child = stage.simulator
    stage.signal(child, signal.SIGTERM)
    assert stage.exit(child) == 0
    done = run("intellwheels_server", "--resimulate", str(stage.folder / "run.jsonl"))
    assert done.returncode == 0, done.stdout + done.stderr
    again = stage.server("--map", "ward", "--pace", "realtime")
    stage.wait(lambda: stage.log(again).count("joined agent=stay") >= 3 or None, "three agents again")
