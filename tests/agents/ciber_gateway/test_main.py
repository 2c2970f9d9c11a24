"""The command `iw-ciber` without a world."""

from __future__ import annotations

import threading

import pytest

from intellwheels_agents import ciber_gateway
from intellwheels_agents.ciber_gateway import __main__ as command
from tests.e2e.stage import free_port


@pytest.mark.process
def test_without_a_world_it_gives_up_in_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "stop_on_signals", lambda *_: threading.Event())
    words = ["--port", "0", "--retry-for", "0.2", "--connect", f"tcp/127.0.0.1:{free_port()}"]
    assert ciber_gateway.main(words) == 1
    assert capsys.readouterr().err.rpartition("iw-ciber: ")[2].startswith("nobody answers at tcp/127.0.0.1:")


def test_a_wrong_field_is_wrong_usage(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(command, "stop_on_signals", lambda *_: threading.Event())
    assert command.main(["--option", "Wings.Length=1"]) == 2
    assert "iw-ciber: --option: option Wings.Length: expected a kind of sensor" in capsys.readouterr().err
