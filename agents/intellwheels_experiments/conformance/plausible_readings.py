"""Plausible readings for the sensors that a robot declares. They change with the tick, as real ones do."""

from __future__ import annotations

import math
from typing import Final

from intellwheels_schemas.messages import (
    BeaconReading,
    BumperReading,
    CompassReading,
    EncodersReading,
    GPSReading,
    GroundReading,
    IMUReading,
    LidarReading,
    OdometryReading,
    Proximity,
    ProximityReading,
    Robot,
    Sensors,
    Status,
    TruthReading,
)

_RAYS = 9
_OK: Final[Status] = "ok"


def readings(robot: Robot, tick: int) -> Sensors | None:
    """Return a reading of every sensor of `robot` at `tick`, or None if it has no sensors."""
    turn = 0.01 * (tick % 100)
    distance = 0.02 * tick
    sensors = Sensors(
        proximity=tuple(_proximity(one, tick + 3 * index) for index, one in enumerate(robot.proximity)),
        lidar=tuple(_lidar(one.id) for one in robot.lidar),
        encoders=tuple(EncodersReading(id=one.id, left=17 * tick, right=16 * tick) for one in robot.encoders),
        odometry=tuple(OdometryReading(id=one.id, x=distance, y=0.0, heading=turn) for one in robot.odometry),
        compass=tuple(CompassReading(id=one.id, value=turn) for one in robot.compass),
        gps=tuple(GPSReading(id=one.id, x=2.0 + distance, y=2.0) for one in robot.gps),
        imu=tuple(IMUReading(id=one.id, forward=0.0, left=0.0, turn_rate=0.01) for one in robot.imu),
        beacon=tuple(BeaconReading(id=one.id, status="none") for one in robot.beacon),
        ground=tuple(GroundReading(id=one.id) for one in robot.ground),
        bumper=tuple(BumperReading(id=one.id, value=tick % 10 == 9) for one in robot.bumper),
        truth=tuple(
            TruthReading(id=one.id, x=2.0 + distance, y=2.0, heading=turn, speed=0.4, turn_rate=0.0)
            for one in robot.truth
        ),
    )
    return sensors if sensors != Sensors() else None


def _proximity(sensor: Proximity, phase: int) -> ProximityReading:
    """Return a distance that varies within the sensor's range, or sometimes a status without one."""
    if phase % 7 == 5:
        return ProximityReading(id=sensor.id, status="none")
    if phase % 7 == 6:
        return ProximityReading(id=sensor.id, status="near")
    share = 0.5 + 0.4 * math.sin(phase)
    return ProximityReading(id=sensor.id, value=sensor.min_range + share * (sensor.max_range - sensor.min_range))


def _lidar(name: str) -> LidarReading:
    return LidarReading(
        id=name,
        start_deg=-90.0,
        step_deg=180.0 / (_RAYS - 1),
        ranges=(None, *(1.0 + 0.1 * ray for ray in range(1, _RAYS))),
        statuses=("none", *(_OK for _ in range(1, _RAYS))),
    )
