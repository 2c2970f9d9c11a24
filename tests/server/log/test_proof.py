"""The line that a paper can quote, and the logs for which there is none."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_maps import floor
from intellwheels_schemas.version import versions_of
from intellwheels_server.__main__ import main
from intellwheels_server.log.proof import proof_line
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.world import map_hash
from tests.server.log.test_branch import written
from tests.server.log_edits import make_version_1, records, rewrite


def prove(path: Path) -> int:
    return main(["--resimulate", str(path), "--prove"])


def test_proof_is_one_line_with_everything_that_makes_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hashes = written(tmp_path / "log")
    assert prove(tmp_path / "log") == 0
    (line,) = capsys.readouterr().out.splitlines()
    word, *fields = line.split(" ")
    found = dict(field.split("=", 1) for field in fields)
    chain = (tmp_path / "log").read_bytes()[-19:-3].decode()
    assert word == "proved"
    assert found == {
        "map": "room", "map-hash": map_hash(floor("room")), "seed": "7", "run": "0123456789abcdef", "runs": "1",
        "ticks": "6", "hash": hashes[-1], "chain": chain, **versions_of("intellwheels", "numpy", "numba"),
    }  # fmt: skip


def test_proof_with_other_versions_says_so_and_a_seed_stays_one_word(tmp_path: Path) -> None:
    written(tmp_path / "log")
    first, *rest = records(tmp_path / "log")
    python = versions_of()["python"]
    first = first.replace(b'"python":"%b"' % python.encode(), b'"python":"2.7"').replace(b'"Seed":"7"', b'"Seed":"a b"')
    rewrite(tmp_path / "log", [first, *rest])
    line = proof_line(resimulate(tmp_path / "log"))
    assert " python=2.7 " in line
    assert line.endswith(f" again-with=python-{python}")
    assert " seed='a b' " in line


def test_cut_edited_old_and_differing_logs_are_not_proved(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hashes = written(tmp_path / "log")
    whole = (tmp_path / "log").read_bytes()
    lines = records(tmp_path / "log")

    def refused(words: str) -> None:
        assert prove(tmp_path / "log") == 1
        shown = capsys.readouterr()
        assert "proved" not in shown.out
        assert words in shown.out + shown.err

    (tmp_path / "log").write_bytes(whole[:-50])
    refused("the log is truncated after tick 6")
    (tmp_path / "log").write_bytes(whole.replace(b'"LeftMotor":0.5', b'"LeftMotor":0.6', 1))
    refused("log:2: expected checksum")
    rewrite(tmp_path / "log", [line.replace(hashes[3].encode(), b"0" * 16) for line in lines])
    refused("differs tick 3")
    rewrite(tmp_path / "log", lines)
    make_version_1(tmp_path / "log")
    refused("a log of version 1 has no checksums")
