"""What options must hold together."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_agents.options import OptionError
from intellwheels_agents.record_gateway import record_options
from intellwheels_agents.record_gateway.__main__ import parser
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.output_paths import open_output


@pytest.mark.parametrize(("words", "text"), [
    ([], "FILE.mcap: expected a file, --ros2 or --live, got none of them"),
    (["x.mcap", "--storage", "mcap"], "--storage: expected with --ros2, got none"),
    (["--ros2", "there"], "--ros2: expected a folder that does not exist, got there"),
    (["--ros2", "bag", "--rotate", "5"], "--rotate: expected with a FILE.mcap, got none"),
    (["--live", "--rotate", "5"], "--rotate: expected with a FILE.mcap, got none"),
    (["x.mcap", "--port", "5"], "--port: expected with --live, got none"),
    (["x.mcap", "--take"], "--take: expected with --live, got none"),
    (["--live", "--from", "LOG"], "--from: expected with a FILE.mcap or --ros2 and without --live"),
    (["x.mcap", "--from", "LOG", "--world", "lab"], "--from: expected without a world and a connection"),
    (["x.mcap", "--from", "LOG", "--identity", "LOG"], "--from: expected without a world and a connection"),
    (["x.mcap", "--from", "LOG", "--retry-for", "5"], "--retry-for: expected without --from"),
])  # fmt: skip
def test_options_without_a_meaning_are_refused(
    words: list[str], text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("LOG").touch()
    Path("there").mkdir()
    with pytest.raises(OptionError, match=text):
        record_options.check_together(parser().parse_args(words))


@pytest.mark.parametrize("name", ["run.mcap", "run-2.mcap", "run-13.mcap"])
def test_recording_that_exists_is_not_replaced(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).write_text("a recording")
    with pytest.raises(WireError, match=f"FILE.mcap: expected a new file, got {name}: the file exists; --overwrite"):
        record_options.check_together(parser().parse_args(["run.mcap"]))
    record_options.check_together(parser().parse_args(["run.mcap", "--overwrite"]))
    record_options.check_together(parser().parse_args(["run-1.mcap"]))


def test_file_that_another_recorder_writes_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with open_output(Path("run.mcap")), pytest.raises(WireError, match="another process is writing this file"):
        record_options.check_together(parser().parse_args(["run.mcap", "--overwrite"]))


def test_overwrite_without_a_file_is_refused() -> None:
    with pytest.raises(OptionError, match="--overwrite: expected with a FILE"):
        record_options.check_together(parser().parse_args(["--live", "--overwrite"]))
