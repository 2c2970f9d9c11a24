from __future__ import annotations

import numpy as np
import numpy.typing as npt

from intellwheels_viewer.cameras import first_person
from intellwheels_viewer.drawings.chair_frame import arm_height, frame_of, stick
from intellwheels_viewer.drawings.occupant import SHOES, SKIN, TROUSERS, occupant
from intellwheels_viewer.drawings.own_body import CUFF, NAIL, PIVOT, SHOE, SOLE, grip, rest_of
from intellwheels_viewer.drawings.solids import Solid
from intellwheels_viewer.head_turn import eye_of
from intellwheels_viewer.palette import RGB
from tests.every_case import every_case
from tests.viewer.drawings.cast import entity, robot
from tests.viewer.projection import in_picture

CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")
NARROW = 0.8
"""Width over height of a picture that a page of 1280 x 800 shows between its panels, rounded down."""

Points = npt.NDArray[np.float64]


def seen(name: str, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return which points of a chair's frame, (n, 3), are in the picture that its driver sees."""
    return in_picture(first_person(entity("a"), eye_of(robot(name))), points, NARROW)


def hidden(eye: Points, point: Points, behind: Solid) -> bool:
    """Return whether a solid is between two points (Möller and Trumbore, 1997)."""
    a, b, c = (behind.vertices[behind.faces[:, k]].astype(float) for k in range(3))
    way = point - eye
    p = np.cross(way, c - a)
    flat = np.sum((b - a) * p, axis=1)
    flat[flat == 0.0] = np.inf
    q = np.cross(eye - a, b - a)
    u, v = np.sum((eye - a) * p, axis=1) / flat, np.sum(way * q, axis=1) / flat
    along = np.sum((c - a) * q, axis=1) / flat
    return bool(np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (along > 0) & (along < 0.999)))


def placed(name: str, rgb: RGB) -> Points:
    """Return what has a colour at the joystick of a chair, in the chair's frame."""
    frame = frame_of(robot(name))
    points: Points = grip()[rgb].vertices + np.array([*stick(frame), arm_height(frame) + PIVOT])
    return points


def right_hand(name: str) -> Points:
    return placed(name, SKIN)


@every_case("name", CHAIRS)
def test_both_hands_are_in_the_picture_with_all_fingers(name: str) -> None:
    frame = frame_of(robot(name))
    rest = rest_of(frame)
    assert len(rest[NAIL].vertices) == len(grip()[NAIL].vertices) == 5 * 4
    for skin, nails in ((right_hand(name), placed(name, NAIL)), (rest[SKIN].vertices, rest[NAIL].vertices)):
        assert seen(name, skin).mean() > 0.9, "a wrist may be cut off"
        assert seen(name, nails).all()


@every_case("name", CHAIRS)
def test_both_shoes_are_seen_past_the_knees(name: str) -> None:
    document = robot(name)
    frame = frame_of(document)
    shoes, legs = rest_of(frame), occupant(frame)[1][TROUSERS]
    eye = first_person(entity("a"), eye_of(document)).position
    for rgb in (SOLE, SHOE):
        points = shoes[rgb].vertices.astype(float)
        assert seen(name, points).all()
        for side in (points[points[:, 1] > 0], points[points[:, 1] < 0]):
            toes = side[side[:, 0] > frame.hull.front - 0.10]
            free = [not hidden(eye, point, legs) for point in toes]
            assert np.mean(free) > 0.5, f"{name} {rgb}"


@every_case("name", CHAIRS)
def test_they_cover_the_plain_hands_and_shoes_that_everybody_sees(name: str) -> None:
    frame = frame_of(robot(name))
    person, own = occupant(frame)[1], rest_of(frame)
    plain, shoes = person[SHOES].vertices, np.concatenate([own[SHOE].vertices, own[SOLE].vertices])
    assert (shoes.min(axis=0) <= plain.min(axis=0)).all()
    assert (shoes.max(axis=0) >= plain.max(axis=0)).all()
    hands = person[SKIN].vertices
    hands = hands[hands[:, 0] > frame.rear + 0.45]
    for side, hand in ((1, own[SKIN].vertices), (-1, right_hand(name))):
        flesh = hands[hands[:, 1] * side > 0]
        assert len(flesh)
        assert (flesh.min(axis=0) >= hand.min(axis=0)).all()
        assert (flesh.max(axis=0) <= hand.max(axis=0)).all()


@every_case("name", CHAIRS)
def test_they_stay_in_the_box_of_the_chair(name: str) -> None:
    frame = frame_of(robot(name))
    points = np.concatenate([right_hand(name), *(each.vertices for each in rest_of(frame).values())])
    assert (np.abs(points[:, 1]) <= frame.hull.left + 0.001).all()
    assert float(points[:, 0].max()) <= frame.hull.front + 0.001


def test_a_hand_has_a_few_hundred_triangles_and_so_has_a_pair_of_shoes() -> None:
    moving, rest = grip(), rest_of(frame_of(robot("rear-wheel")))
    assert 200 < len(moving[SKIN].faces) <= 400
    assert len(rest[SKIN].faces) == len(moving[SKIN].faces)
    assert len(rest[SHOE].faces) + len(rest[SOLE].faces) <= 420
    assert sum(len(each.faces) for made in (moving, rest) for each in made.values()) <= 1400


def test_the_fingers_are_apart_and_have_nails_that_look_up() -> None:
    nails = grip()[NAIL]
    middles = np.sort(nails.vertices.reshape(5, 4, 3).mean(axis=1)[:, 1])
    assert (np.diff(middles) > 0.015).all()
    a, b, c = (nails.vertices[nails.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_the_shortest_chair_has_hands_too() -> None:
    frame = frame_of(robot("rear-wheel", part=(), length=0.4, width=0.3, center=0.1, top=0.6))
    assert all(np.isfinite(each.vertices).all() for each in rest_of(frame).values())
    assert len(rest_of(frame)[CUFF].faces)
    assert all(np.isfinite(each.vertices).all() for each in occupant(frame)[1].values())
