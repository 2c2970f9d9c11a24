from __future__ import annotations

import threading

import msgspec
import pytest

from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.world_driver import WorldDriver, with_receiver
from intellwheels_agents.mind import Context, Make
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import (
    EncodersReading,
    GPSReading,
    Map,
    Measures,
    Pace,
    Position,
    PowerInForce,
    Sensors,
    Truth,
    UserInput,
)
from tests.agents.kinematics import PARAMETERS

CHAIR = with_receiver(robot("intellwheels"), fixes=True, noise=0.05, every=4)
RUN, LAB = "a" * 16, "b" * 16


def context(pace: Pace) -> Context:
    def fetch() -> Map:
        raise AssertionError("nobody asks for the map")

    parameters = msgspec.structs.replace(PARAMETERS, pace=pace, period=0.05)
    return Context("chair1", CHAIR, Position(x=0.0, y=0.0, heading=0.0), parameters, Options(), fetch)


def made(pace: Pace, motors: MotorDeadman | None = None) -> WorldDriver:
    laboratory = WorldDriver(CHAIR, motors or MotorDeadman(), lambda _make: 0, threading.Event())
    laboratory._begin(context(pace))
    return laboratory


def measures(tick: int, gps: GPSReading | None = None, user: UserInput | None = None) -> Measures:
    sensors = Sensors(encoders=(EncodersReading(id="wheels", left=tick, right=-tick),), gps=(gps,) if gps else ())
    return Measures(run=LAB, tick=tick, time=0.05 * tick, sensors=sensors, user_input=user)


def test_a_chair_with_a_truth_sensor_or_without_encoders_is_refused() -> None:
    knowing = msgspec.structs.replace(robot("intellwheels"), truth=(Truth(id="truth"),))
    with pytest.raises(OptionError, match="expected a robot without truth sensors"):
        with_receiver(knowing, fixes=False, noise=0.0, every=1)
    with pytest.raises(OptionError, match="expected a robot with encoders"):
        with_receiver(msgspec.structs.replace(CHAIR, encoders=()), fixes=False, noise=0.0, every=1)


def test_a_receiver_is_added_when_fixes_are_needed_and_there_is_none() -> None:
    assert [(one.noise, one.every) for one in CHAIR.gps] == [(0.05, 4)]
    assert with_receiver(CHAIR, fixes=True, noise=9.0, every=9) == CHAIR
    assert with_receiver(robot("intellwheels"), fixes=False, noise=0.1, every=4).gps == ()


def test_measures_become_readings() -> None:
    laboratory = made("realtime")
    laboratory.decide(measures(3, user=UserInput(forward=0.5, turn=-0.25)))
    (reading,) = laboratory.read()
    assert (reading.epoch, reading.seq, reading.left, reading.right) == (LAB, 3, 3, -3)
    assert (reading.forward, reading.turn) == (0.5, -0.25)
    assert laboratory.connected.is_set()
    assert laboratory.read() == []


def test_a_position_is_used_once() -> None:
    laboratory = made("realtime")
    laboratory.decide(measures(4, GPSReading(id="fix", x=1.0, y=2.0)))
    laboratory.decide(measures(5, GPSReading(id="fix", tick=4, x=1.0, y=2.0)))
    laboratory.decide(measures(8, GPSReading(id="fix", x=3.0, y=2.0)))
    laboratory.decide(measures(12, GPSReading(id="fix", status="fault")))
    assert [None if one.fix is None else (one.fix.x, one.fix.sd) for one in laboratory.read()] == [
        (1.0, 0.05), None, (3.0, 0.05), None,
    ]  # fmt: skip


def test_in_real_time_the_written_power_is_in_force() -> None:
    laboratory = made("realtime")
    assert laboratory.decide(measures(0)).left_motor == 0.0
    laboratory.write(0.5, 0.4)
    answer = laboratory.decide(measures(1))
    assert (answer.left_motor, answer.right_motor) == (0.5, 0.4)


def test_in_lockstep_the_power_of_the_tick_before_is_in_force() -> None:
    motors = MotorDeadman()
    laboratory = made("lockstep", motors)
    assert laboratory.decide(measures(0)).left_motor == 0.0
    assert laboratory.sync_tick(RUN, 0, "lockstep")
    motors.set_power(PowerInForce(run=RUN, tick=0, left_motor=0.5, right_motor=0.4), 0.05)
    laboratory.power_received(RUN, 0)
    answer = laboratory.decide(measures(1))
    assert (answer.left_motor, answer.right_motor) == (0.5, 0.4)
    assert laboratory.sync_tick(RUN, 1, "lockstep")


def test_in_lockstep_only_readings_of_the_paired_run_are_read() -> None:
    laboratory = made("lockstep")
    laboratory.decide(measures(0))
    laboratory.sync_tick(RUN, 0, "lockstep")
    laboratory.decide(msgspec.structs.replace(measures(0), run="c" * 16))
    assert [one.epoch for one in laboratory.read()] == [LAB]
    assert laboratory.read() == []
    laboratory.sync_tick("d" * 16, 0, "lockstep")
    assert [one.epoch for one in laboratory.read()] == ["c" * 16]


def test_a_run_without_ticks_counts_in_both_worlds() -> None:
    motors = MotorDeadman()
    laboratory = made("lockstep", motors)
    laboratory.decide(measures(0))
    laboratory.begin_run(RUN)  # and never a tick of it
    laboratory.decide(msgspec.structs.replace(measures(0), run="c" * 16))
    laboratory.begin_run("d" * 16)
    assert laboratory.sync_tick("d" * 16, 0, "lockstep")
    laboratory.power_received("d" * 16, 0)
    assert laboratory._pairing.await_power(0)


def test_losing_the_laboratory_for_good_ends_the_bridge() -> None:
    stop = threading.Event()

    def enter(_make: Make) -> int:
        return 4

    laboratory = WorldDriver(CHAIR, MotorDeadman(), enter, stop)
    laboratory.start()
    assert stop.wait(10.0)
    laboratory.close()
    assert laboratory.failure == "the connection to the laboratory ended with exit code 4"
