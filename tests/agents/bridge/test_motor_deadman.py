from __future__ import annotations

from intellwheels_agents.bridge.line_faults import Faults
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_schemas.messages import PowerInForce


def power(tick: int, left: float, run: str = "a" * 16) -> PowerInForce:
    return PowerInForce(run=run, tick=tick, left_motor=left, right_motor=-left)


def test_a_power_is_given_for_three_tenths_of_a_second_and_no_longer() -> None:
    motors = MotorDeadman()
    assert motors.output(0.0) == (0.0, 0.0)
    motors.obey(power(1, 0.5), 10.0)
    assert motors.output(10.3) == (0.5, -0.5)
    assert motors.output(10.31) == (0.0, 0.0)
    motors.obey(power(2, 0.4), 11.0)
    assert motors.output(11.0) == (0.4, -0.4)


def test_an_overtaken_power_is_not_obeyed() -> None:
    motors = MotorDeadman()
    motors.obey(power(5, 0.5), 0.0)
    motors.obey(power(4, 0.9), 0.1)
    assert motors.output(0.1) == (0.5, -0.5)
    motors.obey(power(0, 0.1, "b" * 16), 0.2)
    assert motors.output(0.2) == (0.1, -0.1)


def test_a_late_line_counts_silence_from_the_arrival() -> None:
    motors = MotorDeadman(Faults(delay=0.2))
    motors.obey(power(1, 0.5), 0.0)
    assert motors.output(0.19) == (0.0, 0.0)
    assert motors.output(0.49) == (0.5, -0.5)
    assert motors.output(0.51) == (0.0, 0.0)


def test_a_new_run_begins_at_rest() -> None:
    motors = MotorDeadman(Faults(delay=0.1))
    motors.obey(power(1, 0.5), 0.0)
    motors.output(0.1)
    motors.obey(power(2, 0.6), 0.1)
    motors.renew()
    assert motors.output(0.2) == (0.0, 0.0)
