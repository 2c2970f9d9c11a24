"""The command says what is wrong before it starts anything."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import pytest

from intellwheels_experiments.__main__ import main
from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_schemas.link import START_ONE
from tests.every_case import every_case
from tests.experiments.scenes import write_scene

DEADLINE = 120.0
"""Seconds for a simulator to start on a busy machine."""


def test_unknown_scene_is_wrong_usage_and_the_known_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["nowhere"]) == 2
    assert "figure6" in capsys.readouterr().err


@every_case(
    ("words", "error"),
    [
        (["--row", "x"], "--row: expected with --seeds or --branch, got a single run"),
        (["--jobs", "2"], "--jobs: expected with --seeds or --branch, got a single run"),
        (["--out", "x"], "--out: expected with --seeds or --branch, got a single run"),
        (["--at", "5"], "--at: expected with --branch, got none"),
        (["--seeds", "2", "--at", "5"], "--at: expected with --branch, got none"),
        (["--seeds", "2", "--view"], "--view: expected with a single run"),
        (["--seeds", "2", "--pace", "free"], "--pace: expected with a single run"),
        (["--seeds", "2", "--speed", "3"], "--speed: expected with a single run"),
        (["--seeds", "2", "--seed", "3"], "--seed: expected with a single run"),
        (["--seeds", "2", "--json", "x"], "--json: expected with a single run"),
        (["--seeds", "2", "--connect", "tcp/127.0.0.1:1"], "--connect: expected with a single run"),
        (["--branch", "/dev/null", "--log", "y"], "--log: expected with a single run"),
        (["--branch", "/dev/null", "--seeds", "2"], "--seeds: expected without --branch"),
        (["--branch", "/dev/null", "--row", "a", "--row", "b"], "--row: expected one row with --branch"),
        (["--view-port", "9000"], "--view-port: expected with --view, got none"),
        (["--dark"], "--dark: expected with --view, got none"),
        (["--speed", "5"], "--speed: expected with --pace realtime, got pace lockstep"),
        (
            ["--view", "--view-port", "0", "--pace", "free", "--speed", "5"],
            "--speed: expected with --pace realtime, got",
        ),
        (["--mind", "nobody=drive"], "--mind: expected AGENT=MIND, with an agent of the scene (chair1, "),
        (["--mind", "chair1"], "--mind: expected AGENT=MIND"),
        (["--command", "char1=./mine"], "--command: expected AGENT=COMMAND, with an agent of the scene (chair1, "),
        (["--command", "chair1=./mine {nam}"], "--command: chair1: expected the placeholders {name}, "),
        (["--command", "chair1=pythn x"], "agent 'chair1': Command: expected a program, got 'pythn', which does not"),
        (["--seeds", "1", "--command", "chair1=pythn x"], "agent 'chair1': Command: expected a program, got 'pythn'"),
        (["--option", "chair1.speed"], "--option: expected AGENT.NAME=VALUE"),
        (["--json", "nowhere/result.json"], "--json: expected a folder that exists, got nowhere"),
        (["--log", "nowhere/run.jsonl"], "--log: expected a folder that exists, got nowhere"),
        (["--log", "/"], "--log: expected a file, got the folder /"),
        (["--json", __file__], f"--json: expected a new file, got {__file__}: the file exists; --overwrite"),
        (["--log", __file__], f"--log: expected a new file, got {__file__}: the file exists; --overwrite"),
        (["--branch", "/dev/null", "--out", "/etc"], "--out: expected an empty folder, or --overwrite to replace"),
        (["--overwrite"], "--overwrite: expected with --json, --log or --branch, got none of them"),
        (["--seeds", "2", "--overwrite"], "--overwrite: expected with a single run or --branch, got a batch"),
        (["--logs", "/dev/null/x"], "--logs: expected a folder, got the file /dev/null"),
        (["--seeds", "2", "--out", "/dev/null"], "--out: expected a folder, got the file /dev/null"),
    ],
)
def test_nothing_given_is_ignored_and_outputs_are_checked_first(
    words: list[str], error: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["figure6", *words]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith(f"iw-run: {error}")
    assert printed.err.count("\n") == 1
    assert printed.out == ""


def test_log_of_the_laboratory_is_not_replaced_either(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run-lab.jsonl").write_text("an old log")
    assert main(["lab", "--log", str(tmp_path / "run.jsonl")]) == 2
    assert "run-lab.jsonl: the file exists; --overwrite replaces it" in capsys.readouterr().err


def test_unknown_row_is_refused_with_the_nearest_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["table1", "--seeds", "1", "--row", "real-auto"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("iw-run: --row: expected a row (real-")
    assert error.endswith("got 'real-auto'; did you mean 'real-autonomous'?\n")


@pytest.mark.parametrize(
    "words", [["figure6", "--world", "A b"], ["figure6", "--speed", "0"], ["figure6", "--pace", "x"]]
)
def test_wrong_option_is_wrong_usage(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert words[1] in capsys.readouterr().err


@pytest.mark.process
def test_a_router_that_nobody_runs_is_waited_for_in_words(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    command = [sys.executable, "-m", "intellwheels_experiments", "figure6", "--connect", endpoint]
    with subprocess.Popen(
        [*command, "--logs", str(tmp_path / "logs")], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as child:
        assert child.stderr is not None
        watchdog = threading.Timer(DEADLINE, child.kill)
        watchdog.start()
        lines = iter(child.stderr.readline, "")
        found = next((line for line in lines if line.startswith("waiting ")), None)
        child.terminate()
        rest = child.stderr.read()
        watchdog.cancel()
    assert found == f"waiting why='nobody answers at {endpoint}; {START_ONE}'\n"
    assert child.returncode == 1
    assert "Traceback" not in rest


def test_program_that_asks_for_an_endpoint_needs_more_than_a_configuration(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "router.json5"
    config.write_text("{}")
    assert main(["figure6", "--config", str(config), "--command", "chair1=python {endpoint}"]) == 2
    expected = "iw-run: agent 'chair1': Command: expected --connect with an endpoint for {endpoint}, got none"
    assert expected in capsys.readouterr().err


@pytest.mark.process
def test_an_interrupted_batch_says_how_to_resume_and_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stopped = threading.Event()
    stopped.set()
    monkeypatch.setattr("intellwheels_experiments.__main__.stop_on_signals", lambda: stopped)
    batch = [str(write_scene(tmp_path)), "--seeds", "2", "--out", str(tmp_path / "out")]
    for more, total in (([], 4), (["--part", "1/2"], 2)):
        assert main([*batch, *more]) == 1
        printed = capsys.readouterr()
        said = f"iw-run: interrupted: 0 of {total} runs are done; run the same command again to resume\n"
        assert printed.err.endswith(said)
        assert "as-expected" not in printed.out


@pytest.mark.process
def test_a_merge_without_all_parts_says_what_is_missing_and_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stopped = threading.Event()
    stopped.set()
    batch = [str(write_scene(tmp_path)), "--seeds", "2"]
    with monkeypatch.context() as patch:
        patch.setattr("intellwheels_experiments.__main__.stop_on_signals", lambda: stopped)
        main([*batch, "--part", "1/2", "--out", str(tmp_path / "part1")])
    capsys.readouterr()
    assert main([*batch, "--merge", str(tmp_path / "part1"), "--out", str(tmp_path / "all")]) == 1
    printed = capsys.readouterr()
    assert printed.out.startswith(f"merged runs=0 folders=1 out={tmp_path / 'all'}\n")
    assert printed.err.startswith("iw-run: incomplete: 4 of 4 runs are missing; merge the folders of all parts")


def test_an_interruption_before_the_start_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(_given: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("intellwheels_experiments.__main__.check_connection", interrupt)
    assert main(["figure6"]) == 130
    assert capsys.readouterr().err == "iw-run: interrupted\n"
