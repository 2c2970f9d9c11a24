"""The same small agent in each language keeps the contract, and drives among the agents of Figure 6."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from intellwheels_maps import scene
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Link, open_session, tokens
from tests.e2e import languages
from tests.e2e.languages import Started
from tests.e2e.stage import DEADLINE, Stage

GUEST = "guest"
START = 120.0
"""Seconds a simulator may take that compiles its kernels first."""


@pytest.fixture
def stage(tmp_path: Path) -> Iterator[Stage]:
    # The examples know the default world only.
    with Stage(tmp_path, "main") as stage:
        yield stage


@pytest.fixture(
    scope="module",
    params=[
        "python",
        pytest.param("rust", marks=pytest.mark.languages),
        pytest.param("typescript", marks=pytest.mark.languages),
    ],
)
def example(request: pytest.FixtureRequest) -> Started:
    make: Started = getattr(languages, request.param)()
    return make


def test_example_passes_the_check(stage: Stage, example: Started) -> None:
    with example(stage) as command:
        done = subprocess.run(
            [sys.executable, "-m", "intellwheels_experiments.conformance", "--listen", stage.endpoint, "--", *command],
            capture_output=True,
            text=True,
            timeout=120.0,
            check=False,
        )
    assert done.returncode == 0, done.stdout + done.stderr


def test_example_drives_in_figure_6_and_is_in_nobody_s_way(stage: Stage, example: Started, tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    words = ["figure6", "--listen", stage.endpoint, "--pace", "realtime", "--speed", "8", "--json", str(file)]
    with subprocess.Popen(
        [sys.executable, "-m", "intellwheels_experiments", *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as run:
        try:
            session = open_session(Link("main", connect=(stage.endpoint,)), threading.Event(), timeout=START)
            assert session is not None
            with session:
                # Its token comes when all else is there.
                stage.wait(lambda: tokens(session, Keys("main").alive) or None, "token of the simulator", START)
            with stage.peer() as peer, example(stage) as command:
                for cast in scene("figure6").cast:
                    peer.event("joined", cast.name)
                with subprocess.Popen([word.replace("{name}", GUEST) for word in command]) as guest:
                    try:
                        peer.event("joined", GUEST)
                        start = peer.entities()[GUEST]
                        peer.entity(GUEST, lambda now: away(now, start) > 0.5)
                    finally:
                        guest.kill()
            run.wait(timeout=DEADLINE)
        finally:
            run.terminate()
            assert run.stdout is not None
            print(run.stdout.read().decode())
    assert run.returncode == 0
    result = json.loads(file.read_text())
    assert result["held"] is True
    assert result["contacts"] == 0


def away(now: dict[str, Any], start: dict[str, Any]) -> float:
    return float(((now["X"] - start["X"]) ** 2 + (now["Y"] - start["Y"]) ** 2) ** 0.5)
