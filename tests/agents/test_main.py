"""The command line `iw-agent`: its help, its refusals, and free names and places."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest

from intellwheels_agents import __main__ as command
from intellwheels_agents import minds
from intellwheels_agents.harness import NAME_TAKEN, PLACE_TAKEN
from intellwheels_schemas.messages import Position, Robot


def iw_agent(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "intellwheels_agents", *arguments],
        check=False,
        capture_output=True,
        text=True,
        timeout=30,
    )


@pytest.mark.process
def test_help_shows_examples_and_minds() -> None:
    shown = iw_agent("--help")
    assert shown.returncode == 0
    assert "iw-agent waypoints --name chair1" in shown.stdout
    assert (
        "aided, avoid, car, door, drive, driver, follow, joystick, navigate, person, seek, table, waypoints"
        in " ".join(shown.stdout.split())
    )


@pytest.mark.process
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["dance"],
            f"MIND: expected one of {', '.join(minds.names())} or a Python file",
        ),
        (["drive", "--name", "Chair 1"], "--name: expected a name"),
        (["drive", "--option", "speed"], "--option: expected NAME=VALUE, got 'speed'"),
        (["drive", "--option", "a=1", "--option", "a=2"], "--option: expected each name once, got 'a' twice"),
        (["drive", "--option", "MotorNose=1"], "option MotorNose: expected"),
        (["drive", "--robot", "tank"], "got 'tank'"),
        (["waypoints", "--option", "truth=maybe"], "option truth: expected one of true, false, got 'maybe'"),
        (["drive", "--world", "a/b"], "--world: expected a name"),
        (
            ["drive", "--role", "mind", "--option", "MotorNoise=0.1"],
            "option MotorNoise: expected an option of the mind for --role mind, got a robot field",
        ),
    ],
)
def test_wrong_usage_is_explained_and_exits_with_2(arguments: list[str], words: str) -> None:
    ended = iw_agent(*arguments)
    assert ended.returncode == 2
    assert words in ended.stderr
    assert ended.stdout == ""


@pytest.mark.process
def test_missing_simulator_is_reported_and_exits_with_1() -> None:
    ended = iw_agent("drive", "--connect", "tcp/127.0.0.1:1", "--retry-for", "0.5")
    assert ended.returncode == 1
    assert "nobody answers at tcp/127.0.0.1:1" in ended.stderr


def test_numbered_copies_take_the_next_free_name(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str | None, str | None]] = []

    def run_agent(robot: Robot, *_: object, **__: object) -> int:
        asked.append((robot.name, robot.place))
        return NAME_TAKEN if len(asked) < 3 else 0

    monkeypatch.setattr(command, "run_agent", run_agent)
    assert command.main(["drive", "--name", "chair", "--place", "start1", "--numbered"]) == 0
    assert asked == [("chair", "start1"), ("chair-2", "start1"), ("chair-3", "start1")]


@pytest.mark.parametrize(("free", "code"), [("spare2", 0), ("none", 1)])
def test_first_free_place_is_used(monkeypatch: pytest.MonkeyPatch, free: str, code: int) -> None:
    asked: list[str | None] = []

    def run_agent(robot: Robot, *_: object, **__: object) -> int:
        asked.append(robot.place)
        return 0 if robot.place == free else PLACE_TAKEN

    monkeypatch.setattr(command, "run_agent", run_agent)
    places = ["--place", "start1", "--place", "spare1", "--place", "spare2"]
    assert command.main(["drive", "--name", "chair", *places]) == code
    assert asked == ["start1", "spare1", "spare2"]


def test_a_chair_starts_at_coordinates(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[Position | None, str | None]] = []

    def run_agent(robot: Robot, *_: object, **__: object) -> int:
        asked.append((robot.position, robot.place))
        return 0

    monkeypatch.setattr(command, "run_agent", run_agent)
    assert command.main(["drive", "--name", "chair", "--position=-1.5,2,90"]) == 0
    assert asked == [(Position(x=-1.5, y=2.0, heading=math.pi / 2), None)]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--position", "1,2,0", "--place", "start1"], "--position: expected one of --place and --position, got both"),
        (["--position", "1,2,0", "--role", "mind"], "--position: expected a role with a body, got --role mind"),
        (["--robot", "table", "--role", "mind"], "--robot: expected a role with a body, got --role mind"),
    ],
)
def test_what_another_option_makes_meaningless_is_refused(
    words: list[str], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command.main(["drive", *words]) == 2
    assert capsys.readouterr().err == f"iw-agent: {text}\n"


def test_taken_name_exits_with_1(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "run_agent", lambda *_, **__: NAME_TAKEN)
    assert command.main(["drive", "--name", "chair"]) == 1
