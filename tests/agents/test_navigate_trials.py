"""The trials of `navigate` keep the rows of each scene, go on where they stopped, and state what their hours show."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.agents import navigate_trials
from tests.agents.navigate_trials import Row, add, commit_here, highest_rate, main, read, said, summary


def row(scene: int, options: str = "truth=true", **changed: object) -> Row:
    made = Row("abc", "ward", options, 180.0, 1, scene, "chair1", "mid-wheel", "day1", "day2", True, 20.0, 30.0)
    for name, value in changed.items():
        setattr(made, name, value)
    return made


def test_rows_are_read_as_they_were_written(tmp_path: Path) -> None:
    file = tmp_path / "rows.csv"
    assert read(file) == []
    rows = [row(1), row(2, reached=False, contacts=2, longest_stand=61.5)]
    for one in rows:
        add(file, [one])
    assert read(file) == rows
    file.write_text("scene,chair\n1,chair1\n")
    with pytest.raises(ValueError, match=r"rows\.csv: expected the columns commit, ground, .*, got scene, chair"):
        read(file)


def test_stopped_command_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ran: list[int] = []

    def trial(scene: int, _chairs: int, _seconds: float, options: dict[str, str], *_: object) -> list[Row]:
        ran.append(scene)
        return [row(scene, said(options))]

    monkeypatch.setattr(navigate_trials, "trial", trial)
    monkeypatch.setattr(navigate_trials, "commit_here", lambda: "abc")
    file = tmp_path / "rows.csv"
    words = ["--csv", str(file), "--option", "truth=true"]
    main([*words, "--scenes", "2"])
    main([*words, "--scenes", "3"])
    assert ran == [1, 2, 3]
    assert "3 scenes: reached 3 of 3" in capsys.readouterr().out.splitlines()[-1]
    main(["--csv", str(file), "--scenes", "1"])  # without the option it is another run
    assert ran == [1, 2, 3, 1]
    assert [(one.scene, one.options) for one in read(file)][-2:] == [(3, "truth=true"), (1, "")]
    file.write_text("scene\n")
    with pytest.raises(SystemExit):
        main(words)
    assert "argument --csv: " in capsys.readouterr().err


def test_summary_states_hours_and_the_highest_rate() -> None:
    # Without a contact the bound is -ln(0.05) in all hours; with one it solves (1 + m) exp(-m) = 0.05.
    assert highest_rate(0, 2.0) == pytest.approx(-math.log(0.05) / 2.0)
    one = highest_rate(1, 1.0)
    assert (1.0 + one) * math.exp(-one) == pytest.approx(0.05)
    found = summary([row(1, lasted=180.0), row(2, lasted=180.0, longest_stand=61.0, reached=False)])
    assert "2 scenes: reached 1 of 2 (50 %), own contacts 0 in 0.10 chair-hours (at 95 % fewer than 29.96" in found
    assert "stood over 60 s 1" in found


def test_kept_rows_can_be_read_and_none_is_there_twice() -> None:
    kept = read(Path(navigate_trials.__file__).with_suffix(".csv"))
    assert kept
    assert len({(*one.run, one.chair) for one in kept}) == len(kept)


@pytest.mark.process
def test_commit_of_the_code_is_named() -> None:
    assert commit_here().rstrip("+").isalnum()
