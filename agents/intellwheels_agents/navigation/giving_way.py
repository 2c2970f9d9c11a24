"""Drives off the way of others, and out of the swing of a door, and comes back when they have passed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from intellwheels_agents.navigation.array_angles import Floats, wrapped_all
from intellwheels_agents.navigation.body_circles import BodyCircles
from intellwheels_agents.navigation.cost_to_go import CostToGo, Weights, distances
from intellwheels_agents.navigation.footprint_clearance import Frame
from intellwheels_agents.navigation.goal_progress import Progress
from intellwheels_agents.navigation.lattice import ANGLES
from intellwheels_agents.navigation.right_of_way import AT_GOAL, TIRED, USUAL, Claim, Right, RightOfWay, halved
from intellwheels_agents.navigation.scan_points import Pose, thinned
from intellwheels_agents.portable_math import dist, sincos
from intellwheels_schemas.messages import Heard

STALLED: Final = 1.5
"""Time without progress after which it gives way, s."""
ROOM: Final = 0.42
"""Distance between a body and a way that is free for another one, m: half the width of a chair and 0.09 m."""
SPARE: Final = 0.05
"""How much more than that it keeps while it gives way, m."""
WIDE: Final = 0.45
"""A passage that is not so much wider than two bodies has no room for two, m."""
AHEAD: Final = 2.5
"""Length of the own way on which it looks for passages that another claims, m."""
MEET: Final = 0.9
"""Ways nearer to each other than this meet, m."""
SAME_WAY: Final = 0.5
"""Cosine of the angle between two ways that lead in the same direction."""
TURN_WITHIN: Final = 1.0
"""Length of the own way at whose end its direction is compared with the heading, m."""
DOOR_ROOM: Final = 1.4
"""Distance to a closed door at which its leaf can swing, m."""
RETHINK: Final = 5.0
"""Time after which a place to go to is chosen again, s."""
LONGEST: Final = 6.0
"""Longest way to such a place, m."""
STUBBORN: Final = 4.0
"""Time without progress after which it stops giving way, and the least time for which it does, s."""
WIDTH: Final = 0.4
"""Width of the band of places around a way, m."""
APART: Final = 0.15
"""Distance of a body at such a place from things that are not on the map, m."""
ACROSS: Final = 1.0
"""Cost of another heading at such a place, m per rad, against the same or the opposite one."""
PAST: Final = 0.02
"""Distance in which it can drive past them, m."""
MOVED: Final = 0.4
"""A chair that stays within this distance does not move, m."""
STUCK: Final = 9.0
"""Time without moving after which it backs out of where it is, s."""
QUEUED: Final = 25.0
"""The same among other chairs, which will move on, s."""
NEAR_BY: Final = 3.0
"""Distance to a chair that may be why it stands, m."""
OUT: Final = 6.0
"""Time for which it backs out, s."""
OUT_ROOM: Final = 0.8
"""Distance between the body and what is around it to which it backs out, m."""
ANEW: Final = 0.5
"""Distance to which it backs out where only the map is in its way, m."""
WEARY: Final = 20.0
"""Time without progress on the own way after which others have more right, s."""
REST: Final = 8.0
"""Time for which they have, s."""
THERE: Final = 0.1
"""Cost from which it is at the place, m."""

Point = tuple[float, float]
NOTHING: Final = np.zeros((0, 2))


class GivingWay:
    """When one chair gives way, and where it goes.

    Attributes:
        aside: Costs to the places where it is out of the way; None if it need not go to one.
        waits: Whether it must wait where it is.
        right: The right by which it goes.
        since: The time of the need behind that right, s.
        inside: Whether it is inside a passage without room for two.
        stands: Whether it stands, and needs the way.
        turns: Whether it must turn where it is.
        heard: The claims of the others.
    """

    def __init__(self, name: str, weights: Weights, patience: float, circles: BodyCircles) -> None:
        """Take the chair's name, the costs of its moves, how much longer than others it is stubborn (s), its body."""
        self.aside: CostToGo | None = None
        self.waits = self.inside = self.stands = self.turns = False
        self.right, self.since = Right(USUAL, name), 0.0
        self.heard = RightOfWay(name)
        self._name, self._weights, self._patience, self._circles = name, weights, patience, circles
        self._narrow = weights.narrow(2.0 * circles.side + WIDE)
        self._chosen_at = self._stubborn_until = self._weary_until = 0.0
        self._was_arrived, self._past_others = False, True
        self._progress = Progress()
        self._anchor: Point = (float("inf"), 0.0)
        self._anchored = self._out_until = 0.0

    def update(
        self,
        time: float,
        pose: Pose,
        messages: Sequence[Heard],
        stalled: float,
        arrived: bool,
        door: Point | None,
        strange: Floats,
        way: Floats = NOTHING,
    ) -> None:
        """Decide for a tick.

        Args:
            time: Simulated time, s.
            pose: The pose of the chair.
            messages: What it heard.
            stalled: For how long it has made no progress, s.
            arrived: Whether it is at its goal.
            door: A doorway ahead that something closes.
            strange: What it sees that is not on the map, m.
            way: The next points of its own way, m.
        """
        self.heard.update(time, messages)
        away = self.aside is not None or self.waits
        self._was_arrived = self._was_arrived or arrived
        own = self._own_right(time, stalled, away)
        self.inside = self._is_inside(pose)
        others = self.heard.of_others()
        above = [claim for claim in others if claim.right < own]
        room = ROOM + SPARE if away else ROOM
        pressed = [claim for claim in above if self._circles.gap(pose, claim.space) < room]
        self.right, self.since = min([(own, time), *((claim.right, claim.since) for claim in pressed)])
        self.stands = stalled > STALLED
        self.turns = _must_turn(pose, way)
        self.waits = False
        if self._out_until <= time < self._stubborn_until:
            self.aside = None
            return
        if not self._was_arrived:
            pressed = [one for one in pressed if one.stands and (away or self.stands) and not _leads(way, one)]
        first = [
            claim
            for claim in others
            if not self._was_arrived
            and (
                ((claim.right < own or (claim.inside and not self.inside)) and self._meets(way, claim))
                or (claim.right < own and claim.turns and claim.stands and _comes_near(way, claim))
            )
        ]
        self._watch(time, pose, arrived or bool(pressed or first))
        if time < self._out_until:
            self._back_out(time, pose, strange)
            return
        # Those with less right than the first make room for it and for this chair.
        first_right = min((claim.right for claim in pressed), default=own)
        most = [claim for claim in pressed if claim.right == first_right or self._was_arrived]
        if self._was_arrived and not arrived and not most and any(_cross(way, claim) for claim in others):
            # It came off its goal for others, and goes back when nobody comes any more.
            self.aside, self.waits = None, True
            return
        at_door = door is not None and dist(pose[:2], door[:2]) < 1.2 * DOOR_ROOM
        if most or first:
            points = np.concatenate([claim.space for claim in (*most, *first)])
            self._go_aside(time, pose, points, ROOM + SPARE, strange)
        elif door is not None and at_door and (away or stalled > STALLED):
            self._go_aside(time, pose, np.array([door]), DOOR_ROOM - self._circles.side, strange)
        else:
            self.aside = None

    def new_goal(self) -> None:
        """Begin to drive to another goal."""
        self._was_arrived = False

    def cost(self, pose: Pose) -> float:
        """Return the cost to the nearest place, m; infinite if none is known."""
        return float("inf") if self.aside is None else self.aside.at_pose(pose)

    def _own_right(self, time: float, stalled: float, away: bool) -> Right:
        if self._was_arrived:
            return Right(AT_GOAL, self._name)
        if not away and stalled > WEARY + self._patience and time > self._weary_until + REST:
            self._weary_until = time + REST
        return Right(TIRED if time < self._weary_until else USUAL, self._name)

    def _is_inside(self, pose: Pose) -> bool:
        """Return whether any part of the chair is inside a passage without room for two."""
        return bool(self._is_narrow(self._circles.middles(pose)).any())

    def _is_narrow(self, points: Floats) -> npt.NDArray[np.bool_]:
        frame = self._weights.frame
        i = np.clip(np.floor((points[:, 0] - frame.x) / frame.cell + 0.5).astype(np.int64), 0, frame.columns - 1)
        j = np.clip(np.floor((points[:, 1] - frame.y) / frame.cell + 0.5).astype(np.int64), 0, frame.rows - 1)
        return np.asarray(self._narrow[j, i])

    def _meets(self, way: Floats, claim: Claim) -> bool:
        """Return whether the own way meets another in a passage without room for two, not in the same direction."""
        if way.shape[0] < 2 or claim.way.shape[0] < 2:
            return False
        own, other = halved(way), claim.way
        own_step, other_step = own[1:] - own[:-1], other[1:] - other[:-1]
        own, other = own[1:], other[1:]
        driven = np.cumsum(_lengths(own_step), dtype=np.float64)
        own, own_step = own[driven <= AHEAD], own_step[driven <= AHEAD]
        if not own.shape[0]:
            return False
        off = _lengths((own[:, None, :] - other[None, :, :]).reshape(-1, 2)).reshape(own.shape[0], other.shape[0])
        lengths = _lengths(own_step)[:, None] * _lengths(other_step)[None, :]
        product = own_step[:, None, :] * other_step[None, :, :]
        along = product[:, :, 0] + product[:, :, 1]
        narrow = self._is_narrow(other)[None, :]
        return bool(((off < MEET) & narrow & (along < SAME_WAY * lengths)).any())

    def _watch(self, time: float, pose: Pose, arrived: bool) -> None:
        """Note when it has hardly moved for so long that it must back out of where it is."""
        resting = arrived or (self.aside is not None and self.cost(pose) < THERE)
        if resting or dist(pose[:2], self._anchor[:2]) > MOVED:
            self._anchor, self._anchored = (pose[0], pose[1]), time
        elif time - self._anchored > (QUEUED if self._has_company(pose) else STUCK) + self._patience:
            self._out_until, self._anchored, self.aside = time + OUT, time + OUT, None

    def _has_company(self, pose: Pose) -> bool:
        """Return whether another chair that is on its way was heard near by."""
        return any(dist(pose[:2], (claim.way[0, 0], claim.way[0, 1])) < NEAR_BY for claim in self.heard.of_others())

    def _back_out(self, time: float, pose: Pose, strange: Floats) -> None:
        near = strange[np.abs(strange - np.array([[pose[0], pose[1]]])).max(axis=1) < 2.0]
        if near.shape[0]:
            self._go_aside(time, pose, thinned(near, 0.2), OUT_ROOM, NOTHING)
        else:
            # Nothing but the map is near: it comes back to the narrow place from another side.
            self._go_aside(time, pose, np.array([self._anchor]), ANEW, NOTHING)

    def _go_aside(self, time: float, pose: Pose, points: Floats, room: float, strange: Floats) -> None:
        """Go to a place with so much room to points, or wait if this is one."""
        if self._circles.gap(pose, points) >= room:
            self.aside, self.waits = None, True
            self._anchor, self._anchored = (pose[0], pose[1]), time
            return
        if self.aside is None or time - self._chosen_at > RETHINK:
            self._past_others = True
            self.aside, self._chosen_at = self._places(points, room + SPARE, pose, strange), time
            self._progress.reset(time)
        elif self._past_others and self._has_no_place(self.cost(pose)):
            # Others leave no way to such a place: perhaps they give way too.
            self._past_others = False
            self.aside = self._places(points, room + SPARE, pose, strange)
        self._give_up(time, self.cost(pose))

    def _give_up(self, time: float, cost: float) -> None:
        """Stay on the own way if there is no place to go to, or the chair does not get there."""
        aside = self.aside
        if aside is None:
            return
        if THERE < cost <= aside.reached:
            self._progress.update(time, cost)
            if self._progress.stalled > STUBBORN:
                # Perhaps the others can move if it goes on.
                self._stubborn_until = time + STUBBORN + self._patience
        else:
            self._progress.reset(time)
        if not self._past_others and self._has_no_place(cost):
            self._stubborn_until = time + STUBBORN
        if self._stubborn_until > time:
            self.aside = None

    def _has_no_place(self, cost: float) -> bool:
        aside = self.aside
        return aside is not None and (cost > aside.reached > LONGEST or (aside.done and cost == float("inf")))

    def _places(self, points: Floats, room: float, pose: Pose, strange: Floats) -> CostToGo:
        """Return the costs to the nearest places at which the body has so much room to points."""
        frame, clearance = self._weights.frame, self._weights.clearance
        reach = int(LONGEST / frame.cell)
        i, j = int((pose[0] - frame.x) / frame.cell), int((pose[1] - frame.y) / frame.cell)
        west, east = max(0, i - reach), max(0, min(frame.columns, i + reach))
        south, north = max(0, j - reach), max(0, min(frame.rows, j + reach))
        part = Frame(frame.x + frame.cell * west, frame.y + frame.cell * south, frame.cell, east - west, north - south)
        off = distances(part, [(x, y) for x, y in thinned(points, 0.2).tolist()])
        things = distances(part, [(x, y) for x, y in thinned(strange, 0.25).tolist()])
        ends, blocked = np.zeros(clearance.shape, dtype=bool), np.zeros(clearance.shape, dtype=bool)
        for k in range(clearance.shape[0]):
            if strange.shape[0]:
                apart = self._circles.gaps(things, part, k)
                blocked[k, south:north, west:east] = apart < PAST
            if k % 2 == 0:
                gap = self._circles.gaps(off, part, k)
                place = (gap > room) & (gap < room + WIDTH) & (clearance[k, south:north, west:east] >= 0.05)
                ends[k, south:north, west:east] = place & (apart > APART) if strange.shape[0] else place
        # A chair that stands across a corridor is in everybody's way.
        turns = np.abs(wrapped_all(ANGLES - pose[2]))
        costs = (ACROSS * np.minimum(turns, np.abs(turns - math.pi)))[:, None, None]
        return CostToGo(self._weights, ends, costs, blocked if self._past_others else None)


def _must_turn(pose: Pose, way: Floats) -> bool:
    """Return whether a way leads off to the side, or back, from the heading."""
    steps = way - way[:1]
    far = steps[_lengths(steps) > TURN_WITHIN] if way.shape[0] else way
    if not far.shape[0]:
        return False
    s, c = sincos(pose[2])
    along = float(c * far[0][0] + s * far[0][1])
    return along < SAME_WAY * float(_lengths(far[:1])[0])


def _cross(way: Floats, claim: Claim) -> bool:
    """Return whether two ways come near to each other."""
    if not way.shape[0]:
        return False
    return bool((_lengths((way[:, None, :] - claim.way[None, :, :]).reshape(-1, 2)) < MEET).any())


def _comes_near(way: Floats, claim: Claim) -> bool:
    """Return whether a way comes, before long, into the circle that another chair needs to turn."""
    near = way[_lengths(way - way[:1]) <= AHEAD] if way.shape[0] else way
    return bool((_lengths(near - claim.way[:1]) < MEET).any())


def _leads(way: Floats, claim: Claim) -> bool:
    """Return whether a chair drives ahead of another on its way, so that going on clears that."""
    if way.shape[0] < 2 or claim.way.shape[0] < 2:
        return False
    step = way[min(2, way.shape[0] - 1)] - way[0]
    off = _lengths(claim.way - way[:1])
    nearest = min(int(np.argmin(off)), claim.way.shape[0] - 2)
    other = claim.way[nearest + 1] - claim.way[nearest]
    past = way[0] - claim.way[nearest]
    if nearest == 0 and float(past[0] * other[0] + past[1] * other[1]) < 0.0:
        return False
    along = float(step[0] * other[0] + step[1] * other[1])
    lengths = _lengths(np.stack([step, other]))
    return along > SAME_WAY * float(lengths[0] * lengths[1])


def _lengths(vectors: Floats) -> Floats:
    return np.asarray(np.sqrt(vectors[:, 0] * vectors[:, 0] + vectors[:, 1] * vectors[:, 1]))
