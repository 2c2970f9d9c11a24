"""The motors follow as in the simulated world, and the lateness of commands is measured with the wheels."""

from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_agents.wheel_motors import LATEST, STILL, CommandLateness, Motors, SafeSpeed, Wheels
from intellwheels_maps import robot
from intellwheels_schemas.messages import EncodersReading, Measures, Robot
from intellwheels_server.world.kernels.motor_model import lag, wheel_cycle
from tests.agents.kinematics import RUN
from tests.every_case import every_case

CHAIR = robot("rear-wheel")


@every_case("period", [0.01, 0.05, 0.2])
@every_case("curve", [0.0, 0.6, 0.95])
@every_case("limit", [None, 0.3])
def test_cycle_is_that_of_the_world(period: float, curve: float, limit: float | None) -> None:
    motors = Motors.of(msgspec.structs.replace(CHAIR, acceleration_curve=curve, acceleration_limit=limit), period)
    now, wanted = 0.1, 0.7
    speeds, travels = motors.cycle(Wheels(now, now), Wheels(wanted, 0.0))
    most = math.inf if limit is None else limit
    for speed, travel, goal in ((speeds.left, travels.left, wanted), (speeds.right, travels.right, 0.0)):
        assert (speed, travel) == pytest.approx(wheel_cycle(now, goal, *lag(curve, period), most, 1.0, period))


def test_stopping_takes_the_braking_distance() -> None:
    motors = Motors.of(msgspec.structs.replace(CHAIR, acceleration_curve=0.0, acceleration_limit=0.5), 0.05)
    assert motors.stopping(1.0) == pytest.approx(1.0, abs=0.01)
    assert Motors.of(msgspec.structs.replace(CHAIR, acceleration_curve=0.0), 0.05).stopping(1.0) == 0.0


def test_safe_speed_ends_within_sight() -> None:
    motors = Motors.of(msgspec.structs.replace(CHAIR, acceleration_curve=0.0, acceleration_limit=0.5), 0.05)
    safe = SafeSpeed(motors, 1.0, 0.5)
    fast, slow = safe.after(0.0), safe.after(0.5)
    assert fast == pytest.approx(math.sqrt(0.5), abs=0.03)
    assert slow * 0.5 + motors.stopping(slow) <= 0.5
    assert slow < fast
    assert SafeSpeed(motors, 1.0, 9.0).after(0.0) >= 1.0


def driven(late: int, encoders_late: int, period: float, body: Robot = CHAIR) -> tuple[CommandLateness, list[Wheels]]:
    """Let a chair start and stop, with commands and encoders so late; return what was measured, and the speeds."""
    measuring, motors = CommandLateness(body, period), Motors.of(body, period)
    per_count = math.pi * body.wheel_diameter / body.encoder_ticks
    sent = [Wheels(0.6, 0.4) if tick // 20 % 2 == 0 else STILL for tick in range(50)]
    speeds, rolled, counts = [STILL], [0.0, 0.0], [(0, 0)]
    for tick in range(50):
        if tick >= encoders_late:
            left, right = counts[tick - encoders_late]
            stamp = tick - encoders_late if encoders_late else None
            reading = EncodersReading(id="wheels", left=left, right=right, tick=stamp)
            measuring.update(Measures(run=RUN, tick=tick, time=tick * period), reading)
        measuring.send(tick, sent[tick])
        now, travel = motors.cycle(speeds[-1], sent[tick - late] if tick >= late else STILL)
        speeds.append(now)
        rolled = [rolled[0] + travel.left, rolled[1] + travel.right]
        counts.append((math.floor(rolled[0] / per_count), math.floor(rolled[1] / per_count)))
    return measuring, speeds


@every_case("period", [0.02, 0.05, 0.2])
@every_case("late", [0, 1, 4])
@every_case("encoders_late", [0, 2])
def test_lateness_of_commands_is_found(late: int, encoders_late: int, period: float) -> None:
    measuring, speeds = driven(late, encoders_late, period)
    assert measuring.ticks == late
    assert measuring.tick == 49 - encoders_late
    known = speeds[49 - encoders_late]
    assert (measuring.speeds.left, measuring.speeds.right) == pytest.approx((known.left, known.right), abs=0.06)
    assert len(measuring.pending(49)) == late + encoders_late


def test_before_anything_moved_the_longest_lateness_counts() -> None:
    assert CommandLateness(CHAIR, 0.05).ticks == LATEST


def test_wheels_that_are_blocked_are_believed() -> None:
    measuring = CommandLateness(CHAIR, 0.05)
    for tick in range(20):
        measuring.update(Measures(run=RUN, tick=tick, time=0.05 * tick), EncodersReading(id="wheels", left=0, right=0))
        measuring.send(tick, Wheels(0.5, 0.5))
    assert measuring.speeds == STILL


@every_case("curve", [0.0, 0.5, 0.95])
@every_case("limit", [None, 0.3, 2.0])
def test_run_out_is_the_way_of_short_cycles_until_the_body_stands(curve: float, limit: float | None) -> None:
    body = msgspec.structs.replace(CHAIR, acceleration_curve=curve, acceleration_limit=limit)
    short = Motors.of(body, 0.001)
    # `stopping` ends at 5 mm/s, and its limit acts on whole cycles.
    assert Motors.of(body, 0.05).run_out(0.8) == pytest.approx(short.stopping(0.8), abs=0.01)
    assert Motors.of(body, 0.05).run_out(-0.8) == -Motors.of(body, 0.05).run_out(0.8)
