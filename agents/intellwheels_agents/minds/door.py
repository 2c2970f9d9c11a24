"""An automatic door: a leaf that turns on its hinge.

    swing    left or right: which way the leaf turns to open, seen along its heading (default left)
    hold     seconds it stays open after it last saw somebody (default 5)
    range    metres within which it listens to "open" (default 3)
    time     seconds a whole opening takes (default 4)
    angle    degrees of a whole opening (default 90)

It opens when a sensor on its frame sees something nearer than its background, or when it is told "open". It closes
when its hold has passed and nothing is seen, and opens again when it sees or touches something meanwhile. What the
sensors see first is their background, so nobody may stand before a door when it starts.
"""

from __future__ import annotations

import math
from enum import Enum

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.range_scan import distance
from intellwheels_schemas.messages import Actions, Measures, Proximity

NEARER = 0.05
"""Metres nearer than the background that are somebody."""
LEARNING = 10
"""Readings a background is learned from: half a second at 20 Hz."""
SURE = 2
"""Readings in a row that make somebody: one alone may be noise."""
CLOSE_ENOUGH = math.radians(0.5)
"""An angle that counts as there when it comes near."""
STILL = math.radians(1.5)
"""An angle that counts as there when it was: noise must not rattle the leaf."""
COMPASS_SHARE = 0.005
"""Leaves a twentieth of the compass' noise: a hinge does not slip, so encoders hardly drift."""


class State(Enum):
    """What a door is doing; the value is what it says."""

    CLOSED = "door closed"
    OPENING = "door opening"
    OPEN = "door open"
    CLOSING = "door closing"


class Watch:
    """One sensor and what it sees when nobody is there.

    Attributes:
        somebody: Whether it sees something nearer than that.
    """

    def __init__(self, sensor: Proximity) -> None:
        self._sensor = sensor
        self._first: list[float] = []
        self._threshold = math.inf
        self._nearer = 0
        self.somebody = False

    def update(self, metres: float | None) -> None:
        """Take a reading; None, a failed one, changes nothing."""
        if metres is None:
            return
        metres = min(metres, self._sensor.max_range)
        if len(self._first) < LEARNING:
            self._first.append(metres)
            if len(self._first) == LEARNING:
                # A noisy sensor's background is wide, and only what is clearly nearer is somebody.
                spread = max(self._first) - min(self._first)
                background = sorted(self._first)[LEARNING // 2]
                self._threshold = background - max(NEARER, spread)
            return
        self._nearer = self._nearer + 1 if metres < self._threshold else 0
        self.somebody = self._nearer >= SURE


class Mind:
    """Opens and closes."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        self._robot = robot
        self._sign = 1.0 if options.choice("swing", ("left", "right"), "left") == "left" else -1.0
        self._hold = options.number("hold", 5.0, 0.0, 3600.0)
        self._range = options.number("range", 3.0, 0.0, 1000.0)
        self._angle = math.radians(options.number("angle", 90.0, 10.0, 180.0))
        self._rate = self._angle / options.number("time", 4.0, 0.5, 60.0)
        self._watches = {sensor.id: (sensor, Watch(sensor)) for sensor in robot.proximity if sensor.mount == "start"}
        self._turn = Odometry(robot, context.position, COMPASS_SHARE if robot.encoders else 1.0)
        self._closed = context.position.heading
        self._state = State.CLOSED
        self._told: State | None = None
        self._seen_at = -math.inf
        self._period = context.parameters.period

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that turn the leaf, and its state when that changed."""
        self._turn.update(measures.sensors)
        opened = self._sign * wrapped(self._turn.heading - self._closed)
        wanted = self._wanted(measures)
        error = (self._angle if wanted else 0.0) - opened
        resting = self._state is (State.OPEN if wanted else State.CLOSED)
        there = abs(error) < (STILL if resting else CLOSE_ENOUGH)
        if wanted:
            self._state = State.OPEN if there or self._state is State.OPEN else State.OPENING
        else:
            self._state = State.CLOSED if there or self._state is State.CLOSED else State.CLOSING
        # The last degree is turned at the speed that ends it in three cycles, so that it is not overshot.
        rate = min(self._rate, abs(error) / (3.0 * self._period))
        if there:
            rate = 0.0
        left, right = powers(self._robot, 0.0, math.copysign(rate, error) * self._sign)
        say = self._state.value if self._state is not self._told else None
        self._told = self._state
        return Actions(left_motor=left, right_motor=right, mode=self._state.name.lower(), say=say)

    def _wanted(self, measures: Measures) -> bool:
        """Return whether the door should be open."""
        somebody = self._sees_somebody(measures) or self._is_told(measures)
        closing = self._state is State.CLOSING
        if somebody or (closing and (measures.collision or measures.contact)):
            self._seen_at = measures.time
            return True
        if self._state is State.OPENING:
            return True
        if self._state is State.OPEN:
            return measures.time - self._seen_at < self._hold
        return False

    def _sees_somebody(self, measures: Measures) -> bool:
        if measures.sensors is not None:
            for reading in measures.sensors.proximity:
                entry = self._watches.get(reading.id)
                # A sensor with a rate of its own repeats its reading: once is enough.
                if entry is not None and (reading.tick is None or reading.tick == measures.tick):
                    sensor, watch = entry
                    watch.update(distance(reading, sensor))
        return any(watch.somebody for _sensor, watch in self._watches.values())

    def _is_told(self, measures: Measures) -> bool:
        return any(
            message.distance <= self._range and message.text.strip().lower() == "open" for message in measures.message
        )
