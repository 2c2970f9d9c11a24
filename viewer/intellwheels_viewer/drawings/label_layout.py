"""Where the labels of a picture stand, so that no two overlap. Pure.

A label stands above its body. If another label is there already, or a body that is seen from above, it moves up or to a
side. If there is no room between the other labels, it joins the nearest one, and both become one label with the number
of their bodies. Far labels are a little smaller.
Lengths are CSS pixels, except for positions in the scene.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]

EM: Final = 12.0
"""Font size in px of a label of scale 1, in viser."""
SCALES: Final = ((70.0, 1.1), (35.0, 1.0), (0.0, 0.92))
"""The scale of a label for a metre that is at least so many px long: 13, 12 and 11 px."""
NOUNS: Final = {"wheelchair": "chairs", "person": "people", "car": "cars", "door": "doors"}
"""The plural of a kind of body; others are bodies."""
GAP: Final = 2.0
"""Least distance between two labels."""
_LINE: Final = 1.25
"""Height of a line in em (upper bound for common fonts), and the padding of the box around it in lines."""
_PADDING: Final = 0.2
_NARROW: Final = frozenset("iljtfr.,:;'!|()[] 1-")
_WIDE: Final = frozenset("mwMW@%")
_HIGHEST: Final = 60
"""Steps by which the label of a selected or speaking body can move up; it never joins another."""
_ABOVE: Final = 0.7
"""Least sine of the angle by which a picture from above looks down."""
_NEAR: Final = 0.2  # m; nearer than this to the camera a body has no label


class Picture(NamedTuple):
    """A camera: its position and the point that it looks at, in metres; its vertical field of view; its size in px."""

    position: tuple[float, float, float]
    look_at: tuple[float, float, float]
    fov: float
    width: float
    height: float


@dataclass(frozen=True)
class Wish:
    """A label that is wanted.

    Attributes:
        name: Its body.
        text: Its lines.
        x, y, z: Where the middle of its lower edge should be, in metres: above the middle of the body.
        kind: The kind of body, see `NOUNS`.
        alone: Whether it must not join another.
        heading: That of the body, in radians.
        half: Half the length and half the width of the body, in metres. In a picture from above, a label is beyond the
            upper edge of its body, and covers no other body if that can be avoided.
    """

    name: str
    text: str
    x: float
    y: float
    z: float
    kind: str = ""
    alone: bool = False
    heading: float = 0.0
    half: tuple[float, float] = (0.0, 0.0)

    def extent(self, course: Vector) -> float:
        """Return how far the body extends from its middle along a horizontal course, in metres; 0 without a course."""
        length = float(np.hypot(course[0], course[1]))
        if length < 1e-9:
            return 0.0
        turn = math.atan2(course[1], course[0]) - self.heading
        return self.half[0] * abs(math.cos(turn)) + self.half[1] * abs(math.sin(turn))


@dataclass(frozen=True)
class Placed:
    """A label as it stands.

    Attributes:
        names: Its bodies, one or several.
        text: Its lines.
        position: The middle of its lower edge in the scene, in metres.
        scale: Its size, see `EM`.
        box: Where it is in the picture: left, top, right, bottom in px.
    """

    names: tuple[str, ...]
    text: str
    position: tuple[float, float, float]
    scale: float
    box: tuple[float, float, float, float]


@dataclass
class _Group:
    """Labels that are one."""

    members: list[Wish]
    at: Vector
    spot: Vector
    scale: float
    moved: tuple[int, int] = (0, 0)
    size: tuple[float, float] = field(init=False)

    def __post_init__(self) -> None:
        self.size = size_of(self.text, self.scale)

    @property
    def alone(self) -> bool:
        return self.members[0].alone

    @property
    def text(self) -> str:
        if len(self.members) == 1:
            return self.members[0].text
        kinds = {wish.kind for wish in self.members}
        noun = NOUNS.get(kinds.pop(), "bodies") if len(kinds) == 1 else "bodies"
        return f"{len(self.members)} {noun}"

    def box(self, step: tuple[int, int]) -> Vector:
        wide, high = self.size
        x = self.spot[0] + step[0] * (wide / 2 + GAP)
        y = self.spot[1] - step[1] * (high / 2 + GAP)
        return np.array([x - wide / 2, y - high, x + wide / 2, y])


def size_of(text: str, scale: float) -> tuple[float, float]:
    """Return the width and height of a label's box in px, rather too large than too small."""
    em, lines = EM * scale, text.split("\n")
    widest = max(sum(_advance(character) for character in line) for line in lines)
    padding = _PADDING * _LINE
    return em * (widest + padding), em * (_LINE * len(lines) + padding)


def _advance(character: str) -> float:
    if character in _NARROW:
        return 0.36
    if character in _WIDE:
        return 0.92
    return 0.62 if ord(character) < 0x1100 else 1.05


class Lens:
    """Turns points of the scene into points of a picture, and back at the same depth."""

    def __init__(self, picture: Picture) -> None:
        self.eye = np.array(picture.position)
        ahead = np.array(picture.look_at) - self.eye
        self.ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
        right = np.cross(self.ahead, (0.0, 0.0, 1.0))
        length = float(np.linalg.norm(right))
        self.right = right / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
        self.up = np.cross(self.right, self.ahead)
        self.middle = np.array([picture.width / 2, picture.height / 2])
        self.focal = picture.height / 2 / math.tan(picture.fov / 2)

    def depth(self, point: Vector) -> float:
        """Return how far ahead of the camera a point is, in metres."""
        return float((point - self.eye) @ self.ahead)

    def spot(self, point: Vector) -> Vector:
        """Return where a point ahead of the camera is, in px from the left and from the top."""
        away = point - self.eye
        depth = float(away @ self.ahead)
        return self.middle + self.focal / depth * np.array([away @ self.right, -(away @ self.up)])

    def moved(self, point: Vector, right: float, down: float) -> Vector:
        """Return the point that is so many px from a point in the picture, at the same depth."""
        metres = self.depth(point) / self.focal
        moved: Vector = point + metres * (right * self.right - down * self.up)
        return moved


def placed(wishes: Sequence[Wish], picture: Picture) -> list[Placed]:
    """Return the labels of a picture. No two boxes overlap; bodies outside the picture have none.

    It depends on nothing else, so that the same picture always has the same labels.
    """
    lens = Lens(picture)
    return [
        Placed(
            tuple(wish.name for wish in group.members),
            group.text,
            _position(group, lens),
            group.scale,
            tuple(group.box(group.moved).tolist()),
        )
        for group in _arranged(wishes, lens, picture)
    ]


def _position(group: _Group, lens: Lens) -> tuple[float, float, float]:
    left, _, right, bottom = group.box(group.moved)
    x, y, z = lens.moved(group.at, (left + right) / 2 - group.spot[0], bottom - group.spot[1])
    return float(x), float(y), float(z)


def _arranged(wishes: Sequence[Wish], lens: Lens, picture: Picture) -> list[_Group]:
    groups = [group for wish in wishes if (group := _group([wish], lens, picture)) is not None]
    bodies = _bodies([group.members[0] for group in groups], lens)
    # Labels that stay alone come first, and the order does not change while the bodies move.
    groups.sort(key=lambda group: not group.alone)
    while (lonely := _unplaced(groups, bodies)) is not None:
        others = [group for group in groups if group is not lonely and not group.alone]
        if not others:
            groups.remove(lonely)  # there is room for the labels of the selected and the speaking only
            continue
        nearest = min(others, key=lambda group: float(np.hypot(*(group.spot - lonely.spot))))
        joined = _group([*nearest.members, *lonely.members], lens, picture)
        groups = [group for group in groups if group is not lonely and group is not nearest]
        if joined is not None:
            groups.append(joined)
    return groups


def _group(members: list[Wish], lens: Lens, picture: Picture) -> _Group | None:
    """Return labels as one, or None outside the picture."""
    above = lens.up * (1.0, 1.0, 0.0)
    at = np.mean([np.array((wish.x, wish.y, wish.z)) + wish.extent(above) * above for wish in members], axis=0)
    depth = lens.depth(at)
    if depth < _NEAR:
        return None
    spot = lens.spot(at)
    if not (0.0 <= spot[0] <= picture.width and 0.0 <= spot[1] <= picture.height):
        return None
    metre = lens.focal / depth
    return _Group(members, at, spot, next(scale for least, scale in SCALES if metre >= least))


def _bodies(wishes: Sequence[Wish], lens: Lens) -> Vector:
    """Return the boxes of bodies in a picture from above, in px, shape (n, 4); none in a picture from the side."""
    tilt = -float(lens.ahead[2])
    if tilt < _ABOVE:
        return np.empty((0, 4))
    found = []
    for wish in wishes:
        at = np.array((wish.x, wish.y, wish.z / 2))
        depth = lens.depth(at)
        if depth > _NEAR:
            x, y = lens.spot(at)
            wide, high = np.array((wish.extent(lens.right), tilt * wish.extent(lens.up))) * lens.focal / depth
            found.append((x - wide, y - high, x + wide, y + high))
    return np.array(found).reshape(-1, 4)


def _unplaced(groups: Sequence[_Group], bodies: Vector) -> _Group | None:
    """Place the groups one after the other, and return the first for which there is no room; None if there is none."""
    taken = np.empty((len(groups), 4))
    for count, group in enumerate(groups):
        others = taken[:count]
        free: tuple[int, int] | None = None
        for step in (*_STEPS, *_TOWER) if group.alone else _STEPS:
            box = group.box(step)
            if not _is_free(box, others):
                continue
            covers = not _is_free(box, bodies)
            if free is None or not covers:
                free = step
            if not covers:
                break
        if free is None:
            return group
        group.moved = free
        taken[count] = group.box(group.moved)
    return None


def _is_free(box: Vector, others: Vector) -> bool:
    apart = (
        (others[:, 0] >= box[2] + GAP)
        | (others[:, 2] <= box[0] - GAP)
        | (others[:, 1] >= box[3] + GAP)
        | (others[:, 3] <= box[1] - GAP)
    )
    return bool(apart.all())


_STEPS: Final = ((0, 0), (0, 1), (0, 2), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, 2), (-1, 2), (0, 3), (0, 4))
"""Where a label may stand, in half widths to the right and half heights up. It is never far from its body."""
_TOWER: Final = tuple((0, step) for step in range(5, _HIGHEST))
"""Where the label of a selected or speaking body may stand too."""
