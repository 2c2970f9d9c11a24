"""What holds for every command of the distribution."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

from intellwheels_agents.iw_command import COMMANDS
from intellwheels_schemas.version import version_text
from tests.commands import ROOT, SCRIPTS, file_of


def run(name: str, *words: str) -> int:
    module, _, function = SCRIPTS[name].partition(":")
    with pytest.raises(SystemExit) as ended:
        getattr(import_module(module), function)(list(words))
    assert isinstance(ended.value.code, int)
    return ended.value.code


@pytest.mark.parametrize("name", SCRIPTS)
def test_command_prints_the_version(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(name, "--version") == 0
    assert capsys.readouterr().out == f"{version_text()}\n"


@pytest.mark.parametrize("name", SCRIPTS)
def test_command_has_help_under_its_own_name(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(name, "--help") == 0
    shown = capsys.readouterr().out
    assert shown.startswith(f"usage: {name} ")
    assert "--version" in shown


@pytest.mark.parametrize("name", SCRIPTS)
def test_wrong_usage_ends_with_2(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(name, "--no-such-option") == 2
    printed = capsys.readouterr().err
    assert printed.startswith(f"{name}: ")
    assert printed.endswith(f"; see {name} --help\n")
    assert printed.count("\n") == 1


def test_every_command_is_one_of_iw_and_in_the_readme() -> None:
    assert set(SCRIPTS) == {"iw", *(f"iw-{name}" for name in COMMANDS)}
    readme = (ROOT / "README.md").read_text()
    assert [name for name in SCRIPTS if name not in readme] == []


def test_command_is_a_file() -> None:
    for name in SCRIPTS:
        spec = import_module(file_of(name)).__spec__
        assert spec is not None
        assert spec.origin is not None
        assert Path(spec.origin).is_relative_to(ROOT)
