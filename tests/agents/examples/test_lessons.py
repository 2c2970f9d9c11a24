"""The course in `agents/examples`: every lesson runs with the commands in its head, as real processes."""

from __future__ import annotations

import json
import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from intellwheels_experiments.run.cast_changes import with_changes
from intellwheels_experiments.run.foreign_program import check_programs
from intellwheels_experiments.run_parser import parser
from intellwheels_maps import scene
from intellwheels_schemas.command_line import words_of
from tests.commands import MODULES
from tests.e2e.stage import Stage

pytestmark = pytest.mark.process

EXAMPLES = Path(__file__).parents[3] / "agents" / "examples"
LESSONS = sorted(path for path in EXAMPLES.iterdir() if path.name[0].isdigit() and path.is_file())
RUN = 300.0
"""Seconds of wall time that a lesson's whole run may take on a loaded machine."""
FASTER = ("--speed", "2")
"""For lessons whose chairs drive far."""
PROGRAMS = {
    **MODULES,
    # The checkout may be newer than the installed entry point of the plug-in.
    "pytest": "pytest -p no:intellwheels -p intellwheels_experiments.testing.plugin -p no:cacheprovider",
}


def lesson(number: int) -> Path:
    (path,) = [path for path in LESSONS if path.name.startswith(f"{number:02}_")]
    return path


def commands(number: int) -> list[str]:
    """Return the commands in the head of a lesson."""
    text = lesson(number).read_text(encoding="utf-8")
    return re.findall(r"(?:^ {4}|^# {5}|<\?command )((?:iw-|pytest |python |sh ).*?)(?:\?>)?$", text, re.MULTILINE)


@pytest.fixture
def stage(tmp_path: Path) -> Iterator[Stage]:
    # The shell script of lesson 7 leaves the world's name at its default.
    with Stage(tmp_path, "main") as stage:
        programs = tmp_path / "bin"
        programs.mkdir()
        for name, module in {**PROGRAMS, "python": ""}.items():
            words = f"-m {module}" if module else ""
            (programs / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {words} "$@"\n')
            (programs / name).chmod(0o755)
        yield stage


def start(stage: Stage, child: str, command: str, *more: str) -> str:
    """Start a command in the folder of the course, as it stands, with more words at its end."""
    line = " ".join([f"cd '{EXAMPLES}' && exec", command, *(f"'{word}'" for word in more)])
    path = f"{stage.folder / 'bin'}:/usr/bin:/bin"
    return stage.launch(child, lambda _: ["sh", "-c", line], {"PATH": path})


def start_all(stage: Stage, number: int, *more: str) -> None:
    """Start the simulator, with more words, and the agents of a lesson, and wait until all have joined."""
    server, *agents = commands(number)
    stage.simulator = start(stage, "server", server, "--listen", stage.endpoint, *more)
    stage.line(stage.simulator, "ready")
    for index, command in enumerate(agents):
        stage.line(start(stage, f"agent{index}", command, "--connect", stage.endpoint), "joined")


@pytest.mark.parametrize("path", LESSONS, ids=[path.name for path in LESSONS])
def test_lesson_is_short_and_listed(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) < 60
    assert f"[{path.name}]({path.name})" in (EXAMPLES / "README.md").read_text(encoding="utf-8")


def test_every_lesson_is_there() -> None:
    assert [int(path.name[:2]) for path in LESSONS] == [1, 2, 3, 4, 5, 6, 7, 8]


def test_lesson_1_drives_and_stops(stage: Stage) -> None:
    start_all(stage, 1)
    with stage.peer() as peer:
        start = peer.entities()["chair1"]["X"]
        peer.entity("chair1", lambda now: now["X"] > start + 0.5)
        peer.entity("chair1", lambda now: abs(now.get("Speed", 0.0)) < 0.01)


def test_lesson_2_turns_at_a_wall(stage: Stage) -> None:
    start_all(stage, 2, *FASTER)
    with stage.peer() as peer:
        peer.entity("chair1", lambda now: now.get("Mode") == "turning")
        peer.entity("chair1", lambda now: now["Heading"] > 1.4)
        assert peer.entities()["chair1"].get("Contacts", 0) == 0


def test_lesson_3_opens_the_door_and_drives_through(stage: Stage) -> None:
    start_all(stage, 3, *FASTER)
    with stage.peer() as peer:
        peer.entity("chair1", lambda now: now.get("Mode") == "asking")
        peer.entity("chair1", lambda now: now["X"] > 7.0)
        assert peer.entities()["chair1"].get("Contacts", 0) == 0


def test_lesson_4_passes(stage: Stage) -> None:
    (command,) = commands(4)
    # A student has pytest alone, without the plug-ins that the settings of the project need.
    child = start(stage, "pytest", command, "-p", "no:xdist", "-p", "no:randomly", "-W", "error")
    assert stage.exit(child, RUN) == 0, stage.report()
    assert "3 passed" in stage.log(child)


def test_lesson_5_passes(stage: Stage) -> None:
    command, view = commands(5)
    assert view == f"{command} --view"
    child = start(stage, "run", command, "--json", str(stage.folder / "result.json"))
    assert stage.exit(child, RUN) == 0, stage.report()
    assert json.loads((stage.folder / "result.json").read_text())["held"] is True


@pytest.mark.parametrize("seeds", [1, pytest.param(3, marks=pytest.mark.soak)])
def test_lesson_6_writes_a_report_in_which_every_run_arrived(stage: Stage, seeds: int) -> None:
    (command,) = commands(6)
    assert "--seeds 3 " in command
    folder = stage.folder / "lesson6"
    child = start(stage, "run", command, "--seeds", str(seeds), "--out", str(folder))
    assert stage.exit(child, RUN) == 0, stage.report()
    assert (folder / "report.html").is_file()
    assert len(list(folder.glob("runs/*/*"))) == 4 * seeds


def test_lesson_7_moves_the_chair_and_stops_it(stage: Stage) -> None:
    child = start(stage, "script", commands(7)[0], stage.endpoint)
    stage.line(child, "moving")
    stage.line(child, "stopped")


def test_lesson_8_drives_and_turns_with_zenoh_alone(stage: Stage) -> None:
    server, agent, *_ = commands(8)
    stage.simulator = start(stage, "server", server, "--listen", stage.endpoint, *FASTER)
    stage.line(stage.simulator, "ready")
    start(stage, "agent", agent, stage.endpoint)
    with stage.peer() as peer:
        begin = peer.entity("chair1", lambda _: True)
        peer.entity("chair1", lambda now: abs(now["X"] - begin["X"]) + abs(now["Y"] - begin["Y"]) > 0.5)
        peer.entity("chair1", lambda now: abs(now["Heading"] - begin["Heading"]) > 0.5)
        assert peer.entities()["chair1"].get("Contacts", 0) == 0


def test_lesson_8_shows_how_its_program_plays_a_chair_of_a_scene() -> None:
    name, *words = shlex.split(commands(8)[2])
    options = parser().parse_args(words)
    assert (name, options.view) == ("iw-run", True)
    changed = with_changes(scene(options.scene), options.mind, options.option, options.command)
    check_programs(changed.cast, EXAMPLES)
    (chair,) = [cast for cast in changed.cast if cast.command is not None]
    # The program knows its name by itself.
    assert f"join/{chair.name}" in lesson(8).read_text(encoding="utf-8")
    assert (EXAMPLES / words_of(chair.command or "", "Command")[1]).is_file()


def test_lesson_8_meets_every_point_of_the_contract(stage: Stage) -> None:
    child = start(stage, "check", commands(8)[3])
    assert stage.exit(child, RUN) == 0, stage.report()
    assert "16 of 16 points passed" in stage.log(child)


def test_lesson_8_says_that_no_simulator_answers(stage: Stage) -> None:
    child = start(stage, "agent", commands(8)[1], stage.endpoint)
    assert stage.exit(child, RUN) == 1
    assert "no simulator answers" in stage.log(child)
    assert "Traceback" not in stage.log(child)
