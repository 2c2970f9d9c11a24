"""An endless corridor in which a crowd walks one way or both, to measure a fundamental diagram and lanes.

It is made of a straight corridor and images: whoever is at x has an image a period before and one after, which are set
anew at each tick and move as he does, so all see and touch what they would on a ring, without bends. Who walks past the
end is put back by a period. Encoders and compass do not notice, and his mind believes that he walks on.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np

from intellwheels_maps import robot
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Actions, Corner, Map, Position, Wall
from intellwheels_server.world import advance, apply, measures
from intellwheels_server.world.kernels import rows
from tests.agents.arena import Arena

IMAGES = ("before", "after")
LENGTHWISE, CROSSWISE = 0.42, 0.55
"""Least distances of bodies at random places, m: the body is 0.35 by 0.5 m."""
LANE = 0.6
"""Width of a strip for the order of lanes, m."""


def weidmann(density: float) -> float:
    """Return the speed (m/s) of a crowd with a density in persons per square metre (Weidmann 1993)."""
    return 1.34 * (1.0 - math.exp(-1.913 * (1.0 / density - 1.0 / 5.4)))


def lane_order(across: np.ndarray, ways: np.ndarray) -> float:
    """Return the order parameter of lanes: the mean of ((a - b) / (a + b))^2 over all people.

    a and b are the numbers of those who walk his way and the other way in the strip of `LANE` metres around him. It is
    1 when no strip is mixed. Source: M. Rex, H. Loewen, Lane formation in oppositely charged colloids driven by an
    electric field, Phys. Rev. E 75, 2007; for people, A. Nowak and A. Schadschneider, Phys. Rev. E 85, 2012.

    Args:
        across: Place across the corridor of each, m.
        ways: Walking direction of each, 1 or -1.
    """
    beside = np.abs(across[:, np.newaxis] - across[np.newaxis, :]) < LANE / 2.0
    share = (beside * ways).sum(axis=1) / beside.sum(axis=1)
    return float((share * share).mean())


class Corridor:
    """A crowd in an endless corridor.

    Attributes:
        arena: The world; the real ones are its players.
        walked: Metres each has walked along the corridor, in his own direction.
        order: Mean order parameter of the lanes while the flow was measured, see `lane_order`.
    """

    def __init__(
        self, density: float, length: float = 6.0, width: float = 2.0, seed: int = 1, *,
        random_starts: bool = False, both_ways: bool = False,
    ) -> None:  # fmt: skip
        """Put so many persons per square metre into `length` by `width` metres.

        They start on a lattice, a little off it, or at random places. With `both_ways`, every second one walks west.
        """
        self.length, self.width = length, width
        half = width / 2.0
        corners = [
            (-length - 1.0, -half),
            (2.0 * length + 1.0, -half),
            (2.0 * length + 1.0, half),
            (-length - 1.0, half),
        ]
        wall = Wall(corner=tuple(Corner(x=x, y=y) for x, y in (*corners, corners[0])), height=2.5, thickness=1e-3)
        self.arena = Arena(Map(format="iw.v1", name="corridor", wall=(wall,)), str(seed))
        self.count = round(density * length * width)
        self.order = math.nan
        self._ways = np.array([-1.0 if both_ways and i % 2 else 1.0 for i in range(self.count)])
        rng = np.random.default_rng(seed)
        starts = self._random(rng) if random_starts else self._lattice(rng)
        # All images join at once: with each join, the sensors of all bodies are laid out anew.
        images = [
            image for i, (x, y) in enumerate(starts) for image in self._join(f"walker{i}", x, y, float(self._ways[i]))
        ]
        self.arena.state, outputs = apply(self.arena.state, images)
        assert {outcome.code for outcome in outputs.outcomes} == {"ok"}, outputs.outcomes
        index = self.arena.state.body_set.index
        self._real = np.array([index[f"walker{i}"] for i in range(self.count)])
        self._images = [np.array([index[f"walker{i}-{image}"] for i in range(self.count)]) for image in IMAGES]
        self.walked = np.zeros(self.count)

    def _lattice(self, rng: np.random.Generator) -> list[tuple[float, float]]:
        row_count = math.ceil(math.sqrt(self.count * self.width / self.length))
        columns = math.ceil(self.count / row_count)
        pitch_x, pitch_y = self.length / columns, self.width / row_count
        found = []
        for i in range(self.count):
            off_x, off_y = rng.uniform(-0.5, 0.5, 2)
            x = (i // row_count + 0.5) * pitch_x + off_x * (pitch_x - 0.5)
            y = (i % row_count + 0.5) * pitch_y - self.width / 2.0 + off_y * (pitch_y - 0.6)
            found.append((float(x % self.length), float(y)))
        return found

    def _random(self, rng: np.random.Generator) -> list[tuple[float, float]]:
        """Return random places, all bodies clear of each other: drawn again from the start if no place is left."""
        found: list[tuple[float, float]] = []
        draws = 0
        while len(found) < self.count:
            x, y = float(rng.uniform(0.0, self.length)), float(rng.uniform(0.3, self.width - 0.3)) - self.width / 2.0
            off = [(abs(math.remainder(x - other, self.length)), abs(y - y2)) for other, y2 in found]
            if all(along > LENGTHWISE or across > CROSSWISE for along, across in off):
                found.append((x, y))
            draws += 1
            if draws == 10_000:
                found, draws = [], 0
        return found

    def _join(self, name: str, x: float, y: float, way: float) -> list[Join]:
        """Let a walker join; return the joins of his images."""
        options = {"points": f"{1e4 * way:g} {y:.3f}", "MotorNoise": "0.05"}
        heading = 0.0 if way > 0.0 else math.pi
        self.arena.join(name, "person", "person", None, options, Position(x=x, y=y, heading=heading))
        bare = msgspec.structs.replace(robot("person"), proximity=(), compass=(), encoders=(), format=None)
        return [
            Join(
                agent=f"{name}-{image}",
                robot=msgspec.structs.replace(bare, position=Position(x=x + shift, y=y, heading=heading)),
            )
            for image, shift in zip(IMAGES, (-self.length, self.length), strict=True)
        ]

    def step(self) -> None:
        """Let everybody decide once, and the world take a step."""
        arena = self.arena
        self._set(np.floor(arena.state.numbers[rows.X, self._real] / self.length) * self.length)
        before = arena.state.numbers[rows.X, self._real]
        actions: dict[str, Actions] = {}
        for name, player in arena.players.items():
            answer = player.mind.decide(measures(arena.state, name))
            assert isinstance(answer, Actions)
            actions |= {name: answer} | {f"{name}-{image}": answer for image in IMAGES}
        arena.state, outputs = advance(arena.state, Inputs(actions=actions))
        arena.events.extend(outputs.events)
        self.walked += self._ways * (arena.state.numbers[rows.X, self._real] - before)

    def _set(self, back: np.ndarray) -> None:
        """Put the real ones back by so many metres, and their images where they belong."""
        numbers = self.arena.state.numbers.copy()
        numbers[rows.X, self._real] -= back
        for images, shift in zip(self._images, (-self.length, self.length), strict=True):
            numbers[:, images] = numbers[:, self._real]
            numbers[rows.X, images] += shift
        self.arena.state = msgspec.structs.replace(self.arena.state, numbers=numbers)

    def flow(self, settle: float, seconds: float) -> float:
        """Return persons per second and metre of width over some seconds, after some that are not counted."""
        period = self.arena.setup.period
        for _ in range(round(settle / period)):
            self.step()
        self.walked[:] = 0.0
        orders = []
        for _ in range(round(seconds / period)):
            self.step()
            orders.append(lane_order(self.arena.state.numbers[rows.Y, self._real], self._ways))
        self.order = float(np.mean(orders))
        return float(self.walked.sum()) / (self.length * self.width * seconds)
