"""What sensors saw is remembered until something proves it gone."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.obstacle_memory import ObstacleMemory
from intellwheels_maps import robot
from intellwheels_schemas.messages import Actions
from tests.agents.kinematics import Body, Segment, box


class Looker:
    """A body that drives and remembers."""

    def __init__(self, walls: list[Segment], heading: float = 0.0) -> None:
        self.body = Body(robot("rear-wheel"), heading=heading)
        self.walls = walls
        self.seen = ObstacleMemory(self.body.robot)
        self.pose = Odometry(self.body.robot, self.body.position, compass_share=0.0)
        self.look()

    def look(self) -> None:
        measures = self.body.measures(self.walls)
        self.pose.update(measures.sensors)
        self.seen.update(measures, self.pose)

    def drive(self, left: float, right: float, ticks: int) -> None:
        for _ in range(ticks):
            self.body.step(Actions(left_motor=left, right_motor=right))
            self.look()

    def nearest(self, x: float, y: float) -> float:
        """Return metres from a place of the room to the nearest point remembered."""
        c, s = math.cos(self.body.heading), math.sin(self.body.heading)
        here = ((self.body.x + c * px - s * py, self.body.y + s * px + c * py) for px, py in self.seen.points)
        return min((math.dist((x, y), place) for place in here), default=math.inf)


def pole(x: float, y: float) -> list[Segment]:
    return box(x - 0.02, y - 0.02, x + 0.02, y + 0.02)


def test_all_of_an_arc_may_be_it() -> None:
    looker = Looker([(2.0, -0.05, 2.0, 0.05)])
    radius = 2.0 - 0.8503
    for degrees in (-14.0, 0.0, 14.0):
        angle = math.radians(degrees)
        assert looker.nearest(0.8503 + radius * math.cos(angle), radius * math.sin(angle)) < 0.05


def test_what_slipped_between_two_cones_is_still_known() -> None:
    # Straight before the left corner; the front cone loses it at 1.1 m.
    looker = Looker(pole(2.2, 0.28))
    looker.drive(0.4, 0.4, 40)
    readings = looker.body.measures(looker.walls).sensors
    assert readings is not None
    assert all(reading.status == "none" for reading in readings.proximity)
    assert looker.nearest(2.2, 0.28) < 0.08


def test_a_cone_that_sees_past_a_point_proves_it_free() -> None:
    looker = Looker([(2.0, -0.05, 2.0, 0.05)])
    looker.walls = []
    looker.look()
    # The edges of the cone prove nothing.
    assert looker.nearest(2.0, 0.0) > 0.15


def test_what_stands_far_behind_is_forgotten() -> None:
    looker = Looker([(-1.0, -0.5, -1.0, 0.5)])
    assert looker.seen.points
    looker.walls = []
    looker.drive(0.9, 0.9, 80)
    assert looker.seen.points == []


def test_a_wall_between_two_cones_counts_while_both_see_it() -> None:
    # A slanting wall: what is before the left corner lies in neither cone.
    looker = Looker([(0.9, 0.75, 2.2, -0.3)], heading=0.0)
    assert looker.nearest(1.3, 0.43) < 0.12


@pytest.mark.parametrize("metres", [0.02, 0.049])
def test_what_is_too_near_to_tell_is_near(metres: float) -> None:
    looker = Looker([(0.8503 + metres, -0.5, 0.8503 + metres, 0.5)])
    assert looker.nearest(0.8503 + metres, 0.0) < 0.05


def test_what_comes_into_a_room_known_to_be_free_is_seen() -> None:
    looker = Looker([])
    looker.drive(0.2, 0.2, 10)
    ahead = looker.body.x + 0.8503 + 1.0
    looker.walls = pole(ahead, 0.0)
    looker.look()
    assert looker.nearest(ahead, 0.0) < 0.08
