"""What belongs to one robot of an agent: its motors, LEDs, requests, and what it senses. Pure.

The value of an obstacle sensor is the inverse of the distance, at most 100, with noise, in steps of 0.1.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from typing import Final

from intellwheels_agents.ciber_gateway import simulator_messages
from intellwheels_agents.ciber_gateway.ciber_robot import MOST_POWER
from intellwheels_agents.ciber_gateway.client_messages import IR_ANGLES, Orders
from intellwheels_agents.ciber_gateway.lab_frame import Lab
from intellwheels_agents.ciber_gateway.simulator_messages import Leds, Readings, Settings
from intellwheels_schemas.messages import Actions, Entity, Measures, ProximityReading, Robot, Sensors

MODE: Final = "ciber"
"""Mode that the robots show."""
_NEAREST: Final = 0.01
"""Distance, m, up to which an obstacle sensor gives its largest value."""
_KINDS: Final = {"IRSensor": "obstacle", "Beacon": "beacon", "Ground": "ground", "Compass": "compass",
                 "Collision": "collision", "GPS": "gps"}  # fmt: skip
_SINGLE: Final = frozenset({"Ground", "Compass", "Collision", "GPS"})


class RobotState:
    """One robot.

    Attributes:
        number: Its number, from 1.
        name: The name that its agent gave it.
        agent: Its name in the contract.
        finished: Whether its agent has switched the end LED on: it does not move any more.
    """

    def __init__(self, number: int, name: str, agent: str, settings: Settings) -> None:
        """Take who it is, and the parameters of the lab."""
        self.number = number
        self.name = name
        self.agent = agent
        self._settings = settings
        self._robot = Robot()
        self._period = 0.0
        self._lab: Lab | None = None
        self._random = random.Random(0)  # noqa: S311 - the noise of a sensor
        self._restart()

    @property
    def finished(self) -> bool:
        """Whether the end LED is on."""
        return self._leds.end

    def begin(self, robot: Robot, period: float, run: str, lab: Lab) -> None:
        """Begin a run: the motors are off, and so are the LEDs.

        Args:
            robot: The robot, as the simulator accepted it.
            period: Seconds of a cycle.
            run: The run.
            lab: The lab.
        """
        self._robot, self._period, self._lab = robot, period, lab
        self._random = random.Random(f"{run} {self.agent}")  # noqa: S311 - the noise of a sensor
        self._restart()

    def _restart(self) -> None:
        self._leds = Leds()
        self._left = self._right = 0.0
        self._say: str | None = None
        self._requested: set[str] = set()
        self._collisions = 0
        self._collides = False
        self._visited: set[int] = set()
        self._last: tuple[int, Readings] = (0, Readings())

    def obey(self, orders: Orders) -> int:
        """Take the orders of the agent; return how many of its requests are too many, or of no sensor."""
        self._left = self._left if orders.left is None else orders.left
        self._right = self._right if orders.right is None else orders.right
        self._say = orders.say or self._say
        leds = self._leds
        self._leds = Leds(
            leds.end or bool(orders.end_led),
            leds.returning if orders.returning_led is None else orders.returning_led,
            leds.visiting if orders.visiting_led is None else orders.visiting_led,
        )
        refused = 0
        beacons = 0 if self._lab is None else len(self._lab.beacons)
        numbered = {f"IRSensor{index}" for index in range(len(IR_ANGLES))} | {f"Beacon{i}" for i in range(beacons)}
        for wanted in orders.requests:
            if wanted not in _SINGLE | numbered or len(self._requested) >= self._settings.requests:
                refused += 1
            else:
                self._requested.add(wanted)
        return refused

    def actions(self) -> Actions:
        """Return the actions of a tick: the latest powers, and what the agent says, once."""
        left, right = (0.0, 0.0) if self.finished else (self._share(self._left), self._share(self._right))
        say, self._say = self._say, None
        return Actions(left_motor=left, right_motor=right, mode=MODE, say=say)

    def _share(self, power: float) -> float:
        """Return a power of the contract for one of a motor: the travel in a cycle."""
        travel = min(max(power, -MOST_POWER), MOST_POWER)
        return min(max(travel / (self._period * self._robot.top_speed), -1.0), 1.0)

    def sense(self, measures: Measures, numbers: Mapping[str, int]) -> bytes:
        """Return the measures of a tick for the agent.

        Args:
            measures: Those of the contract.
            numbers: The numbers of the robots by agent; others that speak have number 0.
        """
        self._collisions += measures.collision and not self._collides
        self._collides = measures.collision
        readings = self._readings(measures, numbers)
        self._last = measures.tick, readings
        self._requested.clear()
        return simulator_messages.measures(measures.tick, readings, self._leds, running=True)

    def stopped(self) -> bytes:
        """Return the last measures again, of a simulator that is stopped."""
        cycle, readings = self._last
        return simulator_messages.measures(cycle, readings._replace(heard=()), self._leds, running=False)

    def show(self, entity: Entity, cycle: int, *, running: bool) -> bytes:
        """Return the robot for viewers."""
        lab = self._lab
        state = "Running"
        if self.finished:
            state = "Finished"
        elif not running:
            state = "Stopped"
        elif self._leds.returning:
            state = "Returning"
        elif self._leds.visiting:
            state = "Waiting"
        west, south, targets = (0.0, 0.0, 0) if lab is None else (lab.west, lab.south, len(lab.targets))
        return simulator_messages.robot_shown(
            self.number, self.name, cycle, (entity.x - west, entity.y - south, entity.heading), state,
            collisions=self._collisions, collision=self._collides,
            visited="".join("1" if index in self._visited else "0" for index in range(targets)),
        )  # fmt: skip

    def removed(self, cycle: int) -> bytes:
        """Return for viewers that the robot is gone."""
        return simulator_messages.robot_shown(
            self.number, self.name, cycle, (0.0, 0.0, 0.0), "Removed",
            collisions=self._collisions, collision=False, visited="",
        )  # fmt: skip

    def _readings(self, measures: Measures, numbers: Mapping[str, int]) -> Readings:
        sensors = measures.sensors or Sensors()
        ground = self._ground(sensors)
        if self._leds.visiting and ground >= 0:
            self._visited.add(ground)
        compass = next((one.value for one in sensors.compass if one.value is not None), None)
        position = next(((one.x, one.y) for one in sensors.gps if one.x is not None and one.y is not None), None)
        wanted = self._wanted
        lab = self._lab
        obstacles = [(index, self._obstacle(one)) for index, one in enumerate(sensors.proximity)]
        beacons = [
            (index, one.value if one.value is None else _whole_degrees(one.value))
            for index, one in enumerate(sensors.beacon)
        ]
        return Readings(
            collision=measures.collision if wanted("Collision") else None,
            compass=_whole_degrees(compass) if compass is not None and wanted("Compass") else None,
            ground=ground if wanted("Ground") else None,
            obstacles=[one for one in obstacles if wanted(f"IRSensor{one[0]}")],
            beacons=[one for one in beacons if wanted(f"Beacon{one[0]}")],
            gps=None if position is None or lab is None or not wanted("GPS")
            else (position[0] - lab.west, position[1] - lab.south),
            heard=[(numbers.get(heard.sender, 0), heard.text) for heard in measures.message],
        )  # fmt: skip

    def _wanted(self, sensor: str) -> bool:
        kind = _KINDS[sensor.rstrip("0123456789")]
        return kind not in self._settings.requestable or sensor in self._requested

    def _obstacle(self, reading: ProximityReading) -> float:
        if reading.status == "none":
            ideal = 0.0
        elif reading.value is None or reading.value <= _NEAREST:
            ideal = 1.0 / _NEAREST
        else:
            ideal = 1.0 / reading.value
        noise = self._settings.obstacle_noise
        return math.floor(10.0 * (ideal + (self._random.gauss(0.0, noise) if noise else 0.0)) + 0.5) / 10.0

    def _ground(self, sensors: Sensors) -> int:
        """Return the number of the target that the whole disc is in, or -1."""
        zones = {reading.zone for reading in sensors.ground}
        return self._lab.target_number(zones.pop()) if len(zones) == 1 and self._lab is not None else -1


def _whole_degrees(radians: float) -> float:
    return math.floor(math.degrees(math.remainder(radians, 2.0 * math.pi)) + 0.5)
