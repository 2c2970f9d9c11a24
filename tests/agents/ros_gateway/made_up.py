"""Measures and bodies for tests that need no world."""

from __future__ import annotations

from typing import Literal

from intellwheels_agents.mind import Context
from intellwheels_agents.options import Options
from intellwheels_maps import floor, robot
from intellwheels_schemas.messages import (
    EncodersReading,
    IMUReading,
    LidarReading,
    Measures,
    OdometryReading,
    Parameters,
    Position,
    Robot,
    Sensors,
    TruthReading,
)

RUN = "0123456789abcdef"
PERIOD = 0.05
FINE: tuple[Literal["ok"], ...] = ("ok",)
CHAIR = robot("lidar-chair")


def readings(x: float, tick: int | None = None, truth: tuple[float, float, float] | None = None) -> Sensors:
    """Return the readings of the lidar chair after x metres straight on."""
    rays = CHAIR.lidar[0].rays
    counts = round(x * 2000 / (3.14159265 * 0.368))
    return Sensors(
        lidar=(LidarReading(
            id="lidar", start_deg=-135.0, step_deg=1.0, ranges=(2.0,) * rays, statuses=FINE * rays),),
        encoders=(EncodersReading(id="wheels", left=counts, right=counts),),
        odometry=(OdometryReading(id="odometry", tick=tick, x=x, y=0.0, heading=0.0),),
        imu=(IMUReading(id="imu", forward=0.1, left=0.0, turn_rate=0.0),),
        truth=() if truth is None else (TruthReading(
            id="truth", tick=tick, x=truth[0], y=truth[1], heading=truth[2], speed=0.0, turn_rate=0.0),),
    )  # fmt: skip


def measured(tick: int, sensors: Sensors | None = None, *, collision: bool = False) -> Measures:
    """Return the measures of a tick."""
    return Measures(run=RUN, tick=tick, time=tick * PERIOD, sensors=sensors, collision=collision)


def context(body: Robot = CHAIR, pace: str = "realtime") -> Context:
    """Return the context of a run that begins at (3, 2), looking along y."""
    return Context(
        agent="chair-1",
        robot=body,
        position=Position(x=3.0, y=2.0, heading=1.5707963267948966),
        parameters=Parameters(
            world="made", period=PERIOD, pace=pace,  # type: ignore[arg-type]
            say_limit=100, say_range=8.0, command_timeout=0.5, grace=3.0,
        ),
        options=Options(),
        fetch_map=lambda: floor("room"),
        run=RUN,
    )  # fmt: skip
