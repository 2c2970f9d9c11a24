"""What sonars hear directly: walls at right angles, posts, bodies, and what hides what."""

from __future__ import annotations

import math

import pytest

from intellwheels_schemas.messages import Part, Position, Robot
from tests.server.world.sonars import heard, many, readings, solid, sonar, told
from tests.server.worlds import box_wall, cart, run, world

AHEAD = box_wall(2.0, -9.0, 3.0, 9.0)


def test_wall_is_heard_where_the_beam_meets_it_at_right_angles() -> None:
    turned = [0.0, 15.0, -15.0]
    sonars = tuple(sonar(f"s{k}", direction_deg=turn) for k, turn in enumerate(turned))
    state, _ = run(world({"a": cart(proximity=sonars)}, [AHEAD]), 1)
    # Not the distance along the axis, which is longer.
    assert readings(state) == [told(2.0)] * 3


@pytest.mark.parametrize("cone", [10.0, 20.0, 55.0, 72.0])
def test_wall_outside_the_beam_is_never_heard(cone: float) -> None:
    sonars = many(direction_deg=0.5 * cone + 0.1, cone_deg=cone)
    state = world({"a": cart(proximity=sonars)}, [AHEAD])
    for _ in range(5):
        state, _ = run(state, 1)
        assert readings(state) == ["none"] * 64


def test_sonar_of_20_degrees_does_not_hear_a_wall_at_24() -> None:
    state = world({"a": cart(proximity=many(direction_deg=24.0, cone_deg=20.0))}, [AHEAD])
    state, _ = run(state, 1)
    assert readings(state) == ["none"] * 64


def test_wall_that_ends_before_the_beam_meets_it_is_not_heard() -> None:
    state = world({"a": cart(proximity=(sonar(),))}, [box_wall(2.0, 0.6, 3.0, 9.0)])
    assert heard(state) == "none"


@pytest.mark.parametrize("body", [True, False])
def test_thin_thing_is_heard_as_far_as_a_cylinder_sends_enough_back(*, body: bool) -> None:
    """3.2 mm at 1.6 m (LoPresti et al. 2011); others by the cube root of their width."""
    for width in (0.0032, 0.005, 0.025):
        limit = 1.6 * (width / 0.0032) ** (1.0 / 3.0)
        for distance, is_heard in ((0.5, True), (limit - 0.001, True), (limit + 0.001, False)):
            robots = {"a": cart(proximity=(sonar(),))}
            walls = []
            half = 0.5 * width
            if body:
                part = Part(x=0.0, y=0.0, length=width, width=width, bottom=0.0, top=1.0)
                robots["post"] = Robot(part=(part,), position=Position(x=distance + half, y=0.0, heading=0.0))
            else:
                walls.append(box_wall(distance, -half, distance + width, half))
            assert heard(world(robots, walls)) == (told(distance) if is_heard else "none")


def test_wheelchair_sensors_hear_3_2_mm_at_1_6_m() -> None:
    """The check of LoPresti et al. (2011), JRRD 48(5), 529."""
    thread = box_wall(1.6, -0.0016, 1.6032, 0.0016)
    devices = {"srf08": (55.0, 6.0), "srf10": (72.0, 6.0), "hc-sr04": (15.0, 4.0)}
    sonars = tuple(
        sonar(name, device=name, cone_deg=cone, min_range=0.06, max_range=far, every=2)
        for name, (cone, far) in devices.items()
    )
    state, _ = run(world({"a": cart(proximity=sonars)}, [thread]), 1)
    assert readings(state) == [told(1.6)] * 3


@pytest.mark.parametrize("body", [True, False])
def test_wire_that_is_too_thin_to_be_heard_hides_nothing(*, body: bool) -> None:
    robots = {"a": cart(proximity=(sonar(),))}
    walls = [box_wall(3.0, -9.0, 4.0, 9.0)]
    if body:
        part = Part(x=0.0, y=0.0, length=0.005, width=0.005, bottom=0.0, top=1.0)
        robots["wire"] = Robot(part=(part,), position=Position(x=2.0, y=0.0, heading=0.0))
    else:
        walls.append(box_wall(2.0, -0.0025, 2.005, 0.0025))
    assert heard(world(robots, walls)) == told(3.0)


def test_thin_wall_seen_from_its_end_hides_nothing_and_from_its_side_everything() -> None:
    behind = box_wall(4.0, -9.0, 5.0, 9.0)
    cart_with_a_sonar = {"a": cart(proximity=(sonar(cone_deg=20.0),))}
    assert heard(world(cart_with_a_sonar, [behind, box_wall(2.0, -0.0025, 3.0, 0.0025)])) == told(4.0)
    slanted = solid((1.0, -2.0), (1.005, -2.0), (4.005, 2.0), (4.0, 2.0))
    assert heard(world(cart_with_a_sonar, [behind, slanted])) == "none"


def test_post_answers_from_whatever_side_it_is_seen() -> None:
    walls = [solid((2.0, 0.0), (2.02, -0.02), (2.04, 0.0), (2.02, 0.02))]
    assert heard(world({"a": cart(proximity=(sonar(),))}, walls)) == told(2.0)


def test_small_solid_is_a_post_at_every_turn() -> None:
    """A square of 9 cm, turned about its middle; its nearest point is a corner or an edge."""
    for degrees in range(0, 90, 10):
        corners = [0.045 * math.sqrt(2.0) * complex(math.cos(at), math.sin(at)) for at in (
            math.radians(degrees + 45 + 90 * k) for k in range(4)
        )]  # fmt: skip
        state = world({"a": cart(proximity=(sonar(),))}, [solid(*((2.0 + one.real, one.imag) for one in corners))])
        assert heard(state) in (told(2.0 - max(-one.real for one in corners)), told(1.955)), degrees


def test_body_answers_from_whatever_side_it_is_seen() -> None:
    robots = {"a": cart(proximity=(sonar(),)), "b": cart(3.0, heading=math.radians(45))}
    nearest = 3.0 - 0.8 * math.sqrt(0.5)  # the corner
    assert heard(world(robots)) == told(nearest)


def test_inner_cuts_of_a_concave_solid_return_no_echo() -> None:
    """A chevron that opens to the sonar: only the edges at its ends are heard, and its inner corner is too far."""
    walls = [solid((2.0, -3.0), (5.0, 0.0), (2.0, 3.0), (2.0, 4.0), (6.0, 0.0), (2.0, -4.0))]
    sonars = tuple(
        sonar(f"s{k}", x=-1.2, direction_deg=float(turn), cone_deg=20.0) for k, turn in enumerate(range(-60, 61, 5))
    )
    state, _ = run(world({"a": cart(proximity=sonars)}, walls), 1)
    assert all(one == "none" or one == told(math.hypot(3.2, 3.0)) for one in readings(state))


@pytest.mark.parametrize("cuts", [1, 2, 5, 50])
def test_wall_is_heard_as_often_and_as_far_however_it_was_cut(cuts: int) -> None:
    """A wall of 0.5 m, of blocks; a face of 0.01 m alone is heard up to 2.34 m."""
    step = 0.5 / cuts
    walls = [box_wall(4.0, step * k - 0.25, 4.3, step * (k + 1) - 0.25) for k in range(cuts)]
    whole = [box_wall(4.0, -0.25, 4.3, 0.25)]
    sonars = many(64, direction_deg=24.0, max_range=6.0)
    found = [run(world({"a": cart(proximity=sonars)}, made), 1)[0] for made in (walls, whole)]
    assert readings(found[0]) == readings(found[1])
    assert 0 < sum(one == told(4.0) for one in readings(found[0])) < 64


def test_body_is_heard_as_far_however_it_was_cut_into_parts() -> None:
    """Ten slats of 5 mm side by side are heard as a board of 5 cm, up to 4 m; one is, up to 1.86 m."""
    slats = tuple(Part(x=0.0, y=0.005 * k - 0.0225, length=0.02, width=0.005, bottom=0.0, top=1.0) for k in range(10))
    wall = box_wall(4.5, -9.0, 5.0, 9.0)
    for parts, is_heard in ((slats, True), (slats[:1], False), (slats[::2], False)):
        slab = Robot(part=parts, position=Position(x=3.51, y=0.0, heading=0.0))
        state = world({"a": cart(proximity=(sonar(cone_deg=4.0),)), "slab": slab}, [wall])
        assert heard(state) == told(3.5 if is_heard else 4.5)


def test_too_close_and_inside_are_near() -> None:
    walls = [box_wall(1.0, -1.0, 2.0, 1.0)]
    assert heard(world({"a": cart(proximity=(sonar(min_range=1.2),))}, walls)) == "near"
    assert heard(world({"a": cart(proximity=(sonar(x=1.5),))}, walls)) == "near"
    assert heard(world({"a": cart(proximity=(sonar(x=1.5),)), "b": cart(1.5)})) == "near"


def test_noise_of_a_sonar_does_not_depend_on_other_things_and_sonars() -> None:
    alone, _ = run(world({"a": cart(proximity=(sonar(),))}, [AHEAD]), 1)
    others = (sonar("other", x=0.1), sonar())
    crowded = world({"a": cart(proximity=others), "b": cart(0.0, 3.0, proximity=(sonar(),))}, [AHEAD])
    for _ in range(20):
        crowded, _ = run(crowded, 1)
        assert readings(crowded)[1] == readings(alone)[0]
        alone, _ = run(alone, 1)
