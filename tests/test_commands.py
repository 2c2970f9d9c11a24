"""What holds for every command of the distribution."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from intellwheels_agents.iw_command import COMMANDS
from intellwheels_schemas.version import version_text
from tests.commands import ROOT, SCRIPTS, file_of
from tests.every_case import every_case


def run(name: str, *words: str) -> int:
    module, _, function = SCRIPTS[name].partition(":")
    with pytest.raises(SystemExit) as ended:
        getattr(import_module(module), function)(list(words))
    assert isinstance(ended.value.code, int)
    return ended.value.code


@every_case("name", SCRIPTS)
def test_command_prints_the_version(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(name, "--version") == 0
    assert capsys.readouterr().out == f"{version_text()}\n"


@every_case("name", SCRIPTS)
def test_command_has_help_under_its_own_name(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(name, "--help") == 0
    shown = capsys.readouterr().out
    assert shown.startswith(f"usage: {name} ")
    assert "--version" in shown


@every_case("name", SCRIPTS)
def test_wrong_usage_ends_with_2(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(name, "--no-such-option") == 2
    printed = capsys.readouterr().err
    assert printed.startswith(f"{name}: ")
    assert printed.endswith((f"; see {name} --help\n", f"? See {name} --help\n"))
    assert printed.count("\n") == 1


def test_every_command_is_one_of_iw_and_in_the_readme() -> None:
    known = {"iw", *(f"iw-{name}" for name in COMMANDS)}
    assert set(SCRIPTS) == known, "pyproject.toml has changed: run pip install -e '.[test]' again"
    readme = (ROOT / "README.md").read_text()
    assert [name for name in SCRIPTS if name not in readme] == []


def test_command_is_a_file() -> None:
    for name in SCRIPTS:
        spec = import_module(file_of(name)).__spec__
        assert spec is not None
        assert spec.origin is not None
        assert Path(spec.origin).is_relative_to(ROOT)


LACKING: dict[str, tuple[list[str], str]] = {
    "iw-server": (["--map", "room"], "server"),
    "iw-viewer": ([], "viewer"),
    "iw-run": (["figure6"], "server"),
    "iw-record": (["run.mcap"], "foxglove"),
    "iw-joystick": (["chair1", "--source", "keyboard"], "joystick"),
    "iw-bridge": (["serial", "--name", "chair1", "--port", "/dev/null"], "bridge"),
    "iw-agent": (["navigate"], "navigate"),
    "iw-ros": (["--name", "chair1"], "ros"),
    "iw": (["server"], "server"),
}
"""A use of each command that needs an extra, and the extra."""

WITHOUT_EXTRA = {"iw-router", "iw-lab", "iw-check-agent", "iw-ciber"}
"""The commands that the base installation runs."""

BASE_ONLY = """
import contextlib, importlib, io, json, sys
from intellwheels_schemas.extras import MODULES
sys.modules |= dict.fromkeys(name for names in MODULES.values() for name in names)
found = []
for entry, words in json.loads(sys.argv[1]):
    module, _, function = entry.partition(":")
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = getattr(importlib.import_module(module), function)(words)
        except SystemExit as ended:
            code = ended.code
    found.append([code, out.getvalue(), err.getvalue()])
print(json.dumps(found))
"""
"""Calls commands in one process, with the modules of all extras hidden."""


def with_base_only(uses: list[tuple[str, list[str]]]) -> list[tuple[int, str, str]]:
    """Return exit code, standard output and standard error of each use of a command in a base installation."""
    given = json.dumps([(SCRIPTS[name], words) for name, words in uses])
    done = subprocess.run(
        [sys.executable, "-c", BASE_ONLY, given], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return [(code, out, err) for code, out, err in json.loads(done.stdout)]


@pytest.mark.process
def test_without_its_extra_a_command_says_which_one_it_needs() -> None:
    assert LACKING.keys() | WITHOUT_EXTRA == SCRIPTS.keys()
    uses = [(name, words) for name, (words, _) in LACKING.items()]
    uses += [("iw-run", ["figure6", "--view"]), ("iw-run", ["table1", "--seeds", "2"]), ("iw-record", ["--ros2", "b"])]
    uses += [("iw-lab", ["keys", "--lab", str(ROOT / "schemas/vectors/Lab.xml")])]
    extras = [extra for _, extra in LACKING.values()] + ["server,viewer", "server,experiments", "foxglove,ros", "lab"]
    for (name, words), extra, (code, out, err) in zip(uses, extras, with_base_only(uses), strict=True):
        assert (code, out) == (2, ""), (name, words, err)
        assert err.startswith("iw-server: " if name == "iw" else f"{name}: ")
        assert err.endswith(f"run pip install '.[{extra}]' in the project's folder\n"), err
        assert err.count("\n") == 1


@pytest.mark.process
def test_help_and_version_need_no_extra() -> None:
    uses = [(name, [word]) for name in SCRIPTS for word in ("--help", "--version")]
    uses += [("iw", ["completion", "bash"]), ("iw-router", ["--print"])]
    for (name, words), (code, out, err) in zip(uses, with_base_only(uses), strict=True):
        assert (code, err) == (0, ""), (name, words)
        assert out
