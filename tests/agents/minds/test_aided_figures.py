"""The published figures of aided driving: a doorway, a wall, an object, a speed. In one process.

The doorway of 0.813 m and the wall at 0.152 m are what Levine et al. (1999), The NavChair Assistive Wheelchair
Navigation System, report; 0.104 m and 1.17 m/s are what this project asks for besides. The chairs are those that are
included, 0.62 to 0.66 m wide.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from typing import Any

import pytest

from intellwheels_agents.range_scan import outline
from intellwheels_maps import robot
from intellwheels_schemas.messages import Corner, Map, Position, UserInput, Wall
from tests.agents.arena import Arena

CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")
DOORWAY = 0.813
BESIDE_WALL = 0.152
BEFORE_OBJECT = 0.104
TOP_SPEED = 1.17
STOPPED = 0.1
"""Speed below which a chair counts as stopped, m/s."""
APPROACHES = ((0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.3, -5.0), (-0.3, 10.0), (0.0, -15.0))
"""Starts 4.5 m in front of the doorway: offset from its axis (m), and heading (degrees)."""
WIDEST = ("mid-wheel", "intellwheels")
"""Chairs that stop or slow down in the approach from -0.2 m if a point of the first echo stays in the doorway."""
TURNS = {"rear-wheel": 0.5, "mid-wheel": 0.1, "intellwheels": 0.5, "front-wheel": 0.1}
"""Angle turned in 1.5 s, rad. Corners of mid-wheel and front-wheel reach 0.09 and 0.14 m beyond the front."""
LOOKAHEAD = 1.0
"""Distance ahead at which the user aims, m."""


def block(left: float, bottom: float, right: float, top: float) -> Wall:
    corners = ((left, bottom), (right, bottom), (right, top), (left, top))
    return Wall(corner=tuple(Corner(x=x, y=y) for x, y in corners), height=2.0)


def ground(*walls: Wall) -> Map:
    return Map(format="iw.v1", name="made", wall=walls)


class Steerer:
    """A user who holds the stick full ahead and steers along y = 0, with an inaccurate hand.

    The error of the hand wanders: of standard deviation `error`, in full deflections, forgotten within a second.
    """

    def __init__(self, arena: Arena, seed: int, error: float, speed: float = 0.8) -> None:
        self.arena, self.error, self.speed = arena, error, speed
        self.chance = random.Random(seed)
        self.off = 0.0

    def step(self) -> None:
        """Want something for a tick."""
        _, y, heading = self.arena.paths["chair1"][-1]
        kept = math.exp(-self.arena.setup.period)
        self.off = kept * self.off + self.chance.gauss(0.0, self.error * math.sqrt(1.0 - kept**2))
        angle = math.remainder(math.atan2(-y, LOOKAHEAD) - heading, math.tau)
        turn = self.speed * 2.0 * math.sin(angle) / math.hypot(y, LOOKAHEAD) + self.off
        self.arena.users["chair1"] = UserInput(forward=1.0, turn=max(-1.0, min(1.0, turn)))
        self.arena.step()

    def drive_to(self, x: float, seconds: float) -> list[float]:
        """Drive until there, or so long; return the speed at each tick once it had been up to speed."""
        speeds: list[float] = []
        for _ in range(math.ceil(seconds / self.arena.setup.period)):
            self.step()
            if speeds or self.arena.speed("chair1") > 0.5:
                speeds.append(self.arena.speed("chair1"))
            if self.arena.paths["chair1"][-1][0] > x:
                break
        return speeds


def placed(chair: str, walls: Map, x: float, y: float, heading_deg: float, **options: str) -> Arena:
    arena = Arena(walls)
    arena.join("chair1", "aided", chair, None, options, Position(x=x, y=y, heading=math.radians(heading_deg)))
    return arena


def approaches() -> Iterator[Any]:
    """Every fourth approach of the chairs, and the two that need the added cones most; the long version has all."""
    for i, chair in enumerate(CHAIRS):
        for j, (y, heading_deg) in enumerate(APPROACHES):
            short = (i + j) % 4 == 0 or (chair in WIDEST and y == -0.2)
            yield pytest.param(chair, y, heading_deg, marks=() if short else pytest.mark.soak)


@pytest.mark.parametrize(("chair", "y", "heading_deg"), list(approaches()))
def test_chair_passes_a_doorway_of_0_813_m_without_stopping(chair: str, y: float, heading_deg: float) -> None:
    half = DOORWAY / 2.0
    arena = placed(chair, ground(block(3.0, half, 3.15, 4.0), block(3.0, -4.0, 3.15, -half)), -1.5, y, heading_deg)
    speeds = Steerer(arena, round(100.0 * y) % 7, 0.02).drive_to(5.0, 12.0)
    assert arena.contacts() == []
    assert arena.paths["chair1"][-1][0] > 5.0
    assert min(speeds) > STOPPED


@pytest.mark.parametrize("error", [0.0, 0.05])
@pytest.mark.parametrize("chair", CHAIRS)
def test_chair_drives_along_a_wall_at_0_152_m(chair: str, error: float) -> None:
    beside = outline(robot(chair)).side + BESIDE_WALL
    arena = placed(chair, ground(block(-2.0, beside, 9.0, beside + 0.2)), 0.0, 0.0, 0.0)
    speeds = Steerer(arena, 3, error).drive_to(5.0, 12.0)
    assert arena.paths["chair1"][-1][0] > 5.0
    assert min(speeds) > 0.5
    assert arena.contacts() == []


@pytest.mark.parametrize("chair", CHAIRS)
def test_chair_comes_within_0_104_m_of_an_object_and_gets_away(chair: str) -> None:
    arena = placed(chair, ground(block(3.0, -0.2, 3.6, 0.2)), 1.0, 0.0, 0.0)
    arena.users["chair1"] = UserInput(forward=1.0)
    arena.run(10.0)
    assert 0.0 < 3.0 - arena.paths["chair1"][-1][0] - outline(robot(chair)).front <= BEFORE_OBJECT
    before = arena.paths["chair1"][-1]
    arena.users["chair1"] = UserInput(turn=1.0)
    arena.run(1.5)
    assert arena.paths["chair1"][-1][2] - before[2] > TURNS[chair]
    before = arena.paths["chair1"][-1]
    arena.users["chair1"] = UserInput(forward=-1.0)
    arena.run(1.5)
    assert math.dist(before[:2], arena.paths["chair1"][-1][:2]) > 0.3
    assert arena.contacts() == []


@pytest.mark.parametrize("chair", CHAIRS)
def test_chair_drives_at_1_17_m_a_second_and_stops(chair: str) -> None:
    walls = ground(block(9.0, -4.0, 9.2, 4.0))
    arena = placed(chair, walls, 0.0, 0.0, 0.0, TopSpeed=str(TOP_SPEED), speed=str(TOP_SPEED))
    arena.users["chair1"] = UserInput(forward=1.0)
    arena.run(3.0)
    assert arena.speed("chair1") == pytest.approx(TOP_SPEED, abs=0.005)
    arena.run(15.0, lambda arena: arena.speed("chair1") < 0.001)
    assert arena.speed("chair1") == pytest.approx(0.0, abs=0.01)
    assert arena.paths["chair1"][-1][0] > 7.5
    assert arena.contacts() == []
