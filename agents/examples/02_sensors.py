"""Lesson 2: sensors. The chair drives straight on and turns left by 90 degrees before it reaches a wall.

Run each command in a terminal of its own:

    iw-server --map square
    iw-agent 02_sensors.py --name chair1 --robot mid-wheel

The robot has eight proximity sensors, encoders, a compass and a bumper. Its file is
maps/intellwheels_maps/robots/mid-wheel.xml.
"""

import math

from intellwheels_agents import Actions, Context, Measures
from intellwheels_schemas.messages import ProximityReading

FAR = 4.0  # m: the range of the proximity sensors
TURN_AT = 0.9  # m: the chair turns when the clearance ahead is smaller


class Mind:
    def __init__(self, context: Context) -> None:
        self.power = context.options.number("power", 0.3, 0.0, 1.0)
        self.target: float | None = None  # the heading to turn to, rad

    def decide(self, measures: Measures) -> Actions:
        sensors = measures.sensors
        if sensors is None or sensors.compass[0].value is None:
            return Actions(left_motor=0.0, right_motor=0.0)
        heading = sensors.compass[0].value
        # The sensors front, front-left and front-right.
        ahead = min(clearance(reading) for reading in sensors.proximity if reading.id.startswith("front"))
        if self.target is None and (ahead < TURN_AT or measures.contact):
            self.target = heading + math.pi / 2.0
        if self.target is not None:
            error = math.remainder(self.target - heading, math.tau)
            if abs(error) > 0.03:
                turn = max(-0.2, min(0.2, 0.5 * error))
                return Actions(left_motor=-turn, right_motor=turn, mode="turning")
            self.target = None
        return Actions(left_motor=self.power, right_motor=self.power, mode="driving")


def clearance(reading: ProximityReading) -> float:
    """Return the measured range in m; without a value, the status gives the reason."""
    if reading.value is not None:
        return reading.value
    return FAR if reading.status == "none" else 0.0
