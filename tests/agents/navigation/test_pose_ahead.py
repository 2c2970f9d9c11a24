"""The pose at which the next command acts, from late poses, encoders and commands."""

from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_agents.navigation.pose_ahead import PoseAhead
from intellwheels_agents.wheel_motors import STILL, Motors, Wheels
from intellwheels_maps import robot
from intellwheels_schemas.messages import Actions, EncodersReading, Measures, Sensors
from tests.agents.kinematics import RUN

CHAIR = robot("mid-wheel")
TICKS = 60


def expected(late: int) -> tuple[list[float], list[Wheels], list[tuple[int, int]], list[Actions]]:
    """Return a chair's x, speeds, counts and actions at each tick, on a straight drive with its commands so late."""
    motors, per_count = Motors.of(CHAIR, 0.05), math.pi * CHAIR.wheel_diameter / CHAIR.encoder_ticks
    powers = [0.5 if 5 <= tick < 25 or tick >= 40 else 0.0 for tick in range(TICKS)]
    xs, speeds, counts = [0.0], [STILL], [(0, 0)]
    for tick in range(TICKS + late):
        power = powers[min(tick - late, TICKS - 1)] if tick >= late else 0.0
        now, travel = motors.cycle(speeds[-1], Wheels(power * CHAIR.top_speed, power * CHAIR.top_speed))
        xs.append(xs[-1] + travel.left)
        speeds.append(now)
        counts.append((math.floor(xs[-1] / per_count), math.floor(xs[-1] / per_count)))
    return xs, speeds, counts, [Actions(left_motor=power, right_motor=power) for power in powers]


@pytest.mark.parametrize(("commands", "encoders", "poses"), [(0, 0, 0), (3, 0, 0), (0, 2, 2), (2, 4, 0), (2, 1, 1)])
def test_pose_at_the_next_command(commands: int, encoders: int, poses: int) -> None:
    xs, speeds, counts, sent = expected(commands)
    ahead = PoseAhead(CHAIR, 0.05, (0.0, 0.0, 0.0))
    for tick in range(TICKS):
        seen = tick - encoders
        reading = EncodersReading(id="wheels", left=counts[max(seen, 0)][0], right=counts[max(seen, 0)][1], tick=seen)
        sensors = Sensors(encoders=(reading,)) if seen >= 0 else None
        measures = Measures(run=RUN, tick=tick, time=0.05 * tick, sensors=sensors)
        known = ahead.update(measures, (xs[max(tick - poses, 0)], 0.0, 0.0), max(tick - poses, 0))
        ahead.send(tick, sent[tick])
    last = TICKS - 1
    assert ahead.pose[0] == pytest.approx(xs[last + commands], abs=0.01)
    assert ahead.speed == pytest.approx(speeds[last + commands].left, abs=0.05)
    assert ahead.rate == pytest.approx(0.0, abs=1e-9)
    assert sorted(known) == list(range(last - poses, last + 1))
    assert ahead.time == pytest.approx(0.05 * (commands + poses))
    assert ahead.blind == pytest.approx(0.05 * (commands + poses + 1))


def test_robot_without_encoders_rolls_as_its_motors_say() -> None:
    blind = msgspec.structs.replace(CHAIR, encoders=())
    xs, speeds, _, sent = expected(0)
    ahead = PoseAhead(blind, 0.05, (0.0, 0.0, 0.0))
    for tick in range(TICKS):
        ahead.update(Measures(run=RUN, tick=tick, time=0.05 * tick), (xs[tick], 0.0, 0.0), tick)
        ahead.send(tick, sent[tick])
    assert ahead.pose[0] == pytest.approx(xs[TICKS - 1])
    assert ahead.speed == pytest.approx(speeds[TICKS - 1].left)
