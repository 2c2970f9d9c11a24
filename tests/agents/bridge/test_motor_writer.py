from __future__ import annotations

import threading
from itertools import pairwise

from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.motor_writer import EVERY, MotorWriter
from intellwheels_schemas.messages import PowerInForce
from tests.agents.bridge.readings import Told


def test_a_power_is_written_at_once_then_twenty_times_a_second_and_zero_after_silence() -> None:
    motors, driver = MotorDeadman(), Told()
    pump = MotorWriter(motors, driver, lambda: False)
    pump.turn(10.0)
    motors.obey(PowerInForce(run="a" * 16, tick=1, left_motor=0.5, right_motor=0.4), 10.01)
    times = [10.01 + 0.01 * i for i in range(60)]
    written = []
    for now in times:
        pump.turn(now)
        written += [(round(now - 10.01, 2), power) for power in driver.written]
        driver.written.clear()
    moving = [at for at, power in written if power == (0.5, 0.4)]
    assert moving[0] == 0.0
    assert max(b - a for a, b in pairwise(moving)) <= EVERY + 0.011
    assert min(at for at, power in written if power == (0.0, 0.0) and at > 0.0) <= 0.311


def test_in_lockstep_it_leaves_the_motors_to_the_laboratory() -> None:
    driver = Told()
    MotorWriter(MotorDeadman(), driver, lambda: True).turn(1.0)
    assert driver.written == []


def test_its_last_word_is_zero() -> None:
    driver, stop = Told(), threading.Event()
    stop.set()
    MotorWriter(MotorDeadman(), driver, lambda: False).run(stop)
    assert driver.written == [(0.0, 0.0)]
