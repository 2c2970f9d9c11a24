"""An endless corridor in which a crowd walks one way, to measure a fundamental diagram.

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


def weidmann(density: float) -> float:
    """Return the speed (m/s) of a crowd with a density in persons per square metre (Weidmann 1993)."""
    return 1.34 * (1.0 - math.exp(-1.913 * (1.0 / density - 1.0 / 5.4)))


class Corridor:
    """A crowd in an endless corridor.

    Attributes:
        arena: The world; the real ones are its players.
        walked: Metres each has walked along the corridor.
    """

    def __init__(self, density: float, length: float = 6.0, width: float = 2.0, seed: int = 1) -> None:
        """Put so many persons per square metre into `length` by `width` metres, on a lattice, a little off it."""
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
        row_count = math.ceil(math.sqrt(self.count * width / length))
        columns = math.ceil(self.count / row_count)
        pitch_x, pitch_y = length / columns, width / row_count
        rng = np.random.default_rng(seed)
        for i in range(self.count):
            off_x, off_y = rng.uniform(-0.5, 0.5, 2)
            x = (i // row_count + 0.5) * pitch_x + off_x * (pitch_x - 0.5)
            y = (i % row_count + 0.5) * pitch_y - half + off_y * (pitch_y - 0.6)
            self._join(f"walker{i}", x % length, y)
        index = self.arena.state.body_set.index
        self._real = np.array([index[f"walker{i}"] for i in range(self.count)])
        self._images = [np.array([index[f"walker{i}-{image}"] for i in range(self.count)]) for image in IMAGES]
        self.walked = np.zeros(self.count)

    def _join(self, name: str, x: float, y: float) -> None:
        options = {"points": f"1e4 {y:.3f}", "MotorNoise": "0.05"}
        self.arena.join(name, "person", "person", None, options, Position(x=x, y=y, heading=0.0))
        bare = msgspec.structs.replace(robot("person"), proximity=(), compass=(), encoders=())
        for image, shift in zip(IMAGES, (-self.length, self.length), strict=True):
            body = msgspec.structs.replace(bare, format=None, position=Position(x=x + shift, y=y, heading=0.0))
            self.arena.state, outputs = apply(self.arena.state, [Join(agent=f"{name}-{image}", robot=body)])
            assert outputs.outcomes[0].code == "ok", outputs.outcomes[0].text

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
        self.walked += arena.state.numbers[rows.X, self._real] - before

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
        for _ in range(round(seconds / period)):
            self.step()
        return float(self.walked.sum()) / (self.length * self.width * seconds)
