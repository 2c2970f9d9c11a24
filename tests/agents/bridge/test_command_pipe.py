from __future__ import annotations

import os
from pathlib import Path

from intellwheels_agents.bridge.command_pipe import CommandPipe


def test_lines_are_obeyed_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "ask"
    os.mkfifo(path)
    obeyed: list[str] = []
    refused: list[str] = []

    def obey(line: str) -> None:
        if line == "bad":
            raise ValueError(line)
        obeyed.append(line)

    pipe = CommandPipe(path, obey, refused.append)
    pipe.poll(0.0)
    with path.open("w") as writer:
        writer.write("one\nbad\ntw")
        writer.flush()
        pipe.poll(1.0)
        assert (obeyed, refused) == (["one"], ["bad"])
        writer.write("o\n")
    pipe.poll(1.0)
    assert obeyed == ["one", "two"]
