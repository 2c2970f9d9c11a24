"""Double bounces, against closed forms: the distance from the image of the sonar, or to a corner."""

from __future__ import annotations

import math

import pytest

from intellwheels_schemas.messages import Part, Position, Robot, Wall
from tests.server.world.sonars import heard, readings, solid, sonar, told
from tests.server.worlds import box_wall, cart, run, world

# A wall at 45 degrees, met by the axis at (2, 0), which sends the sound to the left.
MIRROR = solid((1.0, -1.0), (3.0, 1.0), (3.2, 0.8), (1.2, -1.2))


def test_wall_sends_the_sound_to_another_and_back() -> None:
    robots = {"a": cart(proximity=(sonar(cone_deg=30.0, max_range=6.0),))}
    assert heard(world(robots, [MIRROR])) == "none"
    assert heard(world(robots, [MIRROR, box_wall(-1.0, 3.0, 5.0, 4.0)])) == told(2.0 + 3.0)
    # Beyond the range there is nothing.
    assert heard(world(robots, [MIRROR, box_wall(-1.0, 4.1, 5.0, 5.0)])) == "none"
    # Nor when something hides the second wall.
    between = solid((1.0, 1.5), (3.0, 2.1), (3.0, 2.2), (1.0, 1.6))
    assert heard(world(robots, [MIRROR, box_wall(-1.0, 3.0, 5.0, 4.0), between])) == "none"


@pytest.mark.parametrize("angle", [20.0, 35.0, 50.0])
def test_way_by_a_slanted_wall_is_the_distance_from_the_image(angle: float) -> None:
    """A wall whose normal is at an angle to the axis, 2 m away along the axis, and one at right angles to the sound."""
    turn = math.radians(angle)
    along = (-math.sin(turn), math.cos(turn))  # of the wall; its normal points to (-cos, -sin)
    corners = [(2.0 + k * along[0], k * along[1]) for k in (-0.6, 0.6)]
    mirror = solid(*corners, *((x + math.cos(turn), y + math.sin(turn)) for x, y in reversed(corners)))
    # The sound leaves (2, 0) in the direction (-cos 2a, -sin 2a) and meets a wall after 1.5 m.
    way = (-math.cos(2.0 * turn), -math.sin(2.0 * turn))
    middle = (2.0 + 1.5 * way[0], 1.5 * way[1])
    ends = [(middle[0] - k * way[1], middle[1] + k * way[0]) for k in (-0.4, 0.4)]
    wall = solid(*ends, *((x + 0.1 * way[0], y + 0.1 * way[1]) for x, y in reversed(ends)))
    state = world({"a": cart(proximity=(sonar(cone_deg=10.0),))}, [mirror, wall])
    assert heard(state) == told(3.5)


def test_body_and_post_are_heard_by_way_of_a_wall() -> None:
    robots = {"a": cart(proximity=(sonar(cone_deg=30.0, max_range=6.0),))}
    assert heard(world({**robots, "b": cart(2.0, 3.0)}, [MIRROR])) == told(2.0 + 2.7)
    assert heard(world(robots, [MIRROR, box_wall(1.955, 2.5, 2.045, 2.59)])) == told(2.0 + 2.5)


@pytest.mark.parametrize("heading", [35.0, 45.0, 55.0])
def test_corner_of_a_room_answers_from_its_vertex(heading: float) -> None:
    walls = [box_wall(2.0, -9.0, 3.0, 9.0), box_wall(-9.0, 1.5, 9.0, 3.0)]
    beam = sonar(cone_deg=30.0, direction_deg=math.degrees(math.atan2(1.5, 2.0)) + heading - 45.0)
    state = world({"a": cart(proximity=(beam,))}, walls)
    expected = math.hypot(2.0, 1.5) if abs(heading - 45.0) < 9.0 else None
    # At 10 degrees off the axis the echo is not sure: it is that of the vertex or none.
    assert heard(state) == told(2.5) if expected is not None else heard(state) in (told(2.5), "none")


def _turned(corners: list[tuple[float, float]], turn: float, digits: int = 17) -> Wall:
    c, s = math.cos(turn), math.sin(turn)
    return solid(*((round(c * x - s * y, digits), round(s * x + c * y, digits)) for x, y in corners))


@pytest.mark.parametrize("digits", [3, 17])
def test_corner_answers_at_every_turn(digits: int) -> None:
    corner = [(2.0, -9.0), (3.0, -9.0), (3.0, 3.0), (-9.0, 3.0), (-9.0, 1.5), (2.0, 1.5)]
    beam = sonar(cone_deg=30.0, direction_deg=math.degrees(math.atan2(1.5, 2.0)))
    for degrees in range(0, 360, 3):
        turn = math.radians(degrees)
        state = world({"a": cart(heading=turn, proximity=(beam,))}, [_turned(corner, turn, digits)])
        assert heard(state) == told(2.5), degrees


@pytest.mark.parametrize(("excess", "answers"), [(-0.1, True), (0.0001, True), (0.1, True), (1.0, False)])
def test_corner_answers_if_its_angle_moves_the_echo_by_less_than_a_wave(excess: float, *, answers: bool) -> None:
    """At 2.5 m a wave is 0.2 degrees."""
    lift = 11.0 * math.tan(math.radians(excess))
    corner = [(2.0, -9.0), (3.0, -9.0), (3.0, 3.0), (-9.0, 3.0), (-9.0, 1.5 + lift), (2.0, 1.5)]
    beam = sonar(cone_deg=30.0, direction_deg=math.degrees(math.atan2(1.5, 2.0)))
    for degrees in range(0, 360, 40):
        turn = math.radians(degrees)
        state = world({"a": cart(heading=turn, proximity=(beam,))}, [_turned(corner, turn)])
        assert heard(state) == (told(2.5) if answers else "none"), degrees


def test_obtuse_corner_sends_nothing_back() -> None:
    walls = [solid((2.0, 0.0), (1.0, 3.0), (3.0, 3.0)), solid((2.0, 0.0), (3.0, -3.0), (1.0, -3.0))]
    assert heard(world({"a": cart(proximity=(sonar(cone_deg=20.0),))}, walls)) == "none"


def test_direct_echo_that_is_nearer_counts() -> None:
    walls = [box_wall(2.0, -9.0, 3.0, 9.0), box_wall(-9.0, 1.5, 9.0, 3.0)]
    state = world({"a": cart(proximity=(sonar(direction_deg=0.0),))}, walls)
    assert heard(state) == told(2.0)


def test_mirror_beside_the_beam_sends_nothing() -> None:
    walls: list[Wall] = [MIRROR, box_wall(-1.0, 3.0, 5.0, 4.0)]
    beams = tuple(sonar(f"s{k}", direction_deg=turn, cone_deg=10.0) for k, turn in enumerate((-70.0, -60.0, 60.0)))
    state, _ = run(world({"a": cart(proximity=beams)}, walls), 1)
    assert readings(state) == ["none"] * 3


def test_mirror_that_is_too_thin_to_be_heard_sends_nothing_on() -> None:
    """A strip of 14 mm, 1 m away, that would show a body 3.4 m away; 32 mm are needed."""
    part = Part(x=0.0, y=0.05, length=3.0, width=0.1, bottom=0.0, top=1.0)
    board = Robot(part=(part,), position=Position(x=2.0, y=2.5, heading=0.0))
    robots = {"a": cart(proximity=(sonar(cone_deg=30.0, max_range=6.0),)), "b": board}
    for width, is_heard in ((0.01, False), (0.03, True)):
        strip = solid((1.0, 0.0), (1.0 + width, width), (1.15 + width, width - 0.12), (1.15, -0.12))
        assert (heard(world(robots, [strip])) != "none") == is_heard
        angles = [math.radians(15.0 * k) for k in range(24)]
        pillar = solid(*((1.01 + 0.3 * math.cos(angle), 2.5 + 0.3 * math.sin(angle)) for angle in angles))
        assert (heard(world({"a": robots["a"]}, [strip, pillar])) != "none") == is_heard
