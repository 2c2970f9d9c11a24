from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from intellwheels_maps import floor
from intellwheels_server.__main__ import PLAY_NAME_LENGTH, main, written_by
from intellwheels_server.log.input_log import Log
from intellwheels_server.world import Setup
from tests.server.log.test_branch import written


def outcome(*words: str) -> int | str | None:
    try:
        return main(list(words))
    except SystemExit as exit_:
        return exit_.code


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--map", "ward"], "--map: expected a live run, got --play"),
        (["--pace", "lockstep"], "--pace: expected a live run, got --play"),
        (["--open-loop"], "--open-loop: expected a live run, got --play"),
        (["--say-loss", "0.5"], "--say-loss: expected a live run, got --play"),
        (["--grace", "3"], "--grace: expected a live run, got --play"),
        (["--log", "other"], "--log: expected a live run, got --play"),
        (["--world", "No Name"], "--world: expected a name"),
    ],
)
def test_playback_refuses_options_of_a_live_run(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log"
    Log(path, Setup(floor=floor("room")), "0" * 16).close()
    assert outcome("--play", str(path), *words) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--resimulate", "/dev/null", "--map", "ward"], "--map: expected a live run, got --resimulate"),
        (["--resimulate", "/dev/null", "--play", "/dev/null"], "--play: expected a live run, got --resimulate"),
        (["--resimulate", "/dev/null", "--world", "lab"], "--world: expected a live run, got --resimulate"),
        (["--at", "7"], "--at: expected with --branch, got none"),
    ],
)
def test_option_that_would_be_ignored_is_refused(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome(*words) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--period", "0.1"], ["--map", "ward"], ["--say-limit", "9"], ["--no-say-walls"]])
def test_branch_refuses_what_its_log_decides(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written(tmp_path / "log")
    assert outcome("--branch", str(tmp_path / "log"), "--pace", "lockstep", *words) == 2
    assert "none of --scene, --map, --seed, --period" in capsys.readouterr().err


def test_missing_or_invalid_log_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome("--play", str(tmp_path / "none")) == 2
    assert "--play: expected a file that exists, got" in capsys.readouterr().err
    (tmp_path / "text").write_text("hello\n")
    assert outcome("--play", str(tmp_path / "text")) == 1
    assert "text:1: expected the header of an input log" in capsys.readouterr().err


def test_file_that_could_not_be_written_is_named_with_its_option() -> None:
    given = argparse.Namespace(log=Path("run.jsonl"), runs=Path("runs"))
    assert written_by(given, OSError(28, "No space", "run.jsonl")) == "--log run.jsonl"
    assert written_by(given, OSError(28, "No space", "runs/1/input.jsonl")) == "--runs runs/1/input.jsonl"
    assert (
        written_by(argparse.Namespace(log=Path("run.jsonl"), runs=None), OSError(28, "No space")) == "--log run.jsonl"
    )


def test_name_of_a_playback_fits() -> None:
    assert PLAY_NAME_LENGTH + len("-play") == 32


def test_log_of_reported_poses_needs_a_playback_and_must_exist(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome("--reported", "/dev/null") == 2
    assert "--reported: expected with --play, got none" in capsys.readouterr().err
    path = tmp_path / "log"
    Log(path, Setup(floor=floor("room")), "0" * 16).close()
    assert outcome("--play", str(path), "--reported", str(tmp_path / "none")) == 2
    assert "--reported: expected a file that exists, got" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--log", "none/run.jsonl"], "--log: expected a folder that exists, got "),
        (["--log", "."], "--log: expected a file, got the folder "),
        (["--log", "log"], "--log: expected a new file, got log: the file exists; --overwrite replaces it"),
        (["--resimulate", "log", "--trace", "old"], "--trace: expected a new file, got old: the file exists"),
        (["--runs", "file"], "--runs: expected a folder, got the file "),
        (["--resimulate", "log", "--trace", "none/trace.jsonl"], "--trace: expected a folder that exists, got "),
        (["--resimulate", "log", "--trace", "log"], "--trace: expected another file than the log that is read, got "),
        (["--branch", "log", "--log", "log"], "--log: expected another file than the log that is read, got "),
    ],
)
def test_output_that_cannot_be_written_is_refused_before_anything_starts(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()
    Path("old").write_text("a trace")
    Log(Path("log"), Setup(floor=floor("room")), "0" * 16).close()
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert outcome(*words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"iw-server: {said}")
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_trace_is_replaced_if_that_is_wanted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written(tmp_path / "log")
    trace = tmp_path / "trace"
    trace.write_text("old" * 1_000_000)
    assert outcome("--resimulate", str(tmp_path / "log"), "--trace", str(trace), "--overwrite") == 0
    assert "old" not in trace.read_text()
    assert outcome("--overwrite") == 2
    assert "--overwrite: expected with --log or --trace, got none" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--prove"], ["--prove", "--resimulate", "/dev/null", "--trace", "trace"]])
def test_proof_needs_a_log_and_is_all_there_is(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert outcome(*words) == 2
    assert "--prove: expected with --resimulate and without --trace" in capsys.readouterr().err


def test_playback_takes_an_identity(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log").write_bytes(b"")
    (tmp_path / "x.iwid").write_bytes(b"")
    # The log is the first thing that is wrong, and not the option.
    assert outcome("--play", str(tmp_path / "log"), "--identity", str(tmp_path / "x.iwid")) == 1
    assert "--identity" not in capsys.readouterr().err


def test_trace_of_a_cut_log_is_written_and_the_cut_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written(tmp_path / "log")
    (tmp_path / "log").write_bytes((tmp_path / "log").read_bytes()[:-50])
    assert outcome("--resimulate", str(tmp_path / "log"), "--trace", str(tmp_path / "trace")) == 0
    assert "the log is truncated after tick 6" in capsys.readouterr().err
    assert (tmp_path / "trace").read_bytes().count(b"\n") == 7
