from __future__ import annotations

import sys
from pathlib import Path

import pytest

from intellwheels_server.service.console import log_line, print_line


def test_lines_for_scripts_and_for_people_go_to_different_streams(capsys: pytest.CaptureFixture[str]) -> None:
    print_line("ready")
    log_line("waiting")
    assert capsys.readouterr() == ("ready\n", "waiting\n")


def test_line_is_written_in_one_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    pieces: list[str] = []

    class Stream:
        def write(self, text: str) -> None:
            pieces.append(text)

        def flush(self) -> None:
            pass

    monkeypatch.setattr(sys, "stderr", Stream())
    log_line("waiting")
    assert pieces == ["waiting\n"]


def test_closed_stream_does_not_stop_the_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    closed = (tmp_path / "closed").open("w")
    closed.close()
    monkeypatch.setattr(sys, "stdout", closed)
    print_line("ready")
