"""Lesson 1: a mind. The chair drives straight on for five seconds and stops.

Run each command in a terminal of its own:

    iw-server --map room
    iw-agent 01_first_mind.py --name chair1 --place start1

A mind is a class with the method `decide`. The harness calls it once per tick, 20 times per simulated second, with the
measures of the chair, and sends the actions that it returns. Motor powers are in [-1, 1].
"""

from intellwheels_agents import Actions, Context, Measures

DRIVING_TIME = 5.0  # s


class Mind:
    def __init__(self, context: Context) -> None:
        # `iw-agent ... --option power=0.5` changes the power.
        self.power = context.options.number("power", 0.3, 0.0, 1.0)
        self.start: float | None = None

    def decide(self, measures: Measures) -> Actions:
        if self.start is None:
            self.start = measures.time  # the simulation may have been running for a while
        power = self.power if measures.time - self.start < DRIVING_TIME else 0.0
        return Actions(left_motor=power, right_motor=power)
