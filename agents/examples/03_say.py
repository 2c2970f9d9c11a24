"""Lesson 3: messages. The chair asks an automatic door to open, waits for its answer, and drives through.

Run each command in a terminal of its own:

    iw-server --map door
    iw-agent door --name door --place hinge --option swing=right --option Proximity.MaxRange=1
    iw-agent 03_say.py --name chair1 --robot rear-wheel --place start

The sensors of this door have a range of only 1 m. Without the message it would open too late. All agents within 8 m
receive a message, one tick later.
"""

from intellwheels_agents import Actions, Context, Measures

FAR = 9.0  # m: nothing in sight


class Mind:
    def __init__(self, context: Context) -> None:
        self.power = context.options.number("power", 0.4, 0.0, 1.0)
        self.open = False
        self.say_at = 0.0

    def decide(self, measures: Measures) -> Actions:
        for message in measures.message:
            if message.sender == "door" and message.text == "door open":
                self.open = True
        readings = measures.sensors.proximity if measures.sensors else ()
        ahead = next((reading.value for reading in readings if reading.id == "front" and reading.value), FAR)
        if not self.open and ahead < 1.8:  # the door listens to agents within 3 m
            say = None
            if measures.time >= self.say_at:
                say, self.say_at = "open", measures.time + 1.0
            return Actions(left_motor=0.0, right_motor=0.0, mode="asking", say=say)
        power = self.power if ahead > 1.0 else 0.0
        return Actions(left_motor=power, right_motor=power, mode="driving")
