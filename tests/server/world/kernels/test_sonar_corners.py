"""Convex corners: round pillars from every side, sharp edges by the theory of diffraction, and no seams."""

from __future__ import annotations

import math

import pytest

from intellwheels_schemas.messages import Wall
from intellwheels_server.world.kernels.sonar_corners import edge_width, round_width
from tests.server.world.sonars import heard, many, readings, solid, sonar, told
from tests.server.worlds import box_wall, cart, run, world

WAVE = 346.0 / 40e3


def _pillar(x: float, y: float, radius: float, sides: int, turn: float) -> Wall:
    angles = [turn + 2.0 * math.pi * k / sides for k in range(sides)]
    return solid(*((x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles))


@pytest.mark.parametrize(("sides", "radius"), [(8, 0.2), (12, 0.3), (16, 0.5), (24, 0.3), (64, 0.4)])
def test_round_pillar_is_heard_from_every_side(sides: int, radius: float) -> None:
    """It echoes from its nearest corner or face, as far as the sonar hears."""
    for step in range(8):
        turn = step / 8.0 * 2.0 * math.pi / sides
        pillar = _pillar(4.0, 0.0, radius, sides, turn)
        # The angle between the axis and the nearest normal of a face.
        off = abs((turn + math.pi / sides + math.pi) % (2.0 * math.pi / sides))
        off = min(off, 2.0 * math.pi / sides - off)
        found = heard(world({"a": cart(proximity=(sonar(cone_deg=20.0),))}, [pillar]))
        nearest = min(math.hypot(corner.x, corner.y) for corner in pillar.corner)
        face = 4.0 - radius * math.cos(math.pi / sides)
        assert found in (told(nearest), told(face)), (turn, off)


def test_pillar_is_heard_by_way_of_a_wall() -> None:
    mirror = solid((1.0, -1.0), (3.0, 1.0), (3.2, 0.8), (1.2, -1.2))
    beam = sonar(cone_deg=8.0, max_range=6.0)
    state = world({"a": cart(proximity=(beam,))}, [mirror, _pillar(2.0, 2.3, 0.3, 24, math.pi / 2.0)])
    assert heard(state) == told(2.0 + 2.0)


def test_edge_is_heard_as_far_as_the_cylinder_that_sends_as_much_back() -> None:
    """In the middle of a right angle: n = 3/2, S = -2/3 + 2, so 0.52 mm: 0.873 m."""
    width = edge_width(1.5 * math.pi, 0.75 * math.pi, WAVE)
    assert width == pytest.approx(WAVE * (math.sin(2.0 / 3.0 * math.pi) * (2.0 - 2.0 / 3.0) / (1.5 * math.pi)) ** 2)
    limit = 1.6 * (width / 0.0032) ** (1.0 / 3.0)
    assert limit == pytest.approx(0.873, abs=0.001)
    for distance, is_heard in ((limit - 0.002, True), (limit + 0.002, False)):
        wedge = solid((distance, 0.0), (distance + 2.0, -2.0), (distance + 2.0, 2.0))
        state = world({"a": cart(proximity=(sonar(cone_deg=20.0),))}, [wedge])
        assert heard(state) == (told(distance) if is_heard else "none")


def test_edge_is_louder_towards_the_normals_of_its_faces() -> None:
    widths = [edge_width(1.5 * math.pi, math.radians(phi), WAVE) for phi in (90.0, 92.0, 100.0, 135.0, 170.0, 180.0)]
    assert widths[0] == math.inf
    assert widths[1] > widths[2] > widths[3]
    assert widths[2] == pytest.approx(widths[4])
    assert widths[5] > 1e6  # by rounding it is no normal


def test_echo_of_a_corner_is_as_likely_as_that_of_a_wall() -> None:
    """At 24 degrees off the axis, in a beam of 60, half of the pings; beyond 30 none."""
    for turn, least, most in ((24.0, 16, 48), (31.0, 0, 0), (10.0, 64, 64)):
        sonars = many(64, direction_deg=turn)
        state, _ = run(world({"a": cart(proximity=sonars)}, [_pillar(3.0, 0.0, 0.3, 24, 0.0)]), 1)
        assert least <= sum(one == told(2.7) for one in readings(state)) <= most


def test_round_corner_is_one_that_bends_little_and_stands_out_little() -> None:
    assert round_width(math.radians(45.0), 0.1) == pytest.approx(0.1 / math.tan(math.radians(22.5)))
    assert round_width(math.radians(46.0), 0.1) == 0.0
    # 0.1 m beside a bend of 45 degrees stand out by 0.05 tan(11.25 degrees) = 1 cm; 0.3 m by 3 cm.
    assert round_width(math.radians(45.0), 0.3) == 0.0
    assert round_width(math.radians(1.0), 3.0) > 100.0


@pytest.mark.parametrize("beyond", [0.0, 0.5])
def test_seam_of_two_walls_is_no_corner(beyond: float) -> None:
    """Two boxes side by side make one wall. In the middle of the beam is the seam, 14 degrees off the normal."""
    walls = [box_wall(0.8, -3.0, 1.5, 0.0), box_wall(0.8, 0.0, 1.5, 3.0 + beyond)]
    state = world({"a": cart(proximity=(sonar(cone_deg=10.0, direction_deg=14.0, y=-0.2),))}, walls)
    assert heard(state) == "none"
    # Nor is a corner inside another wall.
    walls = [box_wall(0.8, -0.1, 1.5, 0.1), box_wall(0.7, -0.2, 1.6, 0.2)]
    state = world({"a": cart(proximity=(sonar(cone_deg=4.0, y=-0.25),))}, walls)
    assert heard(state) in (told(math.hypot(0.7, 0.05)), "none")


def test_corner_behind_something_is_not_heard() -> None:
    pillar = _pillar(3.0, 0.0, 0.3, 24, 0.0)
    screen = solid((1.5, -1.0), (1.6, -1.0), (2.1, 1.0), (2.0, 1.0))
    assert heard(world({"a": cart(proximity=(sonar(cone_deg=10.0),))}, [pillar, screen])) == "none"


def test_pillar_that_ends_below_the_sonar_is_not_heard() -> None:
    pillar = _pillar(3.0, 0.0, 0.3, 24, 0.0)
    low = Wall(corner=pillar.corner, height=0.3)
    assert heard(world({"a": cart(proximity=(sonar(cone_deg=10.0),))}, [low])) == "none"
