"""The published figures of aided driving: a doorway, a wall, an object, a speed. In the real world, in one process.

The doorway of 0.813 m and the wall at 0.152 m are what Levine et al. (1999), The NavChair Assistive Wheelchair
Navigation System, report; 0.104 m and 1.17 m/s are what this project asks for besides. The chairs are those that are
shipped, 0.62 to 0.66 m wide.
"""

from __future__ import annotations

import itertools
import math
import random

import pytest

from intellwheels_agents.surroundings import outline
from intellwheels_maps import robot
from intellwheels_schemas.messages import Corner, Map, Position, UserInput, Wall
from tests.agents.arena import Arena

CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")
DOORWAY = 0.813
BESIDE_WALL = 0.152
BEFORE_OBJECT = 0.104
TOP_SPEED = 1.17
STOPPED = 0.1
"""Metres a second below which a chair counts as stopped on its way."""
LOOKAHEAD = 1.0
"""Metres ahead of the chair to which its user steers."""


def block(left: float, bottom: float, right: float, top: float) -> Wall:
    corners = ((left, bottom), (right, bottom), (right, top), (left, top))
    return Wall(corner=tuple(Corner(x=x, y=y) for x, y in corners), height=2.0)


def ground(*walls: Wall) -> Map:
    return Map(format="iw.v1", name="made", wall=walls)


class Steerer:
    """A user who holds the stick full ahead and steers along y = 0, with a hand that is never quite right.

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
