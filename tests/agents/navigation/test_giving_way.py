"""A chair drives off the way of another, and off a door's swing; one that is stuck backs out."""

from __future__ import annotations

import math

import numpy as np

from intellwheels_agents.navigation.giving_way import ANEW, DOOR_ROOM, OUT_ROOM, STALLED, STUCK, THERE, GivingWay
from intellwheels_agents.navigation.right_of_way import ROOM, way_in, way_message
from intellwheels_schemas.messages import Heard
from tests.agents.navigation.rooms import room, weights

GIVEN = weights(room(size=8.0))
NOTHING = np.zeros((0, 2))
HERE = (4.0, 4.0, 0.0)
WAY = way_message([(0.5 + 0.1 * i, 4.0) for i in range(36)], 100)


def heard(text: str) -> tuple[Heard, ...]:
    return (Heard(sender="chair1", tick=1, distance=1.0, text=text),)


def end_of(giving: GivingWay) -> tuple[float, float]:
    assert giving.aside is not None
    giving.aside.expand(10**7)
    return giving.aside.way(*HERE, 20.0)[-1]


def test_stalled_chair_with_less_right_drives_off_the_way() -> None:
    giving = GivingWay("chair2", GIVEN, 0.0)
    giving.update(1.0, HERE, heard(WAY), STALLED + 1.0, False, None, NOTHING)
    x, y = end_of(giving)
    assert min(math.dist((x, y), point) for point in way_in(WAY)) > ROOM
    assert giving.cost(HERE) > THERE
    giving.update(9.0, HERE, (), 0.0, False, None, NOTHING)
    assert giving.aside is None


def test_chair_that_drives_or_has_more_right_does_not() -> None:
    for name, stalled in (("chair2", 0.0), ("chair0", STALLED + 1.0)):
        giving = GivingWay(name, GIVEN, 0.0)
        giving.update(1.0, HERE, heard(WAY), stalled, False, None, NOTHING)
        assert giving.aside is None


def test_chair_leaves_room_for_the_swing_of_a_door() -> None:
    giving = GivingWay("chair2", GIVEN, 0.0)
    giving.update(1.0, HERE, (), STALLED + 1.0, False, (4.8, 4.0), NOTHING)
    assert math.dist(end_of(giving), (4.8, 4.0)) > DOOR_ROOM - 0.05


def test_stuck_chair_backs_out() -> None:
    giving = GivingWay("chair2", GIVEN, 0.0)
    blocked = np.array([[4.8, 4.0], [4.8, 4.3]])
    giving.update(0.0, HERE, (), 0.0, False, None, blocked)
    giving.update(STUCK + 0.1, HERE, (), STUCK, False, None, blocked)
    x, y = end_of(giving)
    assert min(math.dist((x, y), point) for point in blocked.tolist()) > OUT_ROOM - 0.2


def test_chair_that_does_not_get_out_of_the_way_goes_on() -> None:
    giving = GivingWay("chair2", GIVEN, 0.0)
    given_way = []
    for tick in range(100):
        giving.update(0.05 * tick, HERE, heard(WAY), STALLED + 1.0, False, None, NOTHING)
        if giving.aside is not None:
            giving.aside.expand(10**6)
        given_way.append(giving.aside is not None)
    assert given_way[:50] == [True] * 50
    assert not any(given_way[70:])


def test_chair_that_is_stuck_at_the_map_comes_anew() -> None:
    giving = GivingWay("chair2", GIVEN, 0.0)
    giving.update(0.0, HERE, (), 0.0, False, None, NOTHING)
    giving.update(STUCK + 0.1, HERE, (), STUCK, False, None, NOTHING)
    assert math.dist(end_of(giving), HERE[:2]) > ANEW
