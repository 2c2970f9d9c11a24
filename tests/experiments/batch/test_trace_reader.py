from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_experiments.batch.trace_reader import Shown, commanded, reported, rolled
from intellwheels_maps import robot
from tests.experiments.runs import straight


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
    start, here = (1.0, 2.0, math.pi / 2.0), Shown(pose=(1.0, 3.0, math.pi / 2.0), odometry=(1.0, 0.5, 0.1))
    found = reported([Shown(pose=start, odometry=(0.0, 0.0, 0.0)), here], robot("corridor-chair"))
    assert found is not None
    assert found[1] == pytest.approx([0.5, 3.0, math.pi / 2.0 + 0.1])


def test_body_without_wheels_reports_nothing() -> None:
    assert reported([Shown(pose=(0.0, 0.0, 0.0))], robot("table")) is None


def test_command_leads_as_far_as_the_powers_say() -> None:
    trace = straight(ticks=20, speed=0.5)
    assert commanded(trace.shown("chair"), trace.robots["chair"], 0.05)[-1] == pytest.approx([0.5, 0.0, 0.0])
