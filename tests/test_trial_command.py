"""The help of the trials can be read: the docstring keeps its lines, and every option is explained."""

from __future__ import annotations

from importlib import import_module

import pytest

TRIALS = (
    "tests.agents.avoid_trials", "tests.agents.late_trials", "tests.agents.navigate_trials",
    "tests.agents.person_trials", "tests.server.world.sonar_trials",
)  # fmt: skip


@pytest.mark.parametrize("name", TRIALS)
def test_help_of_a_trial_is_its_docstring_and_every_default(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    module = import_module(name)
    with pytest.raises(SystemExit):
        module.main(["--help"])
    shown = capsys.readouterr().out
    assert shown.startswith(f"usage: python -m {name} ")
    assert (module.__doc__ or "").strip() in shown
    options = [" ".join(part.split()) for part in shown.partition("options:\n")[2].split("\n  --")[1:]]
    said = ("(default: ", "may be repeated", "also print")
    assert [option for option in options if not any(words in option for words in said)] == []
