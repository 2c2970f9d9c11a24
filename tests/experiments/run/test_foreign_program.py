"""The program of a Command is checked before anything starts, and started where and how the scene says."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_experiments.run.foreign_program import check_programs, launch_agent
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Cast


def chair(command: str, folder: str | None = None) -> list[Cast]:
    return [Cast(name="chair1", command=command, folder=folder)]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "mine").write_text("#!/bin/sh\n")
    (tmp_path / "mine").chmod(0o755)
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "avoid.js").write_text("")
    return tmp_path


@pytest.mark.parametrize(
    ("cast", "text"),
    [
        (chair("./mien {name}"), "got './mien', which does not exist; did you mean './mine'?"),
        (chair("{name}/mine"), "got 'chair1/mine', which does not exist"),
        (chair("./avoid.js", "own"), "expected a program that can be started (chmod +x), got './avoid.js'"),
        (chair("mine"), "got 'mine', which does not exist; did you mean './mine'?"),
        (chair("pythn x.py"), "got 'pythn', which does not exist; did you mean 'python"),
        (chair("no-such-program-anywhere-at-all"), "which does not exist"),
        (chair("./" + "x" * 300), "which does not exist"),
        (chair("./mine", "x" * 300), "expected a folder to start in, got"),
        (chair("./mine", "nowhere"), "expected a folder to start in, got"),
        (chair("./mine {nam}"), "did you mean {name}?"),
    ],
)
def test_program_that_cannot_be_started_is_named_with_its_agent(cast: list[Cast], text: str, folder: Path) -> None:
    with pytest.raises(WireError) as error:
        check_programs(cast, folder)
    assert error.value.text.startswith("agent 'chair1': Command: ")
    assert text in error.value.text


def test_program_is_found_in_its_folder_and_beside_this_python(folder: Path) -> None:
    check_programs(chair("./mine {endpoint}"), folder, ["tcp/127.0.0.1:1"])
    check_programs(chair("../mine", "own"), folder)
    check_programs(chair("python avoid.py {name}"), folder)
    check_programs([Cast(name="chair1", mind="anything")], folder)


def test_program_that_asks_for_an_endpoint_needs_one(folder: Path) -> None:
    with pytest.raises(WireError, match=r"expected --connect with an endpoint for \{endpoint\}, got none"):
        check_programs(chair("./mine {endpoint}"), folder, [])
    check_programs(chair("./mine {name}"), folder, [])


def test_folder_that_cannot_be_read_is_left_out_of_what_was_meant(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Not even root can read a folder with such a name.
    monkeypatch.setenv("PATH", f"{folder / ('x' * 300)}:{folder / 'mine'}:{folder}")
    with pytest.raises(WireError, match=r"got 'mien', which does not exist; did you mean 'mine'\?"):
        check_programs(chair("mien"), folder / "own")


@pytest.mark.process
def test_program_starts_in_its_folder_with_its_values(folder: Path) -> None:
    (folder / "own" / "say.py").write_text(
        "import os, sys; print('ready', f'folder={os.path.basename(os.getcwd())}', f'at={sys.argv[1]}', "
        "f\"name={os.environ['IW_NAME']}\", f\"world={os.environ['IW_WORLD']}\")"
    )
    values = {"endpoint": "tcp/127.0.0.1:1", "world": "main"}
    (cast,) = chair("python say.py {endpoint}", "own")
    with ChildProcesses(folder / "logs") as children:
        child = launch_agent(children, cast, lambda _: [], values, folder)
        assert child == "agent-chair1"
        expected = {"folder": "own", "at": "tcp/127.0.0.1:1", "name": "chair1", "world": "main"}
        assert children.line(child, "ready") == expected
        assert children.exit(child) == 0
