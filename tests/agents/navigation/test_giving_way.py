"""A chair drives off the way of another, waits before narrow passages, and backs out of where it is stuck."""

from __future__ import annotations

import math

import numpy as np

from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.navigation.body_circles import BodyCircles
from intellwheels_agents.navigation.footprint_clearance import boxes_of
from intellwheels_agents.navigation.giving_way import ANEW, DOOR_ROOM, OUT_ROOM, ROOM, STALLED, STUCK, WEARY, GivingWay
from intellwheels_agents.navigation.right_of_way import AT_GOAL, TIRED, USUAL, Claim, Right, claim_message
from intellwheels_schemas.messages import Heard
from tests.agents.navigation.rooms import CHAIR, room, weights

GIVEN = weights(room(size=8.0))
GATE = weights(room((3.9, 0.0, 4.1, 3.4), (3.9, 4.6, 4.1, 8.0), size=8.0))
CIRCLES = BodyCircles(boxes_of(CHAIR))
NOTHING = np.zeros((0, 2))
HERE = (4.0, 4.0, 0.0)
ACROSS = np.array([(4.3, 0.5 + 0.1 * i) for i in range(36)])
AHEAD = np.array([(4.0 + 0.2 * i, 4.0) for i in range(10)])


def waits(name: str = "chair2", on: object = GIVEN) -> GivingWay:
    return GivingWay(name, on, 0.0, CIRCLES)  # type: ignore[arg-type]


def heard(way: Floats, time: float, sender: str = "chair1", **flags: bool) -> tuple[Heard, ...]:
    text = claim_message(Claim(Right(USUAL, sender), time, way, **flags), 100)
    return (Heard(sender=sender, tick=1, distance=1.0, text=text),)


def end_of(giving: GivingWay, pose: tuple[float, float, float] = HERE) -> tuple[float, float]:
    assert giving.aside is not None
    giving.aside.expand(10**7)
    return giving.aside.way(*pose, 20.0)[-1]


def test_stalled_chair_with_less_right_drives_off_the_way_and_passes_the_right_on() -> None:
    giving = waits()
    giving.update(1.0, HERE, heard(ACROSS, 1.0, stands=True), STALLED + 1.0, False, None, NOTHING)
    x, y = end_of(giving)
    assert min(math.dist((x, y), point) for point in ACROSS.tolist()) > ROOM
    assert giving.right == Right(USUAL, "chair1")
    assert giving.since == 1.0
    giving.update(9.0, HERE, (), 0.0, False, None, NOTHING)
    assert giving.aside is None
    assert giving.right == Right(USUAL, "chair2")


def test_chair_that_drives_or_has_more_right_or_is_not_asked_does_not() -> None:
    for name, stalled, stands in (("chair2", 0.0, True), ("chair0", STALLED + 1.0, True), ("chair2", 9.0, False)):
        giving = waits(name)
        giving.update(1.0, HERE, heard(ACROSS, 1.0, stands=stands), stalled, False, None, NOTHING)
        assert giving.aside is None


def test_chair_ahead_of_another_goes_on_with_its_right() -> None:
    giving = waits()
    behind = np.array([(2.0 + 0.3 * i, 4.0) for i in range(14)])
    giving.update(1.0, HERE, heard(behind, 1.0, stands=True), STALLED + 1.0, False, None, NOTHING, AHEAD)
    assert giving.aside is None
    assert giving.right == Right(USUAL, "chair1")


def test_chair_at_its_goal_drives_off_any_way_and_has_no_right() -> None:
    giving = waits("chair0")
    giving.update(1.0, HERE, heard(ACROSS, 1.0), 0.0, True, None, NOTHING)
    assert giving.aside is not None
    giving.update(9.0, HERE, (), 0.0, False, None, NOTHING)
    assert giving.right.kind == AT_GOAL
    giving.new_goal()
    giving.update(9.1, HERE, (), 0.0, False, None, NOTHING)
    assert giving.right.kind == USUAL


def test_chair_waits_before_a_passage_while_another_is_inside() -> None:
    giving = waits("chair0", GATE)
    here = (2.2, 4.0, 0.0)
    own = np.array([(2.2 + 0.2 * i, 4.0) for i in range(15)])
    through = np.array([(4.0 - 0.2 * i, 4.0 - 0.2 * max(0, i - 2)) for i in range(12)])
    giving.update(1.0, here, heard(through, 1.0, inside=True), 0.0, False, None, NOTHING, own)
    assert giving.waits or giving.aside is not None
    # Without a narrow passage the two find their ways past each other, and in the same direction nobody waits.
    for other, on in ((through, GIVEN), (own + np.array([[1.0, 0.0]]), GATE)):
        giving = waits("chair0", on)
        giving.update(1.0, here, heard(other, 1.0, inside=True), 0.0, False, None, NOTHING, own)
        assert not giving.waits
        assert giving.aside is None
    giving.update(2.0, (4.0, 4.0, 0.0), (), 0.0, False, None, NOTHING, own)
    assert giving.inside


def test_chair_leaves_room_for_the_swing_of_a_door() -> None:
    giving = waits()
    giving.update(1.0, HERE, (), STALLED + 1.0, False, (4.8, 4.0), NOTHING)
    assert math.dist(end_of(giving), (4.8, 4.0)) > DOOR_ROOM - 0.05


def test_stuck_chair_backs_out() -> None:
    giving = waits()
    blocked = np.array([[4.8, 4.0], [4.8, 4.3]])
    giving.update(0.0, HERE, (), 0.0, False, None, blocked)
    giving.update(STUCK + 0.1, HERE, (), STUCK, False, None, blocked)
    x, y = end_of(giving)
    assert min(math.dist((x, y), point) for point in blocked.tolist()) > OUT_ROOM - 0.2


def test_chair_goes_around_what_stands_beside_it_to_its_place() -> None:
    # What it sees leaves only the way back: the nearest places, ahead and beside, cannot be reached.
    strange = np.array([(3.4 + 0.1 * i, y) for i in range(20) for y in (4.6, 3.4)] + [(5.0, 4.0), (5.0, 4.3)])
    giving = waits()
    giving.update(1.0, HERE, heard(ACROSS, 1.0, stands=True), STALLED + 1.0, False, None, strange)
    giving.update(1.1, HERE, (), STALLED + 1.0, False, None, strange)
    x, _ = end_of(giving)
    assert x < 3.7


def test_chair_that_does_not_get_out_of_the_way_goes_on() -> None:
    giving = waits()
    given_way = []
    for tick in range(120):
        asked = heard(ACROSS, 0.05 * tick, stands=True)
        giving.update(0.05 * tick, HERE, asked, STALLED + 1.0, False, None, NOTHING)
        if giving.aside is not None:
            giving.aside.expand(10**6)
        given_way.append(giving.aside is not None)
    assert given_way[:70] == [True] * 70
    assert not any(given_way[90:])


def test_chair_that_is_stuck_at_the_map_comes_anew() -> None:
    giving = waits()
    giving.update(0.0, HERE, (), 0.0, False, None, NOTHING)
    giving.update(STUCK + 0.1, HERE, (), STUCK, False, None, NOTHING)
    assert math.dist(end_of(giving), HERE[:2]) > ANEW


def test_chair_that_does_not_come_on_for_long_has_less_right_for_a_while() -> None:
    giving = waits()
    giving.update(30.0, HERE, (), WEARY + 1.0, False, None, NOTHING)
    assert giving.right.kind == TIRED
    giving.update(40.0, HERE, (), 0.0, False, None, NOTHING)
    assert giving.right.kind == USUAL
