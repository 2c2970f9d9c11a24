"""Bodies and posts: the nearest point that is seen, directly or in a wall, whatever hides the rest."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_schemas.messages import Part, Position, Robot, Wall
from tests.server.world.sonars import heard, solid, sonar, told
from tests.server.worlds import box_wall, cart, world


def _board(x: float, y: float, width: float) -> Robot:
    """Return a body whose front is a line across the axis."""
    part = Part(x=0.05, y=0.0, length=0.1, width=width, bottom=0.0, top=1.0)
    return Robot(part=(part,), position=Position(x=x, y=y, heading=0.0))


def _screen(x: float, low: float, high: float) -> Wall:
    """Return a wall that slants away by 45 degrees: it sends the sound aside."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    ends = [(x - half, middle - half), (x + half, middle + half)]
    return solid(*ends, *((px + 0.01, py - 0.01) for px, py in reversed(ends)))


def test_body_whose_nearest_point_is_hidden_is_heard_at_the_next_one() -> None:
    """A screen from -0.21 to 0.2 m, 1.5 m away: the board is seen beside its left end, at 0.2 m in 1.7 m."""
    robots = {"a": cart(proximity=(sonar(cone_deg=54.0),)), "b": _board(3.0, 0.0, 3.0)}
    assert heard(world(robots)) == told(3.0)
    screens = [_screen(1.5, -0.2, 0.2)]
    # Its ends are at (1.7, 0.2) and (1.31, -0.21).
    aside = 3.0 * min(0.2 / 1.7, 0.21 / 1.31)
    assert heard(world(robots, screens)) == told(math.hypot(3.0, aside))
    # A second one hides that too.
    screens.append(_screen(2.2, 0.0, 0.7))
    assert heard(world(robots, screens)) == told(math.hypot(3.0, 3.0 * 0.21 / 1.31))


def test_body_that_is_hidden_altogether_is_silent() -> None:
    robots = {"a": cart(proximity=(sonar(cone_deg=30.0),)), "b": _board(3.0, 0.0, 0.6)}
    assert heard(world(robots, [_screen(1.5, -0.5, 0.5)])) == "none"


def test_sliver_that_is_too_thin_is_not_heard() -> None:
    """Of a board of 1 m, 3 m away, all but a strip beside a screen is hidden; 2.1 cm are needed."""
    for strip, is_heard in ((0.06, True), (0.005, False)):
        robots = {"a": cart(proximity=(sonar(cone_deg=30.0),)), "b": _board(3.0, 3.0 * 0.2 / 1.9 + strip - 0.5, 1.0)}
        found = heard(world(robots, [_screen(1.5, -0.6, 0.2)]))
        assert (found != "none") == is_heard


def test_body_is_heard_in_a_wall_beside_what_hides_its_nearest_point() -> None:
    """A mirror of 45 degrees sends the axis up; a screen before the board hides its middle."""
    mirror = solid((1.0, -1.0), (3.0, 1.0), (3.2, 0.8), (1.2, -1.2))
    part = Part(x=0.0, y=0.05, length=3.0, width=0.1, bottom=0.0, top=1.0)
    board = Robot(part=(part,), position=Position(x=2.0, y=2.5, heading=0.0))
    robots = {"a": cart(proximity=(sonar(cone_deg=30.0, max_range=6.0),)), "b": board}
    assert heard(world(robots, [mirror])) == told(4.5)
    screen = solid((1.9, 1.4), (1.91, 1.39), (2.11, 1.59), (2.1, 1.6))
    found = heard(world(robots, [mirror, screen]))
    assert isinstance(found, float)
    # From the image, (2, -2), past the screen's ends at (1.9, 1.4) and (2.11, 1.59).
    nearest = min(math.hypot(4.5, 4.5 * 0.1 / 3.4), math.hypot(4.5, 4.5 * 0.11 / 3.59))
    assert found == told(nearest)
    # A screen before the mirror hides what lies in the mirror between its ends at (0.91, 0.16) and (1.3, -0.2).
    found = heard(world(robots, [mirror, solid((0.9, 0.15), (0.91, 0.16), (1.31, -0.19), (1.3, -0.2))]))
    assert found == told(math.hypot(4.5, 4.5 * 0.2 / 1.3))


@pytest.mark.parametrize("cone", [30.0, 120.0, 180.0, 270.0, 360.0])
def test_nearest_seen_point_agrees_with_many_rays(cone: float) -> None:
    """Random boards behind random screens; a ray is a way to a point of the board."""
    draw = np.random.default_rng(int(cone))
    for _ in range(6):
        place = draw.uniform(1.6, 3.0)
        board = _board(place, draw.uniform(-1.5, 1.5), draw.uniform(0.5, 3.0))
        screens = [
            _screen(1.0 + 0.2 * k, low, low + draw.uniform(0.1, 0.5))
            for k, low in enumerate(draw.uniform(-1.0, 0.8, 2))
        ]
        assert board.position is not None
        half = 0.5 * board.part[0].width
        nearest = math.inf
        for y in np.linspace(board.position.y - half, board.position.y + half, 2001):
            if abs(math.atan2(y, place)) > math.radians(0.5 * cone):
                continue
            if not any(_crosses(screen, place, float(y)) for screen in screens):
                nearest = min(nearest, math.hypot(place, float(y)))
        robots = {"a": cart(proximity=(sonar(cone_deg=cone, max_range=6.0),)), "b": board}
        found = heard(world(robots, screens))
        if isinstance(found, float) and math.isfinite(nearest):
            # A screen's own edge may be nearer.
            assert found <= nearest + 0.015
            assert found == pytest.approx(nearest, abs=0.015) or found < place
        else:
            assert (found == "none" and not math.isfinite(nearest)) or isinstance(found, float)


def _crosses(screen: Wall, x: float, y: float) -> bool:
    """Return whether the way from the origin to a point meets a screen."""
    corners = [(one.x, one.y) for one in screen.corner]
    sides = [x * cy - y * cx for cx, cy in corners]
    return min(sides) < 0.0 < max(sides)


def test_post_behind_another_is_heard_beside_it() -> None:
    """Two posts in a row: the nearer one answers, and the farther one alone if the nearer is above the sonar."""
    near, far = box_wall(1.5, -0.05, 1.6, 0.05), box_wall(2.5, -0.07, 2.6, 0.07)
    lifted = Wall(corner=near.corner, bottom=0.6, height=1.0)
    assert heard(world({"a": cart(proximity=(sonar(),))}, [near, far])) == told(1.5)
    assert heard(world({"a": cart(proximity=(sonar(),))}, [lifted, far])) == told(2.5)
