"""A small world for minds: exact arcs, lagging motors, straight walls, cones of rays.

It has no contact model: a test asks whether a body touches a wall. It is slow and simple on purpose.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field

from intellwheels_agents.mind import Context, Mind
from intellwheels_agents.options import Options
from intellwheels_schemas.messages import (
    Actions,
    CompassReading,
    EncodersReading,
    Grid,
    Heard,
    Map,
    Measures,
    Parameters,
    Place,
    Position,
    Proximity,
    ProximityReading,
    Robot,
    Sensors,
    TruthReading,
)
from intellwheels_schemas.rules import parts_of

PERIOD = 0.05
RUN = "0" * 16
Segment = tuple[float, float, float, float]

PARAMETERS = Parameters(
    world="main", period=PERIOD, pace="lockstep", say_limit=100, say_range=8.0, command_timeout=0.5, grace=3.0
)
PLACES = Map(
    format="iw.v1",
    name="tested",
    grid=Grid(position=(Place(name="goal1", x=5.0, y=1.0), Place(name="goal2", x=2.0, y=0.0))),
)


def context(robot: Robot, position: Position | None = None, **options: str) -> Context:
    start = position or Position(x=0.0, y=0.0, heading=0.0)
    return Context("tested", robot, start, PARAMETERS, Options(options), lambda: PLACES)


@dataclass
class Body:
    """A body with wheels, motor lag and noise."""

    robot: Robot
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    motor_noise: float = 0.0
    compass_noise: float = 0.0
    range_noise: float = 0.0
    start: tuple[float, float, float] = field(init=False)
    speeds: list[float] = field(default_factory=lambda: [0.0, 0.0])
    travels: list[float] = field(default_factory=lambda: [0.0, 0.0])
    powers: list[float] = field(default_factory=lambda: [0.0, 0.0])
    tick: int = 0
    noise: random.Random = field(default_factory=lambda: random.Random(1))

    def __post_init__(self) -> None:
        self.start = (self.x, self.y, self.heading)

    @property
    def position(self) -> Position:
        x, y, heading = self.start
        return Position(x=x, y=y, heading=heading)

    def step(self, actions: Actions) -> None:
        """Advance one tick."""
        wanted = (actions.left_motor, actions.right_motor)
        inertia = self.robot.acceleration_curve
        for i, power in enumerate(wanted):
            if power is not None:
                assert -1.0 <= power <= 1.0
                self.powers[i] = power
            target = self.powers[i] * self.robot.top_speed * (1.0 + self.noise.gauss(0.0, self.motor_noise))
            self.speeds[i] = (1.0 - inertia) * target + inertia * self.speeds[i]
            self.travels[i] += self.speeds[i] * PERIOD
        left, right = (speed * PERIOD for speed in self.speeds)
        turn, travel = (right - left) / self.robot.track, (left + right) / 2.0
        half = turn / 2.0
        chord = travel * (math.sin(half) / half if half else 1.0)
        self.x += chord * math.cos(self.heading + half)
        self.y += chord * math.sin(self.heading + half)
        self.heading = math.remainder(self.heading + turn, 2.0 * math.pi)
        self.tick += 1

    def corners(self) -> list[tuple[float, float]]:
        """Return the corners of its lowest part."""
        part = min(parts_of(self.robot), key=lambda part: part.bottom)
        c, s = math.cos(self.heading), math.sin(self.heading)
        found = []
        for i, j in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
            x, y = part.x + i * part.length / 2, part.y + j * part.width / 2
            found.append((self.x + x * c - y * s, self.y + x * s + y * c))
        return found

    def outline(self) -> list[Segment]:
        corners = self.corners()
        return [(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]

    def touches(self, walls: list[Segment]) -> bool:
        return any(_crosses(edge, wall) for edge in self.outline() for wall in walls)

    def measures(self, walls: list[Segment], heard: tuple[Heard, ...] = (), contact: bool = False) -> Measures:
        """Return the present measures."""
        robot = self.robot
        per_metre = robot.encoder_ticks / (math.pi * robot.wheel_diameter)
        left, right = (math.floor(travel * per_metre) for travel in self.travels)
        compass = math.remainder(self.heading + self.noise.gauss(0.0, self.compass_noise), 2.0 * math.pi)
        sensors = Sensors(
            proximity=tuple(self._reading(sensor, walls) for sensor in robot.proximity),
            encoders=tuple(EncodersReading(id=s.id, left=left, right=right) for s in robot.encoders),
            compass=tuple(CompassReading(id=s.id, value=compass) for s in robot.compass),
            truth=tuple(
                TruthReading(id=s.id, x=self.x, y=self.y, heading=self.heading, speed=0.0, turn_rate=0.0)
                for s in robot.truth
            ),
        )
        return Measures(
            run=RUN, tick=self.tick, time=self.tick * PERIOD, sensors=sensors, message=heard, contact=contact
        )

    def _reading(self, sensor: Proximity, walls: list[Segment]) -> ProximityReading:
        x, y, heading = self.start if sensor.mount == "start" else (self.x, self.y, self.heading)
        c, s = math.cos(heading), math.sin(heading)
        x, y = x + sensor.x * c - sensor.y * s, y + sensor.x * s + sensor.y * c
        middle, half = heading + math.radians(sensor.direction_deg), math.radians(sensor.cone_deg) / 2.0
        rays = [middle + half * i / 4.0 for i in range(-4, 5)]
        nearest = min(_hit(x, y, ray, wall) for ray in rays for wall in walls) if walls else math.inf
        if self.range_noise and math.isfinite(nearest):
            nearest = max(0.0, nearest + self.noise.gauss(0.0, self.range_noise))
        if nearest > sensor.max_range:
            return ProximityReading(id=sensor.id, status="none")
        if nearest < sensor.min_range:
            return ProximityReading(id=sensor.id, status="near")
        return ProximityReading(id=sensor.id, value=nearest)


def run(body: Body, mind: Mind, walls: list[Segment], seconds: float) -> list[Actions]:
    """Let a mind drive a body for so many seconds, and return its actions."""
    done = []
    for _ in range(round(seconds / PERIOD)):
        done.append(mind.decide(body.measures(walls)))
        body.step(done[-1])
    return done


def box(left: float, bottom: float, right: float, top: float) -> list[Segment]:
    return [
        (left, bottom, right, bottom),
        (right, bottom, right, top),
        (right, top, left, top),
        (left, top, left, bottom),
    ]


def _hit(x: float, y: float, angle: float, wall: Segment) -> float:
    dx, dy = math.cos(angle), math.sin(angle)
    ax, ay, bx, by = wall
    ex, ey = bx - ax, by - ay
    across = dx * ey - dy * ex
    if abs(across) < 1e-12:
        return math.inf
    along = ((ax - x) * ey - (ay - y) * ex) / across
    share = ((ax - x) * dy - (ay - y) * dx) / across
    return along if along >= 0.0 and 0.0 <= share <= 1.0 else math.inf


def _crosses(one: Segment, other: Segment) -> bool:
    def side(s: Segment, x: float, y: float) -> float:
        return (s[2] - s[0]) * (y - s[1]) - (s[3] - s[1]) * (x - s[0])

    return (
        side(one, other[0], other[1]) * side(one, other[2], other[3]) < 0.0
        and side(other, one[0], one[1]) * side(other, one[2], one[3]) < 0.0
    )
