"""The same small agent in each language keeps the contract, drives among the agents of Figure 6, and plays them."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import msgspec
import pytest

from intellwheels_maps import scene
from intellwheels_schemas.files import write_file
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Link, open_session, tokens
from intellwheels_schemas.messages import Cast, End, Hold, Timeout
from tests.e2e import languages
from tests.e2e.languages import Started
from tests.e2e.stage import DEADLINE, Stage, run

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
    words = ["figure6", "--listen", stage.endpoint, "--pace", "realtime", "--speed", "4", "--json", str(file)]
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
                # Its body would stay for the grace period, which may be the rest of this run.
                assert peer.ctl("delete", Agent=GUEST)["Code"] == "ok"
            run.wait(timeout=DEADLINE)
        finally:
            run.terminate()
            assert run.stdout is not None
            print(run.stdout.read().decode())
    assert run.returncode == 0
    result = json.loads(file.read_text())
    assert result["held"] is True
    assert result["contacts"] == 0


@pytest.mark.parametrize(
    "chairs",
    [("python", "python", "python"), pytest.param(("rust", "typescript", "python"), marks=pytest.mark.languages)],
    ids=["python", "mixed"],
)
def test_figure_6_is_played_by_chairs_in_these_languages(
    stage: Stage, chairs: tuple[str, str, str], tmp_path: Path
) -> None:
    makes: list[Started] = [getattr(languages, chair)() for chair in chairs]
    file = tmp_path / "result.json"
    figure6 = scene("figure6")
    with ExitStack() as stack:
        lines = [shlex.join(stack.enter_context(make(stage))) for make in makes]
        # One of them is in the scene, the others replace a member of it.
        cast = (Cast(name="chair1", place=figure6.cast[0].place, command=lines[0]), *figure6.cast[1:])
        short = msgspec.structs.replace(
            figure6, cast=cast, end=End(timeout=Timeout(seconds=5.0)), hold=Hold(contacts=0)
        )
        (tmp_path / "figure6.xml").write_text(write_file(short))
        words = [str(tmp_path / "figure6.xml"), "--listen", stage.endpoint, "--json", str(file)]
        words += ["--command", f"chair2={lines[1]}", "--command", f"chair3={lines[2]}"]
        done = run("intellwheels_experiments", *words)
    assert done.returncode == 0, done.stdout + done.stderr
    agents = {agent["name"]: agent for agent in json.loads(file.read_text())["agents"]}
    assert [agents[f"chair{number}"]["mind"] for number in (1, 2, 3)] == lines
    assert all(agents[f"chair{number}"]["path"] > 1.0 for number in (1, 2, 3))


def away(now: dict[str, Any], start: dict[str, Any]) -> float:
    return float(((now["X"] - start["X"]) ** 2 + (now["Y"] - start["Y"]) ** 2) ** 0.5)
