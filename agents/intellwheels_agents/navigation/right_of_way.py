"""How chairs that meet agree who goes first, by messages.

A chair says its claim twice a second, "way CLASS NAME TIME X Y X Y ...": the right by which it goes, since when, and
its next points (m). The class comes first, then the name in the order of letters. Class 1 is on its way, 2 has not come
on for long, 3 is at its goal and has no right. An "i" after the class says that the chair is inside a passage without
room for two, an "s" that it stands and needs the way, a "t" that it must turn where it is and needs a circle.

Who stands on the claim of one that stands and has more right, and does not drive ahead of it anyway, drives off it. On
the way aside it claims with the right that it gives way to, and with the time of that: so those in its way give way in
turn, and the right ends with the first chair's need. So does one ahead of the other: it is pushed on. Who is outside a
narrow passage lets those come out that are inside.

Source: K. Okumura, M. Machida, X. Defago, Y. Tamura, Priority inheritance with backtracking for iterative multi-agent
path finding, Artificial Intelligence 310 (2022) 103752.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from intellwheels_agents.navigation.array_angles import Floats, sines
from intellwheels_agents.portable_math import dist
from intellwheels_schemas.messages import Heard

SAY_PERIOD: Final = 0.5
"""Time between two messages, s."""
FORGET: Final = 1.8
"""Time after which a claim that is not said any more is void, s."""
SPACING: Final = 0.6
"""Distance between the points that are said, m."""
LENGTH: Final = 4.2
"""Length of the way that is said, m."""
CIRCLE: Final = 0.5 * np.stack(sines(np.arange(8, dtype=np.float64) * (math.pi / 4.0)), axis=1)
"""Points around the centre of a chair that turns, m: with the room beside a way, a circle of 0.9 m is left free."""
USUAL, TIRED, AT_GOAL = 1, 2, 3
"""Classes of rights, the first has the most."""
_CLAIM: Final = re.compile(
    r"way ([1-3])(i?)(s?)(t?) ([a-z][a-z0-9_-]*) (\d{1,7}\.\d)((?: -?\d{1,4}\.\d -?\d{1,4}\.\d)+)"
)


class Right(NamedTuple):
    """What decides who goes first: the smaller one."""

    kind: int
    name: str


class Claim(NamedTuple):
    """What a chair claims.

    Attributes:
        right: Its right.
        since: The time of the need behind it, s.
        way: Points on its way, rows x, y, the first where it is, m.
        inside: Whether it is inside a passage without room for two.
        stands: Whether it stands, and needs the way.
        turns: Whether it must turn where it is.
    """

    right: Right
    since: float
    way: Floats
    inside: bool = False
    stands: bool = False
    turns: bool = False

    @property
    def space(self) -> Floats:
        """The points that must be left free: the way, and around a chair that must turn those of a circle."""
        return np.concatenate([self.way, self.way[:1] + CIRCLE]) if self.turns else self.way


def claim_message(claim: Claim, limit: int) -> str:
    """Return the message of a claim, in at most `limit` characters; empty if not one point fits."""
    right = claim.right
    flags = "i" * claim.inside + "s" * claim.stands + "t" * claim.turns
    head = text = f"way {right.kind}{flags} {right.name} {claim.since:.1f}"
    last = None
    for x, y in claim.way.tolist():
        if last is not None and dist((x, y), last) < SPACING:
            continue
        longer = f"{text} {x + 0.0:.1f} {y + 0.0:.1f}"
        if len(longer) > limit:
            break
        text, last = longer, (x, y)
    return "" if text == head else text


def claim_in(text: str) -> Claim | None:
    """Return the claim that a message makes; None if it is another message."""
    found = _CLAIM.fullmatch(text)
    if found is None:
        return None
    kind, inside, stands, turns, name, since, numbers = found.groups()
    points = np.array([float(word) for word in numbers.split()]).reshape(-1, 2)
    return Claim(Right(int(kind), name), float(since), halved(points), bool(inside), bool(stands), bool(turns))


def halved(way: Floats) -> Floats:
    """Return points of a way with the middles between them."""
    if way.shape[0] < 2:
        return way
    both = np.zeros((2 * way.shape[0] - 1, 2))
    both[::2] = way
    both[1::2] = (way[:-1] + way[1:]) / 2.0
    return both


class RightOfWay:
    """The claims that one chair has heard.

    Attributes:
        claims: The last claim of each sender.
    """

    def __init__(self, name: str) -> None:
        """Take the name of the chair."""
        self._name = name
        self.claims: dict[str, Claim] = {}

    def update(self, time: float, messages: Sequence[Heard]) -> None:
        """Take the messages of a tick."""
        for message in messages:
            claim = claim_in(message.text)
            if claim is not None:
                self.claims[message.sender] = claim
        self.claims = {who: claim for who, claim in self.claims.items() if time - claim.since <= FORGET}

    def of_others(self) -> list[Claim]:
        """Return the claims of those that are on their way, but not those that stem from this chair."""
        return [one for one in self.claims.values() if one.right.kind < AT_GOAL and one.right.name != self._name]
