"""Bodies on a floor for the tests of contact, and crowds of them at random."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from intellwheels_server.world.kernels import allowed_penetration, contact
from intellwheels_server.world.kernels.arrays import (
    BLOCKED,
    COLLIDED,
    END_ALLOWED,
    END_HEADING,
    END_X,
    STALLED,
    TOUCHED,
    Bodies,
    Box,
    Floats,
    Ints,
    Shape,
    Walls,
    bodies_from,
)
from intellwheels_server.world.kernels.contact_hits import Outcomes
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.geometry import body_depth
from intellwheels_server.world.wall_pieces import Line, Solid, walls_from

CHAIR = (Box(0.25, 0.0, 1.2, 0.66, 0.0, 1.3),)
TWO_PART_CHAIR = (Box(0.25, 0.0, 1.2, 0.66, 0.0, 0.5), Box(0.0, 0.0, 0.7, 0.6, 0.5, 1.3))
TABLE = (
    Box(0.0, 0.0, 1.2, 0.8, 0.69, 0.72),
    *(Box(x, y, 0.05, 0.05, 0.0, 0.69) for x in (-0.55, 0.55) for y in (-0.35, 0.35)),
)
# The paper's door: length 1.0, width 0.1, centre of movement 0.99 of the length from the rear edge.
LEAF = (Box(-0.49, 0.0, 1.0, 0.1, 0.0, 2.0),)
NO_WALLS = walls_from([])

# Type checkers count the arguments of a kernel and not those of a starred tuple.
BODY_DEPTH: Any = body_depth


class Floor:
    """Bodies with constant twists, ticked one by one."""

    def __init__(self, shapes: Sequence[Shape], poses: Sequence[tuple[float, float, float]], walls: Walls = NO_WALLS):
        self.bodies: Bodies = bodies_from(shapes)
        self.walls = walls
        self.pose: Floats = np.ascontiguousarray(np.array(poses, dtype=np.float64).reshape(-1, 3).T)
        self.allowed: Floats = np.zeros(len(shapes))
        self.twist: Floats = np.zeros((2, len(shapes)))
        self.tick_number = 0
        self.room = 4
        self.outcome: Floats = np.zeros((6, len(shapes)))
        self.flags: Ints = np.zeros((4, len(shapes)), dtype=np.int64)
        self.hits: Ints = np.empty((0, 6), dtype=np.int64)
        self.hit_numbers: Floats = np.empty((0, 6))

    def allow_overlap(self, who: Sequence[int] | None = None) -> None:
        """Give those who were put where they are their allowed penetration."""
        chosen = np.array(range(self.pose.shape[1]) if who is None else who, dtype=np.int64)
        allowed_penetration.allow_overlap(self.bodies, self.walls, self.pose, chosen, self.allowed)

    def tick(self) -> None:
        """Move all by one tick."""
        while True:
            hits, numbers = np.empty((self.room, 6), dtype=np.int64), np.empty((self.room, 6))
            outcomes = Outcomes(self.outcome, self.flags, hits, numbers)
            used = contact.resolve(
                self.bodies, self.walls, self.pose, self.twist, self.allowed, self.tick_number, outcomes
            )
            if used <= self.room:
                break
            self.room = used
        order = np.lexsort((hits[:used, 1], hits[:used, 0]))
        self.hits, self.hit_numbers = hits[:used][order], numbers[:used][order]
        self.pose = self.outcome[END_X : END_HEADING + 1].copy()
        self.allowed = self.outcome[END_ALLOWED].copy()
        self.tick_number += 1

    def drive(self, i: int, travel: float, turn: float) -> None:
        """Set a body's twist of every tick from now."""
        self.twist[:, i] = travel, turn

    def blocked(self, i: int) -> bool:
        """Return whether a body did not get all it proposed in the last tick."""
        return bool(self.flags[BLOCKED, i])

    def stalled(self, i: int) -> bool:
        """Return whether a body's wheels stalled."""
        return bool(self.flags[STALLED, i])

    def collided(self, i: int) -> bool:
        """Return whether a body led itself into something."""
        return bool(self.flags[COLLIDED, i])

    def touched(self, i: int) -> bool:
        """Return whether a body touched or was touched."""
        return bool(self.flags[TOUCHED, i])

    def depth(self, i: int, j: int) -> float:
        """Return the depth of body i in body j, m."""
        (parts, start, _, _), (x, y, heading) = self.bodies, self.pose
        (si, ci), (sj, cj) = sincos(heading[i]), sincos(heading[j])
        one = (parts, start[i], start[i + 1], x[i], y[i], ci, si)
        other = (parts, start[j], start[j + 1], x[j], y[j], cj, sj)
        return float(BODY_DEPTH(*one, *other, -np.inf))

    def overlap(self, i: int) -> float:
        """Return the largest depth of body i in anything, m."""
        depth = np.zeros(self.pose.shape[1])
        allowed_penetration.allow_overlap(self.bodies, self.walls, self.pose, np.array([i], dtype=np.int64), depth)
        return float(depth[i])


def random_floor(rng: np.random.Generator, count: int) -> Floor:
    """Return a crowd in a small room: chairs, tables, leaves, posts; some put into one another."""
    side = math.sqrt(2.5 * count) + 1.0
    kinds = (CHAIR, TWO_PART_CHAIR, TABLE, LEAF, (Box(0.0, 0.0, 0.05, 0.05, 0.0, 1.0),))
    shapes, poses = [], []
    for k in range(count):
        kind = int(rng.choice(5, p=(0.45, 0.25, 0.1, 0.1, 0.1)))
        shapes.append(Shape(f"body{k}", kinds[kind], anchored=kind == 3, externally_posed=bool(rng.random() < 0.05)))
        poses.append((rng.uniform(0.0, side), rng.uniform(0.0, side), rng.uniform(-3.1, 3.1)))
    walls = walls_from(
        [
            Line([(-1.0, -1.0), (side + 1, -1.0), (side + 1, side + 1), (-1.0, side + 1), (-1.0, -1.0)], 0.1, 0.0, 2.5),
            Solid([(0.3 * side, 0.3 * side), (0.3 * side + 0.5, 0.3 * side), (0.3 * side, 0.3 * side + 0.7)], 0.0, 0.6),
        ]
    )
    floor = Floor(shapes, poses, walls)
    floor.twist = np.array([rng.uniform(-0.06, 0.1, count), rng.normal(0.0, 0.06, count)])
    floor.twist[:, rng.random(count) < 0.1] = 0.0
    floor.allow_overlap()
    return floor


def permuted(floor: Floor, order: Ints) -> Floor:
    """Return the same scene with its bodies in another order of the arrays."""
    parts, starts = floor.bodies.parts, floor.bodies.part_start
    slices = [parts[starts[i] : starts[i + 1]] for i in order]
    counts = [len(part) for part in slices]
    other = Floor([], [], floor.walls)
    other.bodies = Bodies(
        np.concatenate(slices),
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.ascontiguousarray(floor.bodies.shape[:, order]),
        np.ascontiguousarray(floor.bodies.marks[:, order]),
    )
    other.pose = np.ascontiguousarray(floor.pose[:, order])
    other.twist = np.ascontiguousarray(floor.twist[:, order])
    other.allowed = floor.allowed[order].copy()
    other.outcome = np.zeros((6, len(order)))
    other.flags = np.zeros((4, len(order)), dtype=np.int64)
    return other


def steer(floor: Floor, rng: np.random.Generator) -> None:
    """Turn some of the movers to new ways."""
    count = int(floor.twist.shape[1])
    change = np.nonzero(rng.random(count) < 0.1)[0]
    floor.twist[0, change] = rng.uniform(-0.06, 0.1, len(change))
    floor.twist[1, change] = rng.normal(0.0, 0.06, len(change))


def order_matters(seed: int, ticks: int = 40) -> bool:
    """Return whether one random crowd comes out differently, in any bit, when its bodies are in another order."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 40))
    one = random_floor(rng, count)
    order = rng.permutation(count)
    other = permuted(one, order)
    for _ in range(ticks):
        steer(one, rng)
        other.twist = np.ascontiguousarray(one.twist[:, order])
        one.tick()
        other.tick()
        if one.outcome[:, order].tobytes() != other.outcome.tobytes():
            return True
        if (one.flags[:, order] != other.flags).any() or _pairs(one, None) != _pairs(other, order):
            return True
    return False


def _pairs(floor: Floor, order: Ints | None) -> set[tuple[object, ...]]:
    """Return who met whom, where, whatever the order of the arrays."""
    found: set[tuple[object, ...]] = set()
    for hit, numbers in zip(floor.hits.tolist(), floor.hit_numbers.tolist(), strict=True):
        i, j, wall, part, other_part, who = hit
        x, y, nx, ny, depth, closing = numbers
        if order is not None:
            i, j = int(order[i]), int(order[j]) if j >= 0 else j
        if j >= 0 and i > j:
            i, j, part, other_part, nx, ny = j, i, other_part, part, -nx, -ny
            who = ((who & 1) << 1) | (who >> 1)
        found.add((i, j, wall, part, other_part, who, x, y, nx + 0.0, ny + 0.0, depth, round(closing, 12)))
    return found
