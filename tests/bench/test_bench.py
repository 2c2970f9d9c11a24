import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.bench import beside
from tests.bench.rows import HEAD, Row, append, show

BY_NAME = ("lab", "bystanders")
"""Benchmarks that take a quarter of an hour or more; their short versions start the most processes."""
MAY_BE_NOTHING = ("late ticks", "longest delay", "CPU of", "frames")
"""Figures that are 0 where all goes well; CPU time is counted in hundredths of a second, and short
versions use few. A browser may draw nothing in so short a time."""


@pytest.mark.process
def test_rows_are_appended_below_one_head(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    row = Row("tick", "1 bodies", "step", 1.23456, "µs/body", "<= 10")
    append([row], tmp_path / "rows.csv")
    append([row, row], tmp_path / "rows.csv")
    rows = list(csv.reader((tmp_path / "rows.csv").read_text().splitlines()))
    assert tuple(rows[0]) == HEAD
    assert [line[3:] for line in rows[1:]] == [["tick", "1 bodies", "step", "1.235", "µs/body", "<= 10"]] * 3
    show([row])
    assert "1.235 µs/body   goal <= 10" in capsys.readouterr().out


@pytest.mark.process
def test_rows_of_another_commit_are_measured_in_a_checkout_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = tmp_path / "tests" / "bench"
    bench.mkdir(parents=True)
    (bench / "tick.py").touch()
    (bench / "__main__.py").write_text(
        f"import sys\nopen(sys.argv[3], 'w').write('{','.join(HEAD)}\\nm,c,0,tick,1 bodies,step,4.0,µs,\\n')"
    )
    names = dict.fromkeys(("GIT_AUTHOR_NAME", "GIT_COMMITTER_NAME"), "nobody")
    mails = dict.fromkeys(("GIT_AUTHOR_EMAIL", "GIT_COMMITTER_EMAIL"), "nobody@localhost")
    for words in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "first"]):
        subprocess.run(["git", *words], cwd=tmp_path, env={**os.environ, **names, **mails}, timeout=60, check=True)
    monkeypatch.setattr(beside, "ROOT", tmp_path)
    others = beside.rows_of("HEAD", "tick")
    assert others == [Row("tick", "1 bodies", "step", 4.0, "µs")]
    assert beside.rows_of("HEAD", "crews") == []
    now = [Row("tick", "1 bodies", "step", 2.0, "µs"), Row("tick", "1 bodies", "sense", 2.0, "µs")]
    assert beside.ratios(now, others) == [Row("tick", "1 bodies", "step", 0.5, "of the other")]
    with pytest.raises(RuntimeError, match="expected exit code 0 of git worktree add"):
        beside.rows_of("no-such-commit", "tick")


@pytest.mark.process
@pytest.mark.parametrize(
    ("words", "kept"), [(["--quick"], False), (["--quick", "--csv", "rows.csv"], True), ([], True)]
)
def test_figures_of_short_versions_are_not_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], kept: bool
) -> None:
    from tests.bench import __main__ as command

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(command, "KEPT", tmp_path / "rows.csv")
    monkeypatch.setattr(command, "run", lambda wanted, *, quick: [Row("tick", "1 bodies", "step", 1.0, "µs")])
    monkeypatch.setattr(sys, "argv", ["bench", "tick", *words])
    command.main()
    assert (tmp_path / "rows.csv").exists() == kept


def rows_of(folder: Path, *benches: str) -> list[dict[str, str]]:
    """Run short versions of benchmarks; return the rows that they wrote."""
    file = folder / "rows.csv"
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench", *benches, "--quick", "--csv", str(file)],
        cwd=Path(__file__).parents[2], capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(file.read_text().splitlines()))
    nothing = [row for row in rows if float(row["value"]) <= 0.0 and not row["figure"].startswith(MAY_BE_NOTHING)]
    assert nothing == []
    return rows


@pytest.mark.process
def test_benchmarks_run_and_say_every_share_of_a_tick(tmp_path: Path) -> None:
    from tests.bench.__main__ import DEFAULT

    rows = rows_of(tmp_path)
    shares = {row["figure"] for row in rows if row["bench"] == "tick"}
    assert {"receive", "decode", "step", "sense", "encode JSON", "put"} <= shares
    assert {row["bench"] for row in rows} == {*DEFAULT, "lockstep"}


@pytest.mark.soak
@pytest.mark.process
def test_benchmarks_that_run_only_by_name_run(tmp_path: Path) -> None:
    assert {row["bench"] for row in rows_of(tmp_path, *BY_NAME)} == set(BY_NAME)
