"""Obstacles are remembered until a sensor sees past them."""

from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.navigation.obstacle_memory import ObstacleMemory
from intellwheels_maps import robot
from intellwheels_schemas.messages import Actions, Measures, ProximityReading, Sensors
from tests.agents.kinematics import RUN, Body, Segment, box


class Driver:
    """A body that drives and remembers."""

    def __init__(self, walls: list[Segment], heading: float = 0.0) -> None:
        self.body = Body(robot("rear-wheel"), heading=heading)
        self.walls = walls
        self.memory = ObstacleMemory(self.body.robot)
        self.pose = Odometry(self.body.robot, self.body.position, compass_share=0.0)
        self.look()

    def look(self) -> None:
        measures = self.body.measures(self.walls)
        self.pose.update(measures.sensors)
        self.memory.update(measures, self.pose)

    def drive(self, left: float, right: float, ticks: int) -> None:
        for _ in range(ticks):
            self.body.step(Actions(left_motor=left, right_motor=right))
            self.look()

    def nearest(self, x: float, y: float) -> float:
        """Return the distance from a point in the room to the nearest remembered point, m."""
        c, s = math.cos(self.body.heading), math.sin(self.body.heading)
        here = ((self.body.x + c * px - s * py, self.body.y + s * px + c * py) for px, py in self.memory.points)
        return min((math.dist((x, y), place) for place in here), default=math.inf)


def pole(x: float, y: float) -> list[Segment]:
    return box(x - 0.02, y - 0.02, x + 0.02, y + 0.02)


def test_whole_arc_may_hold_the_obstacle() -> None:
    driver = Driver([(2.0, -0.05, 2.0, 0.05)])
    radius = 2.0 - 0.8503
    for degrees in (-14.0, 0.0, 14.0):
        angle = math.radians(degrees)
        assert driver.nearest(0.8503 + radius * math.cos(angle), radius * math.sin(angle)) < 0.05


def test_obstacle_between_two_cones_is_remembered() -> None:
    # Straight before the left corner; the front cone loses it at 1.1 m.
    driver = Driver(pole(2.2, 0.28))
    driver.drive(0.4, 0.4, 40)
    readings = driver.body.measures(driver.walls).sensors
    assert readings is not None
    assert all(reading.status == "none" for reading in readings.proximity)
    assert driver.nearest(2.2, 0.28) < 0.08


def test_cone_that_sees_past_a_point_clears_it() -> None:
    driver = Driver([(2.0, -0.05, 2.0, 0.05)])
    driver.walls = []
    driver.drive(0.0, 0.0, 1)
    # The edges of the cone prove nothing.
    assert driver.nearest(2.0, 0.0) > 0.15


def test_obstacle_far_behind_is_forgotten() -> None:
    driver = Driver([(-1.0, -0.5, -1.0, 0.5)])
    assert len(driver.memory.points)
    driver.walls = []
    driver.drive(0.9, 0.9, 80)
    assert driver.memory.points.shape == (0, 2)


def test_wall_between_two_cones_counts_while_both_see_it() -> None:
    # A slanting wall: what is before the left corner lies in neither cone.
    driver = Driver([(0.9, 0.75, 2.2, -0.3)], heading=0.0)
    assert driver.nearest(1.3, 0.43) < 0.12


@pytest.mark.parametrize("metres", [0.02, 0.049])
def test_obstacle_below_the_minimum_range_is_near(metres: float) -> None:
    driver = Driver([(0.8503 + metres, -0.5, 0.8503 + metres, 0.5)])
    assert driver.nearest(0.8503 + metres, 0.0) < 0.05


def test_new_obstacle_in_free_space_is_seen() -> None:
    driver = Driver([])
    driver.drive(0.2, 0.2, 10)
    ahead = driver.body.x + 0.8503 + 1.0
    driver.walls = pole(ahead, 0.0)
    driver.drive(0.0, 0.0, 1)
    assert driver.nearest(ahead, 0.0) < 0.08


class LateDriver(Driver):
    """A body whose readings come late: of the cones, and of the encoders too if `encoders` says so."""

    def __init__(self, walls: list[Segment], late: int, encoders: bool) -> None:
        self.late, self.encoders = late, encoders
        self.past: list[Measures] = []
        super().__init__(walls)

    def look(self) -> None:
        now = self.body.measures(self.walls)
        self.past.append(now)
        then = self.past[-1 - self.late] if len(self.past) > self.late else None
        sensors = Sensors()
        if then is not None and then.sensors is not None:
            sensors = msgspec.structs.replace(
                then.sensors,
                proximity=tuple(msgspec.structs.replace(one, tick=then.tick) for one in then.sensors.proximity),
                encoders=tuple(msgspec.structs.replace(one, tick=then.tick) for one in then.sensors.encoders),
            )
        if not self.encoders and now.sensors is not None:
            sensors = msgspec.structs.replace(sensors, encoders=now.sensors.encoders)
        measures = msgspec.structs.replace(now, sensors=sensors)
        self.pose.update(measures.sensors)
        if self.encoders:
            self.pose.tick = max(0, now.tick - self.late)
        self.memory.update(measures, self.pose)


@pytest.mark.parametrize("late", [1, 2, 4])
@pytest.mark.parametrize("encoders", [False, True])
def test_late_reading_is_placed_and_clears_where_it_was_measured(late: int, encoders: bool) -> None:
    driver = LateDriver([(3.0, -0.05, 3.0, 0.05)], late, encoders)
    driver.drive(0.8, 0.8, 20)
    driver.drive(0.0, 0.0, 10)
    assert driver.nearest(3.0, 0.0) < 0.05
    assert driver.nearest(2.7, 0.0) > 0.15
    driver.walls = []
    driver.drive(0.0, 0.0, late)
    # What was measured before the obstacle went does not clear it; what was measured after does.
    assert driver.nearest(3.0, 0.0) < 0.05
    driver.drive(0.0, 0.0, 2)
    assert driver.nearest(3.0, 0.0) > 0.15


def test_late_reading_does_not_clear_what_was_seen_after_it() -> None:
    body = Body(robot("rear-wheel"))
    memory, pose = ObstacleMemory(body.robot), Odometry(body.robot, body.position, compass_share=0.0)
    for tick, metres, at in ((5, 1.0, 5), (6, 1.4, 3)):
        reading = ProximityReading(id="front", value=metres, tick=at)
        memory.update(Measures(run=RUN, tick=tick, time=0.05 * tick, sensors=Sensors(proximity=(reading,))), pose)
    assert min(math.dist(point, (1.85, 0.0)) for point in memory.points) < 0.05
