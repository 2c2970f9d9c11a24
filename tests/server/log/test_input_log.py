from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from intellwheels_maps import floor
from intellwheels_schemas.file_records import Inputs
from intellwheels_schemas.messages import Actions
from intellwheels_server.log.input_log import Line, Log, LogError, read_header, read_lines
from intellwheels_server.world import Setup
from tests.server.log_edits import make_version_1, records, rewrite
from tests.server.worlds import unusual_setup

RUN = "0123456789abcdef"
SETUP = Setup(floor=floor("room"), seed="7", say_walls=True, say_loss=0.1, say_delay=0.2)


def written(path: Path, count: int = 3) -> list[Line]:
    log = Log(path, SETUP, RUN)
    lines = [
        Line(tick=k, inputs=Inputs(actions={"one": Actions(left_motor=0.1 + 0.2 * k)}), hash="0" * 16)
        for k in range(count)
    ]
    for line in lines:
        log.write(line, 0.0)
    log.close()
    return lines


def test_written_log_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "log"
    lines = written(path)
    with path.open("rb") as file:
        header = read_header(file, "log")
        assert (header.run, header.seed, header.period) == (RUN, "7", 0.05)
        assert header.world_setup() == SETUP
        assert {"python", "numpy", "numba", "intellwheels"} <= header.versions.keys()
        assert list(read_lines(file, "log")) == lines


def test_line_is_in_the_file_after_a_second(tmp_path: Path) -> None:
    path = tmp_path / "log"
    log = Log(path, Setup(floor=floor("room")), RUN)
    line = Line(tick=0, inputs=Inputs(), hash="0" * 16)
    for now in (100.0, 100.5, 101.1):
        log.write(line, now)
    assert path.read_bytes().count(b"\n") == 4
    log.close()


def test_log_that_is_not_closed_in_order_has_no_end(tmp_path: Path) -> None:
    path = tmp_path / "log"
    log = Log(path, SETUP, RUN)
    log.add(Line(tick=0, inputs=Inputs(), hash="0" * 16))
    log.flush_if_due(1.0)
    with path.open("rb") as file:
        assert [line is None for line in read_lines(file, "log")] == [False, True]
    log.close(orderly=False)
    with path.open("rb") as file:
        assert [line is None for line in read_lines(file, "log")] == [False, True]


def test_incomplete_last_line_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "log"
    lines = written(path)
    path.write_bytes(path.read_bytes().rpartition(b'{"End"')[0][:-20])
    with path.open("rb") as file:
        read_header(file, "log")
        assert list(read_lines(file, "log")) == [*lines[:2], None]


def test_broken_line_in_the_middle_is_an_error_with_its_number(tmp_path: Path) -> None:
    path = tmp_path / "log"
    written(path)
    first, _, last = records(path)[:3]
    rewrite(path, [first, b'{"Tick":"x"}', last])
    with path.open("rb") as file:
        read_header(file, "log")
        with pytest.raises(LogError, match=r"^log:2: expected the line of a tick, got"):
            list(read_lines(file, "log"))


@pytest.mark.parametrize("data", [b"", b"{}\n", b"\xff\n", b"hello\n"])
def test_file_that_is_no_log_is_an_error(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "log"
    path.write_bytes(data)
    with path.open("rb") as file, pytest.raises(LogError, match=r"^log:1: expected the header of an input log"):
        read_header(file, "log")


def test_log_says_its_version_and_one_of_another_is_refused_in_words(tmp_path: Path) -> None:
    path = tmp_path / "log"
    lines = written(path)
    first, *rest = records(path)
    assert first.startswith(b'{"Log":"iw.v1","Version":2,"Run":')
    rewrite(path, [first.replace(b'"Version":2', b'"Version":3'), *rest])
    with (
        path.open("rb") as file,
        pytest.raises(LogError, match=r"^log:1: expected an input log of version 1 or 2, got 3"),
    ):
        read_header(file, "log")
    rewrite(path, [first, *rest])
    make_version_1(path)
    path.write_bytes(path.read_bytes().replace(b'"Version":1,', b""))
    with path.open("rb") as file:
        assert read_header(file, "log").world_setup() == SETUP
        assert list(read_lines(file, "log")) == lines


def test_only_a_line_without_a_step_says_so() -> None:
    line = Line(tick=1, inputs=Inputs(), hash="0" * 16)
    assert msgspec.json.encode(line) == b'{"Tick":1,"Inputs":{},"Hash":"0000000000000000"}'
    assert b'"Stepped":false' in msgspec.json.encode(msgspec.structs.replace(line, stepped=False))


def test_header_gives_every_field_of_the_setup_back(tmp_path: Path) -> None:
    path = tmp_path / "log"
    setup = unusual_setup()
    Log(path, setup, "0" * 16).close()
    with path.open("rb") as file:
        assert read_header(file, str(path)).world_setup() == setup
