from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from intellwheels_experiments.batch.trace_reader import commanded, read_trace, reported, rolled
from intellwheels_maps import floor, robot
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import (
    FileRecord,
    InputHeader,
    Inputs,
    InputTick,
    Join,
    TraceBody,
    TraceHeader,
    TraceTick,
    WorldRules,
)
from intellwheels_schemas.log_chain import Chain
from tests.experiments.runs import RUN, straight


def test_wheels_that_roll_a_quarter_circle_end_on_it_whatever_the_cut() -> None:
    for cuts in (1, 7):
        ways = (
            np.repeat([[math.pi / 4.0 - 0.25 * math.pi / 2.0, math.pi / 4.0 + 0.25 * math.pi / 2.0]], cuts, axis=0)
            / cuts
        )
        end = rolled(np.zeros(3), ways, 0.5)[-1]
        assert end == pytest.approx([0.5, 0.5, math.pi / 2.0])


def test_reported_pose_is_that_of_the_counts_within_one_of_them() -> None:
    trace = straight(ticks=40)
    found = reported(trace.shown("chair"), trace.robots["chair"])
    assert found is not None
    assert found[:, 0] == pytest.approx(trace.poses("chair")[:, 0], abs=math.pi * 0.368 / 2000)


def test_odometry_sensor_is_told_in_the_frame_of_the_start() -> None:
    start, here = (1.0, 2.0, math.pi / 2.0), TraceBody(pose=(1.0, 3.0, math.pi / 2.0), odometry=(1.0, 0.5, 0.1))
    found = reported([TraceBody(pose=start, odometry=(0.0, 0.0, 0.0)), here], robot("corridor-chair"))
    assert found is not None
    assert found[1] == pytest.approx([0.5, 3.0, math.pi / 2.0 + 0.1])


def test_body_without_wheels_reports_nothing() -> None:
    assert reported([TraceBody(pose=(0.0, 0.0, 0.0))], robot("table")) is None


def test_command_leads_as_far_as_the_powers_say() -> None:
    trace = straight(ticks=20, speed=0.5)
    assert commanded(trace.shown("chair"), trace.robots["chair"], 0.05)[-1] == pytest.approx([0.5, 0.0, 0.0])


def written(folder: Path) -> tuple[Path, Path]:
    """Write a trace and an input log as the simulator does; return their paths."""
    rules = WorldRules(say_limit=100, say_range=8.0, command_timeout=0.5, truth=False, strict=True)
    joins = (
        Join(agent="chair", robot=robot("corridor-chair")),
        Join(agent="chair", robot=msgspec.structs.replace(robot("table"), role="mind")),
    )
    log: list[FileRecord] = [
        InputHeader(log="iw.v1", run=RUN, map=floor("corridor15m"), seed="1", period=0.05, setup=rules),
        InputTick(tick=0, inputs=Inputs(changes=joins), hash="0" * 16),
        InputTick(tick=1, inputs=Inputs(), hash="1" * 16),
    ]
    lines: list[FileRecord] = [
        TraceHeader(run=RUN, seed="1", period=0.05, floor="corridor15m"),
        TraceTick(tick=0, body={"chair": TraceBody(pose=(0.0, 0.0, 0.0))}, hash="0" * 16),
        TraceTick(tick=1, body={"chair": TraceBody(pose=(0.1, 0.0, 0.0), speed=2.0)}, hash="1" * 16),
    ]
    for name, records in (("trace", lines), ("log", log)):
        (folder / name).write_bytes(b"".join(msgspec.json.encode(record) + b"\n" for record in records))
    return folder / "trace", folder / "log"


def test_trace_and_the_bodies_of_its_log_are_read(tmp_path: Path) -> None:
    trace = read_trace(*written(tmp_path))
    assert trace.heading.floor == "corridor15m"
    assert trace.poses("chair").tolist() == [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]
    assert trace.robots == {"chair": robot("corridor-chair")}


@pytest.mark.parametrize("name", ["trace", "log"])
def test_file_of_an_older_release_without_a_version_is_read(tmp_path: Path, name: str) -> None:
    paths = written(tmp_path)
    file = tmp_path / name
    file.write_bytes(file.read_bytes().replace(b'"Version":1,', b""))
    assert len(read_trace(*paths).moments) == 2


@pytest.mark.parametrize(
    ("name", "expected"), [("trace", "a trace of version 1"), ("log", "an input log of version 1 or 2")]
)
def test_file_of_a_later_release_is_refused_in_words(tmp_path: Path, name: str, expected: str) -> None:
    paths = written(tmp_path)
    file = tmp_path / name
    file.write_bytes(file.read_bytes().replace(b'"Version":1,', b'"Version":3,'))
    with pytest.raises(WireError, match=f"{name}:1: expected {expected}, got version 3"):
        read_trace(*paths)


def test_log_edited_after_its_first_step_is_refused_too(tmp_path: Path) -> None:
    trace, log = written(tmp_path)
    first, *rest = log.read_bytes().splitlines()
    chain = Chain()
    lines = [chain.seal(line) for line in (first.replace(b'"Version":1', b'"Version":2'), *rest)]
    log.write_bytes(b"\n".join(lines) + b"\n")
    assert len(read_trace(trace, log).moments) == 2
    log.write_bytes(b"\n".join(lines).replace(b"1" * 16, b"2" * 16) + b"\n")
    with pytest.raises(WireError, match="log:3: expected checksum"):
        read_trace(trace, log)


@pytest.mark.parametrize("name", ["trace", "log"])
def test_line_that_cannot_be_read_is_named(tmp_path: Path, name: str) -> None:
    paths = written(tmp_path)
    first, _, last = (tmp_path / name).read_bytes().splitlines()
    (tmp_path / name).write_bytes(first + b"\n{}\n" + last + b"\n")
    with pytest.raises(WireError, match=f"{name}:2: expected the line of a tick, got "):
        read_trace(*paths)


def test_empty_trace_is_no_trace(tmp_path: Path) -> None:
    trace, log = written(tmp_path)
    trace.write_bytes(b"")
    with pytest.raises(WireError, match="trace:1: expected the header of a trace, got "):
        read_trace(trace, log)
