"""The poses that bridges reported, by run and tick of the log of the laboratory."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from intellwheels_schemas.messages import Pose, Reset, Result
from intellwheels_server.log.reported_poses import ReportedPoses
from intellwheels_server.log.seekable_log import SeekableLog
from tests.server.stage import Stage, real

RUNS = ("00000000000000aa", "00000000000000bb", "00000000000000cc")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs: in the first a real chair says at each tick that it is 0.1 m further, in the second it stands."""
    path = tmp_path_factory.mktemp("reported") / "log"
    stage = Stage(pace="realtime", strict=False, log=path)
    session = stage.join("chair1", real()).session
    stage.join("chair2", instance="b" * 16)
    for step in range(20):
        stage.put("chair1", Pose(session=session, x=2.0 + 0.1 * step, y=2.0, heading=0.5), "pose")
        stage.work(0.05)
    assert isinstance(stage.result("reset", Reset(seed="9")), Result)
    stage.work(0.5)
    stage.live_run.finish(stage.now)
    assert stage.log is not None
    stage.log.close()
    return path


@pytest.fixture
def reported(log: Path) -> Iterator[ReportedPoses]:
    recording = SeekableLog(log)
    yield ReportedPoses(RUNS, recording)
    recording.close()


def test_reported_pose_is_that_of_the_tick_however_it_is_reached(reported: ReportedPoses) -> None:
    onwards = [reported.at(RUNS[0], tick)["chair1"] for tick in range(5, 16)]
    assert [pose.tick for pose in onwards] == list(range(5, 16))
    assert {pose.run for pose in onwards} == {RUNS[0]}
    steps = [after.x - before.x for before, after in pairwise(onwards)]
    assert steps == pytest.approx([0.1] * 10)
    assert (onwards[0].y, onwards[0].heading) == (2.0, 0.5)
    assert reported.at(RUNS[0], 7)["chair1"] == onwards[2]
    assert reported.at(RUNS[0], 15)["chair1"] == onwards[10]


def test_simulated_body_has_no_reported_pose(reported: ReportedPoses) -> None:
    assert reported.at(RUNS[0], 5).keys() == {"chair1"}


def test_runs_are_paired_in_order_and_missing_ticks_have_no_poses(reported: ReportedPoses) -> None:
    assert reported.at(RUNS[1], 5)["chair1"].run == RUNS[1]
    assert reported.at(RUNS[1], 5)["chair1"].x != reported.at(RUNS[0], 15)["chair1"].x
    assert reported.at(RUNS[0], 10_000) == {}
    assert reported.at(RUNS[2], 5) == {}
    assert reported.at("no such run", 5) == {}
    assert reported.at(RUNS[0], 5)  # and it goes on after that
