"""A chair that drives where there is room. Change it as you like.

The harness calls `decide` once per tick, 20 times per simulated second, with the readings of the sensors.
"""

from intellwheels_agents import Actions, Context, Measures

FAR = 4.0  # m: the range of the sensors, used where a sensor detects nothing


class Mind:
    def __init__(self, context: Context) -> None:
        self.power = context.options.number("power", 0.5, 0.0, 1.0)

    def decide(self, measures: Measures) -> Actions:
        ranges = {"left": FAR, "front": FAR, "right": FAR}
        for reading in measures.sensors.proximity if measures.sensors else ():
            if reading.value is not None:
                ranges[reading.id] = reading.value
            elif reading.status != "none":  # too near, or the sample failed
                ranges[reading.id] = 0.0
        clearance = min(ranges.values())
        if clearance < 0.8:  # turn slowly on the spot until the way is free
            return Actions(left_motor=-0.15, right_motor=0.15)
        forward = self.power * min(1.0, clearance - 0.5)
        turn = 0.05 * (ranges["left"] - ranges["right"])
        return Actions(left_motor=forward - turn, right_motor=forward + turn)
