"""The filter finds the way back to the true pose, with a lidar and with cones, and its noise repeats."""

from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_agents.minds.navigate import equip
from intellwheels_agents.navigation.footprint_clearance import solids_of
from intellwheels_agents.navigation.map_distance import MapDistance
from intellwheels_agents.navigation.particle_pose import ParticlePose
from intellwheels_agents.navigation.scan_points import Pose, ScanPoints
from intellwheels_agents.options import Options
from intellwheels_maps import floor, robot
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Actions, Position
from intellwheels_server.world import Setup, advance, apply, begin, measures
from intellwheels_server.world.kernels import rows


def driven(lidar: bool, ticks: int = 500) -> tuple[list[float], Pose, tuple[float, float]]:
    """Return how far off the filter and odometry alone were, on a chair with wrong wheels in the corridor."""
    from intellwheels_agents.differential_drive import Odometry

    document = floor("ward")
    body = msgspec.structs.replace(robot("corridor-chair"), wheel_ratio=1.01, wheel_scale=1.02, odometry=())
    body = equip(body, Options({"lidar": "true" if lidar else "false"}))
    state = begin(Setup(floor=document, seed="1", period=0.05, strict=True), run="0123456789abcdef")
    wanted = msgspec.structs.replace(body, format=None, position=Position(x=2.0, y=0.0, heading=0.0))
    state, outputs = apply(state, [Join(agent="chair", robot=wanted)])
    start, accepted = outputs.outcomes[0].position, outputs.outcomes[0].robot
    assert start is not None
    assert accepted is not None
    height = accepted.lidar[0].z if lidar else 0.4
    found = ParticlePose(accepted, start, MapDistance(solids_of(document), height), "chair")
    alone = Odometry(accepted, start)
    scan = ScanPoints(accepted)
    off = []
    for tick in range(ticks):
        measured = measures(state, "chair")
        x, y, heading = found.update(measured, scan.update(measured))
        alone.update(measured.sensors)
        true_x, true_y, true_heading = state.numbers[[rows.X, rows.Y, rows.HEADING], 0].tolist()
        off.append(math.hypot(x - true_x, y - true_y) + abs(math.remainder(heading - true_heading, math.tau)))
        swing = 0.04 * math.sin(0.05 * tick)
        bias = -0.3 * (true_heading + 0.5 * true_y)
        power = Actions(left_motor=0.6 - swing - bias, right_motor=0.6 + swing + bias)
        state, _ = advance(state, Inputs(actions={"chair": power}))
    return off, found.pose, (alone.x - true_x, alone.y - true_y)


@pytest.mark.parametrize(("lidar", "most"), [(True, 0.12), (False, 0.3)])
def test_filter_stays_near_the_true_pose(lidar: bool, most: float) -> None:
    off, _, alone = driven(lidar)
    assert max(off) < most
    assert math.hypot(*alone) > 2.0 * off[-1]


def test_noise_repeats() -> None:
    assert driven(True, 40)[1] == driven(True, 40)[1]
