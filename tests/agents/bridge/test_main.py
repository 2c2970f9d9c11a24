from __future__ import annotations

import subprocess
import sys

import pytest

pytestmark = pytest.mark.process


def iw_bridge(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "intellwheels_agents.bridge", *words],
        check=False,
        capture_output=True,
        text=True,
        timeout=30,
    )


def test_help_shows_examples() -> None:
    shown = iw_bridge("--help")
    assert shown.returncode == 0
    assert "iw-bridge serial --port /dev/ttyUSB0 --name chair1" in shown.stdout


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["serial", "--name", "chair1"], "--port: expected one with the driver serial"),
        (["world", "--name", "chair1", "--port", "x"], "--port: expected one with the driver serial"),
        (["world", "--name", "Chair 1"], "--name: expected a name"),
        (["world", "--name", "chair1", "--robot", "tank"], "got 'tank'"),
        (["world", "--name", "chair1", "--chair", "table"], "--chair: expected a robot with encoders"),
        (["world", "--name", "chair1", "--chair-option", "left=1"], "--chair-option: expected each field"),
        (["world", "--name", "chair1", "--wheel-ratio", "3"], "--wheel-ratio: expected a ratio in [0.5, 2], got '3'"),
        (["world", "--name", "chair1", "--loss", "2"], "--loss: expected a share in [0, 1], got '2'"),
        (["world", "--name", "chair1", "--delay", "-1"], "--delay: expected a number from 0 on"),
        (["world", "--name", "chair1", "--lab-world", "a/b"], "--lab-world: expected a name"),
    ],
)
def test_wrong_usage_is_refused_in_words_with_exit_2(words: list[str], expected: str) -> None:
    ended = iw_bridge(*words)
    assert ended.returncode == 2
    assert expected in ended.stderr


@pytest.mark.parametrize(
    "driver", [["world", "--lab-connect", "tcp/127.0.0.1:1"], ["serial", "--port", "/nowhere/tty"]]
)
def test_a_chair_that_is_not_there_is_given_up_with_exit_1(driver: list[str]) -> None:
    ended = iw_bridge(*driver, "--name", "chair1", "--retry-for", "0.5", "--connect", "tcp/127.0.0.1:1")
    assert ended.returncode == 1
    assert "bridged agent=chair1 poses=0" in ended.stdout
