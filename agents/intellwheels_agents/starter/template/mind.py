"""A chair that drives where there is room: make it yours.

`decide` is asked once a tick, 20 times a simulated second, with what the sensors of `robot.xml` measure.
"""

from intellwheels_agents import Actions, Context, Measures

FAR = 4.0  # m: nothing is in sight


class Mind:
    def __init__(self, context: Context) -> None:
        self.power = context.options.number("power", 0.5, 0.0, 1.0)

    def decide(self, measures: Measures) -> Actions:
        see = {"left": FAR, "front": FAR, "right": FAR}
        for reading in measures.sensors.proximity if measures.sensors else ():
            if reading.value is not None:
                see[reading.id] = reading.value
            elif reading.status == "near":
                see[reading.id] = 0.0
        room = min(see.values())
        if room < 0.8:  # slowly round, in place, until the way is free
            return Actions(left_motor=-0.15, right_motor=0.15)
        forward = self.power * min(1.0, room - 0.5)
        bend = 0.05 * (see["left"] - see["right"])
        return Actions(left_motor=forward - bend, right_motor=forward + bend)
