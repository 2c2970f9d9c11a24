"""The filters of `simulation_interfaces` for bodies: names, categories, tags and a sphere. Pure."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any, Final

from intellwheels_schemas.errors import wrong_value
from intellwheels_schemas.messages import Entity, Robot
from intellwheels_schemas.rules import parts_of

OBJECT, ROBOT, HUMAN, _, DYNAMIC_OBJECT, STATIC_OBJECT = range(6)
_CATEGORIES: Final = {
    "wheelchair": ROBOT, "robot": ROBOT, "person": HUMAN, "car": DYNAMIC_OBJECT, "door": DYNAMIC_OBJECT,
}  # fmt: skip
SPHERE: Final = 3
"""The type of bounds that is supported; without points, bounds mean everything."""
MATCH_ALL: Final = 1
MOST_TAGS: Final = 64
LONGEST_PATTERN: Final = 200
MOST_REPEATS: Final = 3
"""Repeats of a pattern, such as `.*`. Names have 32 characters at most, so a match takes at most 32^3 steps."""
_REPEAT: Final = re.compile(r"[*+?{]")
_UNSAFE: Final = re.compile(r"\)[*+{]|\\[0-9]|\(\?")
"""What could make a match take forever: a repeated group, a reference to a group, an extension of Python."""


def category_of(kind: str) -> int:
    """Return the category of `EntityCategory` for the kind of a body; any other kind is an object."""
    return _CATEGORIES.get(kind, OBJECT)


def tags_of(robot: Robot) -> list[str]:
    """Return the tags of a body: its kind, and `real` for one that stands for a real chair."""
    return [robot.kind, *(["real"] if robot.type == "real" else [])]


def tags_match(wanted: Any, tags: Sequence[str]) -> bool:
    """Return whether tags pass a `TagsFilter`: any of the wanted ones or, with its mode, all of them; none pass all.

    Raises:
        WireError: There are too many.
    """
    if not wanted.tags:
        return True
    if len(wanted.tags) > MOST_TAGS:
        raise wrong_value("tags", f"at most {MOST_TAGS}", len(wanted.tags))
    found = [tag in tags for tag in wanted.tags]
    return all(found) if wanted.filter_mode == MATCH_ALL else any(found)


def matching(filters: Any, bodies: Sequence[tuple[Entity, Robot]]) -> list[Entity]:
    """Return the states of the bodies that pass an `EntityFilters`.

    Raises:
        WireError: The pattern or the bounds are not supported.
    """
    pattern = _pattern(filters.filter)
    categories = {category.category for category in filters.categories}
    sphere = _sphere(filters.bounds)
    return [
        entity
        for entity, robot in bodies
        if (pattern is None or pattern.search(entity.name))
        and (not categories or category_of(robot.kind) in categories)
        and tags_match(filters.tags, tags_of(robot))
        and (sphere is None or _touches(entity, robot, sphere))
    ]


def _pattern(text: str) -> re.Pattern[str] | None:
    """Return a pattern that is safe to match, or None for an empty one."""
    if not text:
        return None
    if len(text) > LONGEST_PATTERN or len(_REPEAT.findall(text)) > MOST_REPEATS or _UNSAFE.search(text):
        expected = f"at most {MOST_REPEATS} repeats, none of a group, in {LONGEST_PATTERN} characters"
        raise wrong_value("filters.filter", expected, repr(text[:80]))
    try:
        return re.compile(text)
    except (re.error, RecursionError, OverflowError) as error:
        raise wrong_value("filters.filter", "a regular expression", f"{text[:80]!r} ({error})") from None


def _sphere(bounds: Any) -> tuple[float, float, float] | None:
    """Return the centre and the radius of a sphere on the floor, m, or None for no bounds."""
    if not bounds.points:
        return None
    if bounds.type != SPHERE or len(bounds.points) != 2:
        got = f"type {bounds.type}, {len(bounds.points)} points"
        raise wrong_value("filters.bounds", "TYPE_SPHERE with 2 points", got)
    centre, radius = bounds.points[0], bounds.points[1].x
    if not all(map(math.isfinite, (centre.x, centre.y, radius))):
        raise wrong_value("filters.bounds", "finite numbers", "nan or inf")
    return centre.x, centre.y, radius


def _touches(entity: Entity, robot: Robot, sphere: tuple[float, float, float]) -> bool:
    """Return whether the outline of a body, seen from above, touches a circle."""
    dx, dy = sphere[0] - entity.x, sphere[1] - entity.y
    sine, cosine = math.sin(entity.heading), math.cos(entity.heading)
    x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
    return any(
        math.hypot(max(abs(x - part.x) - part.length / 2.0, 0.0), max(abs(y - part.y) - part.width / 2.0, 0.0))
        <= sphere[2]
        for part in parts_of(robot)
    )
