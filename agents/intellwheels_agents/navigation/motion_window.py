"""Chooses the next command of a body: of all speeds and turn rates it can soon have, the cheapest that is safe.

A command is tried by simulation: the speed approaches it as the motors let it. The command is safe if, given for one
period and followed by full braking, it keeps the footprint clear of every sensed point until the body stands, each
point that comes nearer moving on as it does now, and each other standing. Since braking was safe a tick ago, it still
is: a body that obeys stands before it touches anything that moves as predicted. Of the safe commands the one is taken
from whose end the goal costs least.

Sources: D. Fox, W. Burgard, S. Thrun, The dynamic window approach to collision avoidance, IEEE Robotics and Automation
Magazine 4 (1997) 23. O. Brock, O. Khatib, High-speed navigation using the global dynamic window approach, ICRA 1999:
the cost to go of the whole map instead of the direction of the goal. M. Seder, I. Petrovic, Dynamic window based
approach to mobile robot motion control in the presence of moving obstacles, ICRA 2007. K. Macek, D. Vasquez,
T. Fraichard, R. Siegwart, Towards safe vehicle navigation in dynamic urban scenarios, Automatika 50 (2009) 184: to
stand before a contact ("passive safety"). A window needs no solver and no weights that depend on the body, and its
worst case is its usual case: that is why it is used here instead of model-predictive control, which optimises the same
motion with an iteration. Velocity obstacles assume discs that move at once as they wish; a chair in a doorway is
neither.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from intellwheels_agents.navigation.array_angles import Floats, sines
from intellwheels_agents.navigation.cost_to_go import CostToGo
from intellwheels_agents.navigation.footprint_clearance import Box
from intellwheels_agents.portable_math import power, sincos
from intellwheels_schemas.messages import Robot

STEP: Final = 0.2
STEPS: Final = 8
"""Time between two poses of a simulated motion (s), and how many there are."""
BRAKING_SHARE: Final = 0.7
"""Share of a wheel's highest acceleration that is for the speed; the rest is for the turn rate. Chosen."""
BRAKE_STEP: Final = 0.1
"""Time between two poses while it brakes, s."""
ACCELERATION: Final = 0.6
SLOWING: Final = 0.7
"""How fast the commanded speed grows and falls, m/s2: comfortable for the person in the chair."""
TURN_ACCELERATION: Final = 2.0
"""How fast the commanded turn rate changes, rad/s2."""
TURN_RATE: Final = 0.9
"""Highest turn rate, rad/s."""
REVERSE_SPEED: Final = 0.25
"""Highest speed in reverse, m/s."""
MARGIN: Final = 0.04
"""Clearance that is always kept, m."""
GROWING: Final = 0.6
"""Time for which the clearance to what may start to move grows, s."""
SPENT: Final = 0.9
"""Share of a clearance below the margin that must remain: a body near a wall can leave, and never touches it."""
SOFT: Final = 0.14
"""Clearance that is kept where it costs little, m."""
SOFT_WEIGHT: Final = 0.25
"""Cost of using up the soft clearance, m."""
BLOCKED_WEIGHT: Final = 0.8
"""Cost of a motion that would come too near at once, m; less the later."""
CHANGE_WEIGHT: Final = 0.01
"""Cost of another command than the last, m per m/s and per rad/s."""
_SPEEDS: Final = (1.0, 0.75, 0.5, 0.3, 0.15, 0.06, 0.0)
_RATES: Final = (0.0, 0.06, 0.16, 0.32, 0.55, 1.0)

Points = Floats
Bools = npt.NDArray[np.bool_]
"""Rows x, y (m), velocities (m/s) in the body's frame, and how much faster than that they may come nearer (m/s)."""


class Command(NamedTuple):
    """A speed (m/s) and a turn rate (rad/s)."""

    speed: float
    rate: float


class Choice(NamedTuple):
    """The command for this tick.

    Attributes:
        command: What to give to the motors.
        cost: Cost to the goal from the end of its motion, m; infinite if no command was safe.
        moves: Whether it leads anywhere.
    """

    command: Command
    cost: float
    moves: bool


class MotionWindow:
    """The commands of one body."""

    def __init__(self, robot: Robot, boxes: list[Box], period: float, speed: float) -> None:
        """Take the body, the period of the simulation (s) and the highest speed (m/s)."""
        top = robot.top_speed
        self._top, self._half_track, self._period = top, robot.track / 2.0, period
        self._boxes = boxes
        self._speed = min(speed, top)
        limit = robot.turn_limit if robot.turn_limit is not None else TURN_RATE
        self._rate = min(TURN_RATE, limit, top / self._half_track)
        wheel = robot.acceleration_limit if robot.acceleration_limit is not None else 1e3
        self._hardest, self._hardest_turn = wheel * BRAKING_SHARE, wheel * (1.0 - BRAKING_SHARE) / self._half_track
        self._acceleration = min(ACCELERATION, BRAKING_SHARE * wheel)
        self._slowing = min(SLOWING, BRAKING_SHARE * wheel)
        self._turn_acceleration = min(TURN_ACCELERATION, self._hardest_turn)
        self._inertia = robot.acceleration_curve
        self._tick_inertia = _kept(self._inertia, period / 0.05)
        self._step_inertia = _kept(self._inertia, STEP / 0.05)
        self._brake_inertia = _kept(self._inertia, BRAKE_STEP / 0.05)
        self.actual = Command(0.0, 0.0)
        self.last = Command(0.0, 0.0)
        speeds = [share * self._speed for share in _SPEEDS]
        pairs = [(v, sign * w * self._rate) for v in speeds for w in _RATES for sign in (1.0, -1.0) if w or sign > 0.0]
        reverse = min(REVERSE_SPEED, self._speed)
        pairs += [(-v, w * self._rate) for v in (reverse, 0.4 * reverse) for w in (0.0, 0.2, -0.2, 0.55, -0.55)]
        self._speeds, self._rates = (np.array(column) for column in zip(*pairs, strict=True))
        # A wheel cannot turn faster than it can.
        over = np.maximum((np.abs(self._speeds) + np.abs(self._rates) * self._half_track) / max(top, 1e-9), 1.0)
        self._speeds, self._rates = self._speeds / over, self._rates / over

    @property
    def reach(self) -> float:
        """How far from its centre the body can be at the end of a simulated motion, m."""
        corner = max(max(box.front, -box.back) + max(box.left, -box.right) for box in self._boxes)
        braking = self._speed * self._speed / (2.0 * self._hardest) + self._speed * self._lag
        return corner + max(self._speed * STEP * STEPS, braking + self._speed * self._period) + SOFT

    def starts(self, speed: float, rate: float) -> None:
        """Take the speed (m/s) and the turn rate (rad/s) that the body has when the next command acts."""
        self.actual = Command(speed, rate)

    def stop(self) -> Command:
        """Return the command that brakes."""
        self.last = Command(0.0, 0.0)
        return self.last

    def choose(self, pose: tuple[float, float, float], goal: CostToGo, points: Points, slow: float = 1.0) -> Choice:
        """Return the command for this tick.

        Args:
            pose: The pose of the body in the map.
            goal: The costs to the goal.
            points: What the sensors see.
            slow: Share of the highest speed that may be driven.
        """
        period = self._period
        allowed = np.abs(self._speeds) <= max(slow * self._speed, 0.05) + 1e-9
        first_v = _towards(
            self.last.speed, self._speeds, self._acceleration * self._period, self._slowing * self._period
        )
        first_w = _towards(self.last.rate, self._rates, self._turn_acceleration * period)
        safe = allowed & self._stops_in_time(first_v, first_w, points)
        if not safe.any():
            return Choice(self.stop(), float("inf"), False)
        x, y, turned = self._motions(np.flatnonzero(safe))
        near = self._clearance(x, y, turned, points, np.arange(1, STEPS + 1, dtype=np.float64) * STEP)
        index = np.flatnonzero(safe)
        blocked = near < 0.0
        free = np.where(blocked.any(axis=1), blocked.argmax(axis=1), STEPS)
        last = np.maximum(free - 1, 0)
        rows = np.arange(index.size)
        end_x, end_y = np.where(free > 0, x[rows, last], 0.0), np.where(free > 0, y[rows, last], 0.0)
        end_turn = np.where(free > 0, turned[rows, last], 0.0)
        s, c = sincos(pose[2])
        cost = goal.at(pose[0] + c * end_x - s * end_y, pose[1] + s * end_x + c * end_y, pose[2] + end_turn)
        along = np.where(np.arange(STEPS)[None, :] < free[:, None], near, np.inf).min(axis=1)
        lacking = np.clip(1.0 - (along + MARGIN) / SOFT, 0.0, 1.0)
        total = cost + SOFT_WEIGHT * lacking + BLOCKED_WEIGHT * (STEPS - free) / STEPS
        total = total + CHANGE_WEIGHT * (
            np.abs(self._speeds[index] - self.last.speed) + np.abs(self._rates[index] - self.last.rate)
        )
        best = int(np.argmin(total))
        chosen = int(index[best])
        self.last = Command(float(first_v[chosen]), float(first_w[chosen]))
        moves = bool(self._speeds[chosen] != 0.0 or self._rates[chosen] != 0.0)
        return Choice(self.last, float(cost[best]), moves)

    def _motions(self, index: npt.NDArray[np.int64]) -> tuple[Floats, Floats, Floats]:
        """Return x, y and turned angle of the motions towards the commands, by command and step."""
        v, w = np.full(index.size, self.actual.speed), np.full(index.size, self.actual.rate)
        cv, cw = np.full(index.size, self.last.speed), np.full(index.size, self.last.rate)
        want_v, want_w = self._speeds[index], self._rates[index]
        keep = self._step_inertia
        speeds, rates = [], []
        for _ in range(STEPS):
            cv = _towards(cv, want_v, self._acceleration * STEP, self._slowing * STEP)
            cw = _towards(cw, want_w, self._turn_acceleration * STEP)
            new_v, new_w = keep * v + (1.0 - keep) * cv, keep * w + (1.0 - keep) * cw
            speeds.append((v + new_v) / 2.0)
            rates.append((w + new_w) / 2.0)
            v, w = new_v, new_w
        return _driven(np.stack(speeds, axis=1), np.stack(rates, axis=1), STEP)

    def _stops_in_time(self, first_v: Floats, first_w: Floats, points: Points) -> Bools:
        """Return whether each command may be given for a period, with full braking after it."""
        if not points.shape[0]:
            return np.ones(first_v.size, dtype=bool)
        pairs = np.stack([first_v, first_w], axis=1)
        distinct, inverse = np.unique(pairs, axis=0, return_inverse=True)
        keep = self._tick_inertia
        v0, w0 = self.actual.speed, self.actual.rate
        v, w = keep * v0 + (1.0 - keep) * distinct[:, 0], keep * w0 + (1.0 - keep) * distinct[:, 1]
        speeds, rates = [(v0 + v) / 2.0], [(w0 + w) / 2.0]
        fastest = float(np.abs(v).max())
        count = 2 + int((fastest / self._hardest + 3.0 * self._lag) / BRAKE_STEP)
        for _ in range(min(count, 40)):
            new_v = self._braked(v, self._hardest)
            new_w = self._braked(w, self._hardest_turn)
            speeds.append((v + new_v) / 2.0)
            rates.append((w + new_w) / 2.0)
            v, w = new_v, new_w
        times = np.array([self._period] + [BRAKE_STEP] * (len(speeds) - 1))
        x, y, turned = _driven(np.stack(speeds, axis=1), np.stack(rates, axis=1), times)
        near = self._clearance(x, y, turned, points, np.cumsum(times, dtype=np.float64))
        clear: Bools = near.min(axis=1) >= 0.0
        return clear[inverse.reshape(-1)]

    def _braked(self, v: Floats, hardest: float) -> Floats:
        wanted = self._brake_inertia * v
        most = hardest * BRAKE_STEP
        return v + np.clip(wanted - v, -most, most)

    @property
    def _lag(self) -> float:
        """Time in which the speed falls to about a third, s."""
        keep, time = self._inertia, 0.05
        if keep <= 0.0:
            return 0.0
        share = keep
        while share > 0.37 and time < 5.0:
            share *= keep
            time += 0.05
        return time

    def _clearance(self, x: Floats, y: Floats, turned: Floats, points: Points, times: Floats) -> Floats:
        """Return by how much the nearest point is farther than it must be, m, by command and step."""
        if not points.shape[0]:
            return np.full(x.shape, 1.0)
        gaps = self.gaps(points[:, 0], points[:, 1])
        most = np.where(gaps < 0.0, gaps - 1e-3, SPENT * gaps)
        # What may start to move must be farther away the later it is met, as long as braking takes.
        least = np.minimum(MARGIN + points[:, 4] * np.minimum(times, GROWING)[:, None], most).astype(np.float32)[None]
        s, c = sines(turned)
        c4, s4 = c.astype(np.float32)[:, :, None], s.astype(np.float32)[:, :, None]
        px = (points[:, 0] + points[:, 2] * times[:, None]).astype(np.float32)[None]
        py = (points[:, 1] + points[:, 3] * times[:, None]).astype(np.float32)[None]
        dx, dy = px - x.astype(np.float32)[:, :, None], py - y.astype(np.float32)[:, :, None]
        along, across = c4 * dx + s4 * dy, c4 * dy - s4 * dx
        gap = self._gap(along, across) - least
        return np.asarray(gap.min(axis=2), dtype=np.float64)

    def gaps(self, x: Floats, y: Floats) -> Floats:
        """Return how far points in the body's frame are from the body, m, negative inside."""
        return self._gap(x, y)

    def _gap(self, along: Floats, across: Floats) -> Floats:
        found = None
        for box in self._boxes:
            half, middle = (box.front - box.back) / 2.0, (box.front + box.back) / 2.0
            side, centre = (box.left - box.right) / 2.0, (box.left + box.right) / 2.0
            dx, dy = np.abs(along - along.dtype.type(middle)), np.abs(across - across.dtype.type(centre))
            gap = np.maximum(dx - along.dtype.type(half), dy - along.dtype.type(side))
            found = gap if found is None else np.minimum(found, gap)
        assert found is not None  # noqa: S101 - a body has a part
        return found


def _kept(inertia: float, ticks: float) -> float:
    """Return the share of a speed that is left after so many times 50 ms."""
    return power(inertia, ticks) if inertia > 0.0 else 0.0


def _towards(value: Floats | float, wanted: Floats, faster: float, slower: float | None = None) -> Floats:
    """Return values a step nearer to the wanted ones; `slower` is the step towards 0."""
    down = faster if slower is None else slower
    step = np.where(np.abs(wanted) > np.abs(value), faster, down)
    return value + np.clip(wanted - value, -step, step)


def _driven(speeds: Floats, rates: Floats, times: Floats | float) -> tuple[Floats, Floats, Floats]:
    """Return x, y and turned angle after each step, from the mean speeds and rates in it."""
    turns = rates * times
    turned = np.cumsum(turns, axis=1)
    s, c = sines(turned - turns / 2.0)
    way = speeds * times
    return np.cumsum(way * c, axis=1), np.cumsum(way * s, axis=1), turned
