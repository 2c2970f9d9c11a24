from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from intellwheels_maps import floor, robot
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Actions
from intellwheels_server.__main__ import main
from intellwheels_server.log.branch import read_branch
from intellwheels_server.log.input_log import Line, Log, LogError
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.log.seekable_log import SeekableLog
from intellwheels_server.log.true_trace import trace_lines
from intellwheels_server.world import Setup, advance, begin, digest
from tests.server.log_edits import make_version_1, records, rewrite

RUN = "0123456789abcdef"


def run(path: Path, ticks: int = 5) -> str:
    setup = Setup(floor=floor("room"))
    log, state = Log(path, setup, RUN), begin(setup, RUN)
    for tick in range(ticks):
        changes = (Join(agent="one", robot=robot("rear-wheel")),) if tick == 0 else ()
        inputs = Inputs(changes=changes, actions={"one": Actions(left_motor=0.5, right_motor=0.25)})
        state, _ = advance(state, inputs)
        log.write(Line(tick=tick, inputs=inputs, hash=digest(state)), 0.0)
    log.close()
    return digest(state)


def test_log_gives_the_same_hashes_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log"
    hashed = run(path)
    found = resimulate(path)
    assert (found.ticks, found.tick, found.hash, found.cut, found.differs) == (5, 5, hashed, False, None)
    assert main(["--resimulate", str(path)]) == 0
    assert capsys.readouterr().out == f"same ticks=5 tick=5 hash={hashed}\n"


def test_incomplete_last_line_is_dropped_and_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log"
    run(path)
    path.write_bytes(path.read_bytes().rpartition(b'{"End"')[0][:-9])
    found = resimulate(path)
    assert (found.ticks, found.cut, found.differs) == (4, True, None)
    assert main(["--resimulate", str(path)]) == 1
    shown = capsys.readouterr()
    assert shown.out.startswith("truncated ticks=4 tick=4 hash=")
    assert "the log is truncated after tick 4" in shown.err


def test_log_without_checksums_runs_again_and_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log"
    hashed = run(path)
    make_version_1(path)
    assert main(["--resimulate", str(path)]) == 0
    shown = capsys.readouterr()
    assert shown.out == f"same ticks=5 tick=5 hash={hashed}\n"
    assert "has no checksums" in shown.err


def test_edited_log_is_refused_by_every_reader_and_a_cut_one_is_read_to_its_last_whole_line(tmp_path: Path) -> None:
    path = tmp_path / "log"
    run(path)
    lines = path.read_bytes().splitlines(keepends=True)
    readers: list[Callable[[], object]] = [
        lambda: resimulate(path), lambda: SeekableLog(path).close(), lambda: list(trace_lines(path)),
        lambda: read_branch(path, 1),
    ]  # fmt: skip
    path.write_bytes(b"".join([*lines[:4], lines[4].replace(b"0.25", b"0.26"), *lines[5:]]))
    for reader in readers:
        with pytest.raises(LogError, match=r"log:5: expected checksum \w+, got \w+: the log was edited after tick 3,"):
            reader()
    for keep in (lines[:4], [*lines[:4], lines[4][:-40]]):
        path.write_bytes(b"".join(keep))
        found = resimulate(path)
        assert (found.tick, found.cut) == (3, True)
        recording = SeekableLog(path)
        assert (recording.last_tick, recording.cut, recording.chained) == (3, True, True)
        recording.close()
        told: list[str] = []
        assert len(list(trace_lines(path, told.append))) == 4
        assert "truncated after tick 3" in told[0]
        assert read_branch(path, 3).at == 3
        with pytest.raises(
            LogError, match=r"expected a tick in \[0, 3\] to branch at, got 4: .*truncated after tick 3"
        ):
            read_branch(path, 4)


def test_first_tick_that_differs_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log"
    run(path)
    lines = records(path)
    line = msgspec.json.decode(lines[3], type=Line)
    lines[3] = msgspec.json.encode(msgspec.structs.replace(line, hash="f" * 16))
    rewrite(path, lines)
    assert main(["--resimulate", str(path)]) == 1
    assert capsys.readouterr().out.startswith(
        f"differs tick 2 of run {RUN} (line 4): expected hash ffffffffffffffff, got "
    )


def test_missing_tick_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "log"
    run(path)
    lines = records(path)
    rewrite(path, lines[:2] + lines[3:])
    with pytest.raises(LogError, match=r"log:3: expected tick 1, got 2"):
        resimulate(path)


def test_missing_file_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--resimulate", str(tmp_path / "none")])
    assert ended.value.code == 2
    assert "--resimulate: expected a file that exists, got" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda header: header.update(Period=0), r"log:1: expected the header of an input log, got .*Period"),
        (lambda header: header.update(Run="../.."), r"log:1: expected the header of an input log, got .*Run"),
        (lambda header: header["Setup"].update(SayLoss=7.0), r"log:1: expected the header .*Setup\.SayLoss"),
        (lambda header: header["Map"]["Wall"][0].update(Corner=[]), r"log:1: wall 0: a line needs at least 2 corners"),
        (
            lambda header: header["Setup"].update(End={"Reach": [{"Agent": "one", "Place": "moon", "Within": 1.0}]}),
            r"log:1: .*moon",
        ),
    ],
)
def test_header_of_an_impossible_world_is_an_error(
    tmp_path: Path, edit: Callable[[dict[str, Any]], None], message: str
) -> None:
    run(tmp_path / "log")
    lines = records(tmp_path / "log")
    header = json.loads(lines[0])
    edit(header)
    rewrite(tmp_path / "log", [json.dumps(header).encode(), *lines[1:]])
    with pytest.raises(LogError, match=message):
        resimulate(tmp_path / "log")
    with pytest.raises(LogError, match=message):
        SeekableLog(tmp_path / "log")
