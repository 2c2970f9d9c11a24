"""An automatic door: a leaf that turns on its hinge, or slides.

    swing    left or right: the side to which the leaf opens, seen along its heading (default left)
    hold     seconds that it stays open after it last detected somebody (default 5)
    range    distance within which it obeys the message "open", m (default 3)
    time     seconds that a full opening takes (default 4)
    angle    angle of a full opening, degrees (default 90)
    slide    distance of a full opening of a leaf that slides forward, m; 0 for one that turns (default 0)

It opens when a sensor on its frame sees something nearer than the background, or when an agent nearby says "open". It
closes when the hold time has passed and nothing is detected. If it detects or touches something while it closes, it
opens again. The first readings of a sensor are its background, so the door must start with nothing in front of it.
"""

from __future__ import annotations

import math
from enum import Enum

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.portable_math import cos, sin
from intellwheels_agents.range_scan import distance
from intellwheels_schemas.messages import Actions, Measures, Proximity

NEARER = 0.05
"""Smallest difference to the background that counts as somebody, m."""
BACKGROUND_READINGS = 10
"""Readings from which the background is learned: half a second at 20 Hz."""
DETECTIONS = 2
"""Successive near readings that count as a detection: a single one may be noise."""
ARRIVED = math.radians(0.5)
"""Angle to the target at which the moving leaf has arrived."""
STAYS = math.radians(1.5)
"""Angle to the target up to which a resting leaf stays: noise must not make it rattle."""
SLID = 0.005
"""Distance to the target at which a sliding leaf has arrived, m."""
SLID_STAYS = 0.015
"""Distance to the target up to which a resting leaf that slides stays, m."""
COMPASS_SHARE = 0.005
"""Gain of the compass. It keeps a twentieth of the noise; a hinge does not slip, so the encoders hardly drift."""


class State(Enum):
    """The state of a door. The value is the message that the door sends."""

    CLOSED = "door closed"
    OPENING = "door opening"
    OPEN = "door open"
    CLOSING = "door closing"


class Detector:
    """One sensor, and the background that it sees when the space in front of it is free.

    Attributes:
        somebody: Whether the sensor sees something nearer than its background.
    """

    def __init__(self, sensor: Proximity) -> None:
        self._sensor = sensor
        self._first: list[float] = []
        self._threshold = math.inf
        self._nearer = 0
        self.somebody = False

    def update(self, metres: float | None) -> None:
        """Update with a reading in m; None, from a failed sensor, changes nothing."""
        if metres is None:
            return
        metres = min(metres, self._sensor.max_range)
        if len(self._first) < BACKGROUND_READINGS:
            self._first.append(metres)
            if len(self._first) == BACKGROUND_READINGS:
                # The noisier the sensor, the larger the difference that counts.
                spread = max(self._first) - min(self._first)
                background = sorted(self._first)[BACKGROUND_READINGS // 2]
                self._threshold = background - max(NEARER, spread)
            return
        self._nearer = self._nearer + 1 if metres < self._threshold else 0
        self.somebody = self._nearer >= DETECTIONS


class Mind:
    """Opens and closes the door."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        self._robot = robot
        self._sign = 1.0 if options.choice("swing", ("left", "right"), "left") == "left" else -1.0
        self._hold = options.number("hold", 5.0, 0.0, 3600.0)
        self._range = options.number("range", 3.0, 0.0, 1000.0)
        self._angle = math.radians(options.number("angle", 90.0, 10.0, 180.0))
        self._slide = options.number("slide", 0.0, 0.0, 10.0)
        self._full = self._slide or self._angle
        self._rate = self._full / options.number("time", 4.0, 0.5, 60.0)
        self._detectors = {
            sensor.id: (sensor, Detector(sensor)) for sensor in robot.proximity if sensor.mount == "start"
        }
        self._pose = Odometry(robot, context.position, COMPASS_SHARE if robot.encoders else 1.0)
        self._closed = context.position
        self._state = State.CLOSED
        self._announced: State | None = None
        self._detected_at = -math.inf
        self._period = context.parameters.period

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that turn the leaf, and the door's state as a message whenever it changes."""
        self._pose.update(measures.sensors)
        wanted = self._wanted(measures)
        error = (self._full if wanted else 0.0) - self._opened()
        resting = self._state is (State.OPEN if wanted else State.CLOSED)
        stays, arrived = (SLID_STAYS, SLID) if self._slide else (STAYS, ARRIVED)
        there = abs(error) < (stays if resting else arrived)
        if wanted:
            self._state = State.OPEN if there or self._state is State.OPEN else State.OPENING
        else:
            self._state = State.CLOSED if there or self._state is State.CLOSED else State.CLOSING
        # Near the end the rate is such that the rest would take three ticks, so that the leaf does not overshoot.
        rate = min(self._rate, abs(error) / (3.0 * self._period))
        if there:
            rate = 0.0
        signed = math.copysign(rate, error)
        left, right = powers(self._robot, signed if self._slide else 0.0, 0.0 if self._slide else signed * self._sign)
        say = self._state.value if self._state is not self._announced else None
        self._announced = self._state
        return Actions(left_motor=left, right_motor=right, mode=self._state.name.lower(), say=say)

    def _opened(self) -> float:
        """Return how far the leaf is open, in radians, or in m if it slides."""
        if not self._slide:
            return self._sign * wrapped(self._pose.heading - self._closed.heading)
        heading = self._closed.heading
        return (self._pose.x - self._closed.x) * cos(heading) + (self._pose.y - self._closed.y) * sin(heading)

    def _wanted(self, measures: Measures) -> bool:
        """Return whether the door should be open."""
        somebody = self._detects_somebody(measures) or self._hears_open(measures)
        closing = self._state is State.CLOSING
        if somebody or (closing and (measures.collision or measures.contact)):
            self._detected_at = measures.time
            return True
        if self._state is State.OPENING:
            return True
        if self._state is State.OPEN:
            return measures.time - self._detected_at < self._hold
        return False

    def _detects_somebody(self, measures: Measures) -> bool:
        if measures.sensors is not None:
            for reading in measures.sensors.proximity:
                entry = self._detectors.get(reading.id)
                # A sensor slower than the simulation repeats its last reading, which must count once only.
                if entry is not None and (reading.tick is None or reading.tick == measures.tick):
                    sensor, detector = entry
                    detector.update(distance(reading, sensor))
        return any(detector.somebody for _sensor, detector in self._detectors.values())

    def _hears_open(self, measures: Measures) -> bool:
        return any(
            message.distance <= self._range and message.text.strip().lower() == "open" for message in measures.message
        )
