"""A real chair's robot document in the simulation, and its own readings there. Pure.

    sensors   what the chair's mind gets
    virtual   the sensors of the robot file, measured by the simulator at the reported pose
    real      the chair's own sonars, under their own ids, and no virtual ones
    both      the virtual ones, and the chair's own sonars as `real-<id>`

With `real` and `both` the chair's own inertial unit counts like a sonar, if the driver reads one.

Encoders and odometry are always the chair's own: the simulator does not turn the wheels of a real chair.
"""

from __future__ import annotations

from typing import Final, Literal, get_args

import msgspec

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.pose_source import PoseSource
from intellwheels_agents.differential_drive import wrapped
from intellwheels_agents.portable_math import sincos
from intellwheels_schemas.messages import IMU, EncodersReading, IMUReading, OdometryReading, Position, Robot, Sensors

SensorsName = Literal["virtual", "real", "both"]
SENSORS: Final = get_args(SensorsName)
PREFIX: Final = "real-"


class SensorMerge:
    """The sensors of a real chair in the simulation.

    Attributes:
        robot: The document to join with, without name, role and instance.
    """

    def __init__(
        self,
        robot: Robot,
        chair: Robot,
        sensors: SensorsName,
        hardware: Literal["real", "simulated"] = "real",
        *,
        has_motion: bool = False,
    ) -> None:
        """Create the document.

        Args:
            robot: The body with its virtual sensors.
            chair: The chair as built, with its own sonars.
            sensors: Which of the two the mind gets.
            hardware: `simulated` when the chair is one of another simulation.
            has_motion: Whether its driver reads an inertial unit; the one that the chair declares is then the real one.
        """
        prefix = PREFIX if sensors == "both" else ""
        own = () if sensors == "virtual" else chair.proximity
        self._names = {sensor.id: prefix + sensor.id for sensor in own}
        # Rate, latency and errors are in the readings already; the simulator must not add them again.
        forwarded = tuple(
            msgspec.structs.replace(
                sensor, id=self._names[sensor.id], source="real", every=1, latency=0, model="ideal", dropout=0.0,
                device=None, crosstalk=0.0, ping_delay=0.0, second_ping_delay=0.0, group=0,
            )
            for sensor in own
        )  # fmt: skip
        units = () if sensors == "virtual" or not has_motion else chair.imu[:1]
        # Its errors are in the readings, as those of the sonars are.
        self._units = tuple(IMU(id=prefix + one.id, source="real") for one in units)
        self.robot = msgspec.structs.replace(
            robot,
            type="real",
            hardware=hardware,
            wheel_ratio=1.0,
            wheel_scale=1.0,
            track_ratio=1.0,
            proximity=(() if sensors == "real" else robot.proximity) + forwarded,
            imu=(() if sensors == "real" and has_motion else robot.imu) + self._units,
            encoders=tuple(msgspec.structs.replace(one, source="real", drift=0.0) for one in robot.encoders),
            odometry=tuple(msgspec.structs.replace(one, source="real") for one in robot.odometry),
        )

    def sensors(self, reading: Reading, source: PoseSource) -> Sensors:
        """Return the chair's own readings as its mind gets them."""
        estimate = source.estimate
        x, y, heading = _relative(source.start, estimate.x, estimate.y, estimate.heading) if estimate else (0, 0, 0)
        return Sensors(
            proximity=tuple(
                msgspec.structs.replace(one, id=self._names[one.id], tick=None)
                for one in reading.proximity
                if one.id in self._names
            ),
            imu=tuple(
                IMUReading(id=one.id, forward=reading.motion[0], left=reading.motion[1], turn_rate=reading.motion[2])
                for one in self._units
                if reading.motion is not None
            ),
            encoders=tuple(
                EncodersReading(id=one.id, left=source.left, right=source.right) for one in self.robot.encoders
            ),
            odometry=tuple(OdometryReading(id=one.id, x=x, y=y, heading=heading) for one in self.robot.odometry),
        )


def _relative(start: Position, x: float, y: float, heading: float) -> tuple[float, float, float]:
    """Return a pose relative to the start."""
    s, c = sincos(start.heading)
    dx, dy = x - start.x, y - start.y
    return c * dx + s * dy, c * dy - s * dx, wrapped(heading - start.heading)
