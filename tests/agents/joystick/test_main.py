"""The command line of `iw-joystick`."""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from intellwheels_agents.joystick import __main__ as command
from intellwheels_agents.joystick import main
from intellwheels_agents.joystick.input_state import InputState, KeyReader, Source
from intellwheels_agents.joystick.pygame_source import DeviceError
from intellwheels_agents.joystick.scan_keys import ScanKeys
from intellwheels_agents.joystick.script_source import ScriptSource
from intellwheels_agents.joystick.terminal_source import REPEAT_PAUSE
from intellwheels_schemas.link import Link


def test_the_options_reach_the_loop(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[tuple[str, str, bool]] = []

    def operate(
        where: Link, agent: str, source: Source, *, take: bool, stop: threading.Event, retry_for: float, latency: bool,
        before_line: Callable[[], None] | None,
    ) -> int:  # fmt: skip
        assert before_line is None
        assert isinstance(source, ScriptSource)
        assert source.state(0.0, None) == InputState(0.5, 0.0)
        asked.append((where.world, agent, take))
        return 0

    monkeypatch.setattr(command, "operate", operate)
    file = tmp_path / "drive.txt"
    file.write_text("0 0.5 0\n1 0 0\n")
    assert main(["chair1", "--source", "script", "--script", str(file), "--take", "--world", "lab"]) == 0
    assert asked == [("lab", "chair1", True)]


def test_wrong_usage_is_exit_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "drive.txt"
    file.write_text("nonsense\n")
    assert main(["chair1", "--source", "script", "--script", str(file)]) == 2
    assert "drive.txt:1: expected seconds, forward and turn" in capsys.readouterr().err
    assert main(["No Name", "--source", "words"]) == 2
    for words in (["chair1", "--source", "script"], ["chair1", "--script", "x"], ["chair1", "--turn", "2"]):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--hold", "3"], "--hold: expected with --source words or voice or scan or sip-puff, got auto"),
        (["--source", "gamepad", "--clock", "simulated"], "--clock: expected with --source script, got gamepad"),
        (["--source", "script"], "--script: expected a file with --source script, got none"),
        (["--source", "gamepad", "--script", "/dev/null"], "--script: expected with --source script, got gamepad"),
        (["--source", "script", "--script", "/dev/null", "--turn", "1"], "--turn: expected with --source auto or "),
    ],
)
def test_option_that_the_source_does_not_use_is_refused(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["chair1", *words])
    assert ended.value.code == 2
    assert said in capsys.readouterr().err


def test_a_missing_script_is_wrong_usage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["chair1", "--source", "script", "--script", str(tmp_path / "none.txt")])
    assert ended.value.code == 2
    assert re.search(r"--script: expected a file that exists, got .*none\.txt", capsys.readouterr().err)


@pytest.mark.parametrize("words", [["--source", "scan"], ["--source", "sip-puff", "--latch"]])
def test_keys_of_switches_come_from_the_terminal_without_a_display(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    monkeypatch.setattr(command, "has_display", lambda: False)
    reading, writing = os.pipe()
    monkeypatch.setattr("sys.stdin", SimpleNamespace(fileno=lambda: reading))
    assert main(["chair1", *words]) == 1
    assert "keys of the terminal: expected a terminal on standard input" in capsys.readouterr().err
    os.close(reading)
    os.close(writing)


def test_a_scan_in_a_terminal_knows_that_a_held_key_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    readers: list[KeyReader] = []

    def made(reader: KeyReader, *_: object) -> Source:
        readers.append(reader)
        raise DeviceError

    monkeypatch.setattr(command, "TerminalSource", made)
    monkeypatch.setattr(command, "KeyboardSource", lambda _, reader: made(reader))
    monkeypatch.setattr("sys.stdin", SimpleNamespace(fileno=lambda: 0))
    for where in ("terminal", "window"):
        assert main(["chair1", "--source", "scan", "--confirm", "--keys-from", where]) == 1
    pauses = [reader._scan.settings.pause for reader in readers if isinstance(reader, ScanKeys)]
    assert pauses == [REPEAT_PAUSE, 0.0]


@pytest.mark.parametrize(
    ("option", "value", "wanted"),
    [
        ("--forward", "much", r"expected a share in \[0, 1\], got 'much'"),
        ("--turn", "nan", r"expected a share in \[0, 1\], got 'nan'"),
        ("--hold", "long", r"expected seconds in \(0, 1e\+09\], got 'long'"),
    ],
)
def test_a_wrong_number_is_refused_with_its_range(
    option: str, value: str, wanted: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["chair1", option, value])
    assert re.search(f"iw-joystick: {option}: {wanted}", capsys.readouterr().err)


def test_a_script_that_is_not_text_is_wrong_usage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "drive.txt"
    file.write_bytes(b"\xff")
    assert main(["chair1", "--source", "script", "--script", str(file)]) == 2
    assert "expected UTF-8 text" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("gamepad", "pygame", "terminal", "display", "expected"),
    [
        (True, True, True, True, "gamepad"),
        (False, True, True, True, "keyboard"),
        (False, True, True, False, "terminal"),
        (False, True, False, False, "keyboard"),
        (False, False, True, True, "terminal"),
        (False, False, False, True, "keyboard"),
    ],
)
def test_the_automatic_source_is_the_best_there_is(
    monkeypatch: pytest.MonkeyPatch, gamepad: bool, pygame: bool, terminal: bool, display: bool, expected: str
) -> None:
    def has_gamepad() -> bool:
        if not pygame:
            raise DeviceError("pygame is not installed")
        return gamepad

    monkeypatch.setattr(command, "has_gamepad", has_gamepad)
    monkeypatch.setattr(command, "has_display", lambda: display)
    monkeypatch.setattr("sys.stdin", SimpleNamespace(isatty=lambda: terminal))
    assert command._automatic() == expected
