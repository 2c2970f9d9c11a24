from __future__ import annotations

import threading
from itertools import pairwise

from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.motor_writer import MotorWriter
from intellwheels_agents.bridge.timeouts import POWER_PERIOD
from intellwheels_schemas.messages import PowerInForce
from tests.agents.bridge.readings import FakeDriver


def test_a_power_is_written_at_once_then_twenty_times_a_second_and_zero_after_silence() -> None:
    motors, driver = MotorDeadman(), FakeDriver()
    writer = MotorWriter(motors, driver, lambda: False)
    writer.step(10.0)
    motors.set_power(PowerInForce(run="a" * 16, tick=1, left_motor=0.5, right_motor=0.4), 10.01)
    times = [10.01 + 0.01 * i for i in range(60)]
    written = []
    for now in times:
        writer.step(now)
        written += [(round(now - 10.01, 2), power) for power in driver.written]
        driver.written.clear()
    moving = [at for at, power in written if power == (0.5, 0.4)]
    assert moving[0] == 0.0
    assert max(b - a for a, b in pairwise(moving)) <= POWER_PERIOD + 0.011
    assert min(at for at, power in written if power == (0.0, 0.0) and at > 0.0) <= 0.311


def test_in_lockstep_it_leaves_the_motors_to_the_laboratory() -> None:
    driver = FakeDriver()
    MotorWriter(MotorDeadman(), driver, lambda: True).step(1.0)
    assert driver.written == []


def test_the_last_power_written_is_zero() -> None:
    driver, stop = FakeDriver(), threading.Event()
    stop.set()
    MotorWriter(MotorDeadman(), driver, lambda: False).run(stop)
    assert driver.written == [(0.0, 0.0)]
