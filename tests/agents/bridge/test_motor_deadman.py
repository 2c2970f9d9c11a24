from __future__ import annotations

from intellwheels_agents.bridge.line_faults import Faults
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.resume_gate import ResumeGate
from intellwheels_schemas.messages import PowerInForce


def power(tick: int, left: float, run: str = "a" * 16) -> PowerInForce:
    return PowerInForce(run=run, tick=tick, left_motor=left, right_motor=-left)


def test_a_power_is_in_force_for_0_3_s_and_no_longer() -> None:
    motors = MotorDeadman()
    assert motors.output(0.0) == (0.0, 0.0)
    motors.set_power(power(1, 0.5), 10.0)
    assert motors.output(10.3) == (0.5, -0.5)
    assert motors.output(10.31) == (0.0, 0.0)
    motors.set_power(power(2, 0.4), 11.0)
    assert motors.output(11.0) == (0.4, -0.4)


def test_an_overtaken_power_is_not_obeyed() -> None:
    motors = MotorDeadman()
    motors.set_power(power(5, 0.5), 0.0)
    motors.set_power(power(4, 0.9), 0.1)
    assert motors.output(0.1) == (0.5, -0.5)
    motors.set_power(power(0, 0.1, "b" * 16), 0.2)
    assert motors.output(0.2) == (0.1, -0.1)


def test_on_a_delayed_line_the_silence_counts_from_the_arrival() -> None:
    motors = MotorDeadman(Faults(delay=0.2))
    motors.set_power(power(1, 0.5), 0.0)
    assert motors.output(0.19) == (0.0, 0.0)
    assert motors.output(0.49) == (0.5, -0.5)
    assert motors.output(0.51) == (0.0, 0.0)


def test_a_new_run_starts_with_zero_power() -> None:
    motors = MotorDeadman(Faults(delay=0.1))
    motors.set_power(power(1, 0.5), 0.0)
    motors.output(0.1)
    motors.set_power(power(2, 0.6), 0.1)
    motors.reset()
    assert motors.output(0.2) == (0.0, 0.0)


def test_a_closed_gate_keeps_the_motors_off_whatever_arrives() -> None:
    gate = ResumeGate("chair1", confirm=True, clock=lambda: 0.0)
    motors = MotorDeadman(gate=gate)
    gate.joined()
    motors.set_power(power(1, 0.5), 10.0)
    assert motors.output(10.0) == (0.5, -0.5)
    gate.interrupted("simulator-gone")
    motors.set_power(power(2, 0.5), 10.1)
    assert motors.output(10.1) == (0.0, 0.0)
    gate.confirmed()
    assert motors.output(10.1) == (0.5, -0.5)
