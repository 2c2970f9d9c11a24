"""A real chair's document in the simulation, and its readings there. Pure.

    sensors   what its mind perceives
    virtual   the sensors of the robot's file, measured by the simulator at the reported pose
    real      the chair's own sonars, under their own names, and no virtual ones
    both      the virtual ones, and the chair's own as `real-<id>`

Encoders and odometry are the chair's in any case: the simulator never turns its wheels.
"""

from __future__ import annotations

import math
from typing import Final, Literal, get_args

import msgspec

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.pose_source import PoseSource
from intellwheels_agents.differential_drive import wrapped
from intellwheels_schemas.messages import (
    EncodersReading,
    OdometryReading,
    Position,
    Robot,
    Sensors,
)

SensorsName = Literal["virtual", "real", "both"]
SENSORS: Final = get_args(SensorsName)
PREFIX: Final = "real-"


class SensorMerge:
    """What a real chair wears in the simulation.

    Attributes:
        robot: The document to join with, but for name, role and instance.
    """

    def __init__(
        self, robot: Robot, chair: Robot, sensors: SensorsName, hardware: Literal["real", "simulated"] = "real"
    ) -> None:
        """Make the document.

        Args:
            robot: The body with its virtual sensors.
            chair: The chair as built, with its own sonars.
            sensors: Which of them its mind perceives.
            hardware: Whether the chair is one of another simulation.
        """
        prefix = PREFIX if sensors == "both" else ""
        own = () if sensors == "virtual" else chair.proximity
        self._names = {sensor.id: prefix + sensor.id for sensor in own}
        # Its rate, latency and errors are in its readings; the simulator must not be told of them.
        forwarded = tuple(
            msgspec.structs.replace(
                sensor, id=self._names[sensor.id], source="real", every=1, latency=0, model="ideal", dropout=0.0,
                crosstalk=0.0, group=0,
            )
            for sensor in own
        )  # fmt: skip
        self.robot = msgspec.structs.replace(
            robot,
            type="real",
            hardware=hardware,
            wheel_ratio=1.0,
            wheel_scale=1.0,
            track_ratio=1.0,
            proximity=(() if sensors == "real" else robot.proximity) + forwarded,
            encoders=tuple(msgspec.structs.replace(one, source="real", drift=0.0) for one in robot.encoders),
            odometry=tuple(msgspec.structs.replace(one, source="real") for one in robot.odometry),
        )

    def forward(self, reading: Reading, source: PoseSource) -> Sensors:
        """Return the chair's own readings as its mind will have them."""
        estimate = source.estimate
        x, y, heading = _relative(source.start, estimate.x, estimate.y, estimate.heading) if estimate else (0, 0, 0)
        return Sensors(
            proximity=tuple(
                msgspec.structs.replace(one, id=self._names[one.id], tick=None)
                for one in reading.proximity
                if one.id in self._names
            ),
            encoders=tuple(
                EncodersReading(id=one.id, left=source.left, right=source.right) for one in self.robot.encoders
            ),
            odometry=tuple(OdometryReading(id=one.id, x=x, y=y, heading=heading) for one in self.robot.odometry),
        )


def _relative(start: Position, x: float, y: float, heading: float) -> tuple[float, float, float]:
    """Return a pose as seen from the start."""
    dx, dy, cos, sin = x - start.x, y - start.y, math.cos(start.heading), math.sin(start.heading)
    return dx * cos + dy * sin, dy * cos - dx * sin, wrapped(heading - start.heading)
