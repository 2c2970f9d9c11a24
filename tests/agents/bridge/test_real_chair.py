from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import msgspec
import pytest

from intellwheels_agents.bridge.line_faults import Faults
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.pose_source import PoseSource
from intellwheels_agents.bridge.real_chair import RealChair
from intellwheels_agents.bridge.sensor_merge import SensorMerge
from intellwheels_agents.mind import Context
from intellwheels_agents.options import Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import Map, Measures, Pace, Position, PowerInForce
from tests.agents.bridge.readings import FakeDriver, reading
from tests.agents.kinematics import PARAMETERS

CHAIR = robot("intellwheels")
RUN = "a" * 16
METRE = round(CHAIR.encoder_ticks / (math.pi * CHAIR.wheel_diameter))


class ChairRig:
    """A real chair with a fake driver and fake clocks."""

    def __init__(self, pace: Pace = "realtime", faults: Faults | None = None, **more: Any) -> None:
        self.now = 100.0
        self.driver = FakeDriver()
        self.motors = MotorDeadman(faults)
        merge = SensorMerge(CHAIR, CHAIR, "both")
        self.chair = RealChair(
            self.driver, PoseSource(CHAIR, "raw"), self.motors, merge, faults=faults,
            clock=lambda: self.now, wall=lambda: 1e9 + self.now, **more,
        )  # fmt: skip
        self.chair.begin(context(pace))

    def hear(self, seq: int, counts: int = 0, **more: float) -> None:
        given: Mapping[str, float] = {"stamp": self.now - 90.0, "received": self.now, **more}
        self.driver.waiting.append(reading(seq, counts, counts, **given))

    def decide(self, tick: int, run: str = RUN) -> object:
        return self.chair.decide(Measures(run=run, tick=tick, time=0.05 * tick))


def context(pace: Pace) -> Context:
    def fetch() -> Map:
        raise AssertionError("nobody asks for the map")

    parameters = msgspec.structs.replace(PARAMETERS, pace=pace, period=0.05)
    return Context("chair1", CHAIR, Position(x=1.0, y=2.0, heading=0.0), parameters, Options(), fetch, RUN)


def test_the_driver_learns_of_a_run_before_its_first_tick() -> None:
    made = ChairRig()
    made.chair.begin(context("lockstep"))
    assert made.driver.runs[-1] == RUN


def test_a_pose_has_place_covariance_stamp_and_the_chair_s_own_readings() -> None:
    made = ChairRig(clock_offset=5.0)
    made.hear(1)
    made.decide(0)
    made.now += 0.05
    made.hear(2, METRE)
    made.now += 0.02
    pose = made.decide(1)
    assert pose.x == pytest.approx(2.0, abs=1e-3)  # type: ignore[attr-defined]
    assert len(pose.covariance) == 6  # type: ignore[attr-defined]
    # It was true when the reading was taken, 20 ms ago, on the simulator's clock.
    assert pose.stamp == pytest.approx(1e9 + 100.05 + 5.0, abs=1e-6)  # type: ignore[attr-defined]
    assert pose.sensors.encoders[0].left == METRE  # type: ignore[attr-defined]


def test_no_pose_before_the_first_reading_or_while_the_hardware_is_silent(capsys: pytest.CaptureFixture[str]) -> None:
    made = ChairRig()
    assert made.decide(0) is None
    made.hear(1)
    assert made.decide(1) is not None
    made.now += 0.29
    assert made.decide(2) is not None
    made.now += 0.02
    assert made.decide(3) is None
    made.hear(2)
    assert made.decide(4) is not None
    assert made.chair.statistics.stale == 1
    assert capsys.readouterr().err == "stale hardware=silent\nfresh hardware=heard\n"


def test_a_delayed_line_gives_older_poses_with_matching_stamps() -> None:
    made = ChairRig(faults=Faults(delay=0.1))
    for tick in range(20):
        made.hear(tick, 10 * tick)
        pose = made.decide(tick)
        if tick >= 2:
            assert pose.sensors.encoders[0].left == 10 * (tick - 2)  # type: ignore[attr-defined]
            assert pose.stamp == pytest.approx(1e9 + made.now - 0.1, abs=1e-6)  # type: ignore[attr-defined]
        made.now += 0.05
    assert made.chair.statistics.oldest == pytest.approx(0.1, abs=1e-6)


def test_with_jitter_and_loss_the_pose_never_steps_back() -> None:
    made = ChairRig(faults=Faults(jitter=0.2, loss=0.3, seed="3"))
    ways = []
    for tick in range(200):
        made.hear(tick, 10 * tick)
        pose = made.decide(tick)
        if pose is not None:
            ways.append(pose.x)  # type: ignore[attr-defined]
        made.now += 0.05
    assert ways == sorted(ways)
    assert 30 < made.chair.lost < 90
    # No count is lost with a reading: they are sums.
    assert ways[-1] == pytest.approx(1.0 + 1990 / METRE, abs=0.05)


def test_in_lockstep_every_tick_has_a_pose_without_a_stamp() -> None:
    made = ChairRig("lockstep")
    made.driver.paired = True
    made.driver.waiting.append(reading(0, tick=0))
    poses = [made.decide(tick) for tick in range(30)]
    assert all(pose is not None and pose.stamp is None for pose in poses)  # type: ignore[attr-defined]


def test_in_lockstep_every_run_starts_at_the_start_on_a_delayed_line() -> None:
    made = ChairRig("lockstep", Faults(delay=0.1))
    made.driver.paired = made.driver.restarts_at_start = True
    for run in (RUN, "b" * 16):
        places = []
        for tick in range(10):
            made.driver.waiting.append(reading(tick, METRE * tick, METRE * tick, tick=tick, epoch=run))
            places.append(made.decide(tick, run).x)  # type: ignore[attr-defined]
        assert places[:3] == [1.0, 1.0, 1.0]
        assert places[9] == pytest.approx(8.0, abs=0.01)


def test_the_power_of_a_tick_reaches_the_motors_and_the_driver() -> None:
    made = ChairRig("lockstep")
    made.driver.paired = True
    made.decide(0)
    made.chair.obey(PowerInForce(run=RUN, tick=0, left_motor=0.5, right_motor=0.4))
    assert made.driver.ticks == [(RUN, 0)]
    assert made.motors.output(0.0) == (0.0, 0.0)
    assert made.motors.output(0.05) == (0.5, 0.4)


def test_a_new_run_starts_with_the_motors_off() -> None:
    made = ChairRig()
    made.decide(0)
    made.chair.obey(PowerInForce(run=RUN, tick=0, left_motor=0.5, right_motor=0.4))
    assert made.motors.output(made.now) == (0.5, 0.4)
    made.decide(0, "b" * 16)
    assert made.motors.output(made.now) == (0.0, 0.0)


def test_each_new_reading_is_passed_on_once() -> None:
    heard: list[int] = []
    made = ChairRig(on_reading=lambda one: heard.append(one.seq))
    for seq in (1, 3, 2, 4):
        made.hear(seq)
    made.decide(0)
    assert heard == [1, 3, 4]
