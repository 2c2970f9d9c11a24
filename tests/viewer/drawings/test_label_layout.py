"""No two labels of a picture overlap, in made-up crowds and in what three scenes look like at every tenth tick."""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from intellwheels_maps import library
from intellwheels_viewer.cameras import FOV, STEEP, corners_of, fit, plan_of
from intellwheels_viewer.drawings.label_layout import (
    EM,
    SCALES,
    Lens,
    Picture,
    Placed,
    Wish,
    body_boxes,
    placed,
    size_of,
)

POSES = Path(__file__).parent / "label_poses.csv"
"""Where the bodies of figure6, of crossing and of 28 chairs in the ward are at each tenth tick, in metres.

From the traces (`intellwheels_server.log.true_trace`) of logs that `iw-run` wrote.
"""
MAPS = {"figure6": "room", "crossing": "crossing", "ward": "ward"}
SIZES = ((704.0, 800.0), (1024.0, 900.0), (820.0, 700.0), (390.0, 780.0))
"""What panels leave for the scene in windows of 1280 x 800, 1600 x 900, 820 x 1180 and 390 x 844."""


def overlapping(found: list[Placed]) -> list[tuple[str, str]]:
    pairs = itertools.combinations(found, 2)
    return [
        (a.text, b.text)
        for a, b in pairs
        if a.box[0] < b.box[2] and b.box[0] < a.box[2] and a.box[1] < b.box[3] and b.box[1] < a.box[3]
    ]


def named(found: list[Placed]) -> list[str]:
    return sorted(name for one in found for name in one.names)


PICTURE = Picture((0.0, -10.0, 10.0), (0.0, 0.0, 0.0), 0.8, 800.0, 600.0)


def wish(name: str, x: float = 0.0, y: float = 0.0, *, alone: bool = False, kind: str = "wheelchair") -> Wish:
    return Wish(name, name, x, y, 1.5, kind, alone)


def test_a_label_with_room_stands_above_its_body() -> None:
    (one,) = placed([wish("a", 1.0, 2.0)], PICTURE)
    assert one.position == pytest.approx((1.0, 2.0, 1.5))
    spot = Lens(PICTURE).spots(np.array(one.position))
    assert ((one.box[0] + one.box[2]) / 2, one.box[3]) == pytest.approx(tuple(spot))


def covers(box: tuple[float, ...], other: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> bool:
    return bool(
        box[0] < other[2] - 0.5 and other[0] + 0.5 < box[2] and box[1] < other[3] - 0.5 and other[1] + 0.5 < box[3]
    )


def test_a_label_is_just_clear_of_its_body_from_the_side_and_from_above() -> None:
    chair = Wish("a", "a", 0.0, 0.0, 1.5, half=(0.6, 0.35), heading=0.4)
    for eye in ((0.0, -0.02, 20.0), (0.0, -10.0, 10.0), (-8.0, -5.0, 12.0), (-10.0, 0.0, 1.5)):
        picture = Picture(eye, (0.0, 0.0, 0.5), 0.8, 800.0, 600.0)
        (one,) = placed([chair], picture)
        (body,) = body_boxes([chair], Lens(picture))
        assert not covers(one.box, body)
        assert one.box[3] == pytest.approx(body[1])
        assert body[0] < (one.box[0] + one.box[2]) / 2 < body[2]


def test_the_front_of_a_chair_is_low_and_its_label_no_farther_than_its_back() -> None:
    picture = Picture((0.0, -10.0, 14.0), (0.0, 0.0, 0.5), 0.8, 800.0, 600.0)
    away = Wish("a", "a", 0.0, 0.0, 1.5, half=(0.6, 0.35), heading=math.pi / 2)
    (low,) = placed([replace(away, front=0.5)], picture)
    (high,) = placed([away], picture)
    assert low.box[3] > high.box[3] + 5.0


def test_a_label_with_no_room_above_stands_beside_its_body() -> None:
    chair = Wish("a", "a", 0.0, 0.0, 1.5, half=(0.6, 0.35))
    behind = Wish("table", "", 0.0, 2.2, 1.2, half=(2.0, 0.8))
    picture = Picture((0.0, -10.0, 10.0), (0.0, 0.0, 0.0), 0.8, 800.0, 600.0)
    (one,) = placed([chair, behind], picture)  # a table has no label of its own
    boxes = body_boxes([chair, behind], Lens(picture))
    assert not any(covers(one.box, box) for box in boxes)
    assert 0.0 < max(boxes[0][0] - one.box[2], one.box[0] - boxes[0][2]) < 3.0


def test_a_label_stays_in_the_picture() -> None:
    chair = Wish("a", "a", 0.0, 9.8, 1.5, half=(0.6, 0.35))
    picture = Picture((0.0, -10.0, 10.0), (0.0, 0.0, 0.0), 0.8, 800.0, 600.0)
    (one,) = placed([chair], picture)
    (body,) = body_boxes([chair], Lens(picture))
    assert body[1] < one.box[3] - one.box[1]  # above it a label would be cut
    assert one.box[1] >= 0.0


def test_in_a_picture_from_above_a_label_is_beside_its_body_and_in_others_above_it() -> None:
    for eye, least, most in (((0.0, -0.02, 20.0), 20.0, 60.0), ((-10.0, 0.0, 1.5), -1.0, 1.0)):
        picture = Picture(eye, (0.0, 0.0, 1.5), 0.8, 800.0, 600.0)
        (one,) = placed([Wish("a", "a", 0.0, 0.0, 1.5, half=(1.0, 0.5), heading=math.pi / 2)], picture)
        assert least < Lens(picture).spots(np.array([0.0, 0.0, 1.5]))[1] - one.box[3] < most


def test_from_above_no_label_covers_a_body_that_it_can_avoid() -> None:
    picture = Picture((0.0, -0.02, 20.0), (0.0, 0.0, 0.0), 0.8, 800.0, 600.0)
    wishes = [
        Wish(f"c{k}", f"chair{k}", 2.0 * (k % 3), 1.9 * (k // 3), 1.5, "wheelchair", heading=k, half=(0.6, 0.35))
        for k in range(9)
    ]
    lens, found = Lens(picture), placed(wishes, picture)
    assert overlapping(found) == []
    assert len(found) == 9
    reach = 0.3 * lens.focal / 20.0
    for one, wish in itertools.product(found, wishes):
        x, y = lens.spots(np.array((wish.x, wish.y, wish.z / 2)))
        left, top, right, bottom = one.box
        assert not (left < x + reach and x - reach < right and top < y + reach and y - reach < bottom)


def test_a_label_covers_a_body_rather_than_another_label() -> None:
    picture = Picture((0.0, -0.02, 60.0), (0.0, 0.0, 0.0), 0.8, 800.0, 600.0)
    wishes = [Wish(f"c{k}", f"chair{k}", 0.7 * k, 0.0, 1.5, "wheelchair", half=(0.6, 0.35)) for k in range(20)]
    found = placed(wishes, picture)
    assert overlapping(found) == []
    assert named(found) == sorted(wish.name for wish in wishes)


def test_two_that_would_overlap_move_apart_and_stay_near() -> None:
    found = placed([wish("chair1"), wish("chair2", 0.3)], PICTURE)
    assert [one.text for one in found] == ["chair1", "chair2"]
    assert overlapping(found) == []
    for one in found:
        x = (one.box[0] + one.box[2]) / 2
        spot = Lens(PICTURE).spots(np.array([0.3 if one.text == "chair2" else 0.0, 0.0, 1.5]))
        assert abs(x - spot[0]) < 60
        assert abs(one.box[3] - spot[1]) < 60
        # Where it is in the scene is where its box is in the picture.
        assert tuple(Lens(PICTURE).spots(np.array(one.position))) == pytest.approx((x, one.box[3]))


def test_a_crowd_in_one_place_is_one_label_with_its_number() -> None:
    found = placed([wish(f"chair{k}", 0.01 * k) for k in range(30)], PICTURE)
    assert any(one.text.endswith(" chairs") for one in found)
    assert named(found) == sorted(f"chair{k}" for k in range(30))
    mixed = placed([wish(f"a{k}", kind="person" if k % 2 else "wheelchair") for k in range(30)], PICTURE)
    assert any(one.text.endswith(" bodies") for one in mixed)


def test_the_selected_and_the_speaking_never_join() -> None:
    crowd = [wish(f"chair{k}") for k in range(20)]
    found = placed([*crowd, wish("me", alone=True), wish("you", alone=True)], PICTURE)
    assert {"me", "you"} <= {one.text for one in found}
    assert overlapping(found) == []


def test_far_labels_are_smaller_and_none_is_below_eleven_pixels() -> None:
    near, far = (
        placed([wish("a")], Picture((0.0, -at, at), (0.0, 0.0, 0.0), 0.8, 800.0, 600.0))[0] for at in (4.0, 40.0)
    )
    assert near.scale > far.scale
    assert min(scale for _, scale in SCALES) * EM >= 11.0


def test_a_body_behind_the_camera_or_beside_the_picture_has_no_label() -> None:
    assert placed([wish("a", 0.0, -30.0), wish("b", 90.0, 0.0)], PICTURE) == []


def test_every_line_of_a_label_takes_room() -> None:
    assert size_of("a\nb", 1.0)[1] > size_of("a", 1.0)[1]
    assert size_of("iii", 1.0)[0] < size_of("mmm", 1.0)[0] < size_of("\u4e16\u754c\u4e16\u754c", 1.0)[0]


SPOTS = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.booleans())


@settings(max_examples=30, deadline=None)
@given(st.lists(SPOTS, max_size=40))
def test_no_crowd_has_labels_that_overlap_and_nobody_is_forgotten(spots: list[tuple[float, float, bool]]) -> None:
    wishes = [wish(f"chair{k}", x, y, alone=alone and k % 5 == 0) for k, (x, y, alone) in enumerate(spots)]
    found = placed(wishes, PICTURE)
    assert overlapping(found) == []
    inside = [one for one in wishes if placed([one], PICTURE)]
    missing = {one.name for one in inside} - set(named(found))
    # With no label but those of selected bodies there is nothing that one could join.
    assert not missing or all(one.alone for one in inside if one.name not in missing)


@cache
def poses(scene: str) -> dict[int, list[Wish]]:
    found: dict[int, list[Wish]] = {}
    with POSES.open(newline="") as rows:
        for row in csv.DictReader(rows):
            if row["scene"] == scene:
                one = Wish(row["name"], row["name"], float(row["x"]), float(row["y"]) + 0.4, 1.55, row["kind"])
                found.setdefault(int(row["tick"]), []).append(one)
    if scene == "ward":
        # The ward has places for 28 chairs. With two visitors who stand in it there are 30 bodies.
        places = {place.name: place for place in library.floor("ward").grid.position}  # type: ignore[union-attr]
        for name in ("counter", "room1-door"):
            visitor = Wish(f"at-{name}", f"at-{name}", places[name].x, places[name].y, 1.9, "person")
            for wishes in found.values():
                wishes.append(visitor)
    return found


def pictures(scene: str) -> Iterator[Picture]:
    corners = corners_of(library.floor(MAPS[scene]))
    for width, height in SIZES:
        for view in (fit(corners, STEEP, FOV, width / height), plan_of(corners, width / height)):
            position, look_at = tuple(view.position.tolist()), tuple(view.look_at.tolist())
            yield Picture(position, look_at, view.fov, width, height)


@pytest.mark.parametrize("scene", MAPS)
def test_no_two_labels_of_a_scene_overlap_at_any_tenth_tick(scene: str) -> None:
    ticks = poses(scene)
    assert len(ticks) >= 40
    assert scene != "ward" or all(len(wishes) == 30 for wishes in ticks.values())
    for number, (tick, wishes) in enumerate(ticks.items()):
        # Each tick in one of the eight views, the selection going round.
        picture = list(pictures(scene))[number % 8]
        chosen = [
            Wish(w.name, f"{w.name}  0.55 m/s", w.x, w.y, w.z, w.kind, k == number % len(wishes))
            for k, w in enumerate(wishes)
        ]
        found = placed(chosen, picture)
        assert overlapping(found) == [], (scene, tick)
        assert named(found) == sorted(w.name for w in wishes), (scene, tick)
