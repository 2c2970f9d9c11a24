"""Beacons: the bearing of a place where it can be seen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from intellwheels_schemas.file_records import Restart
from intellwheels_schemas.messages import Beacon, Place
from intellwheels_server.world import State, measures
from tests.server.worlds import ROUNDED, RUN, box_wall, cart, do, floor_of, run, world

_PLACES = (Place(name="door", x=5.0, y=3.0), Place(name="bed", x=-5.0, y=0.0))
_FLOOR = floor_of([box_wall(-3.0, -1.0, -2.0, 1.0)], _PLACES)


def _beacon(beacon_id: str = "b", **fields: Any) -> Beacon:
    return Beacon(**{"id": beacon_id, "place": "door", "z": 0.5, **fields})


def _bearings(state: State, agent: str = "a") -> list[float | None]:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    assert all((reading.value is None) == (reading.status == "none") for reading in sensors.beacon)
    return [reading.value for reading in sensors.beacon]


def test_bearing_is_in_the_body_frame_from_the_point_of_the_sensor() -> None:
    state = world({"a": cart(1.0, 0.0, heading=0.5, beacon=(_beacon(),))}, floor=_FLOOR)
    assert _bearings(state) == [pytest.approx(math.atan2(3.0, 4.0) - 0.5, abs=ROUNDED)]
    ahead = (_beacon(x=1.0, y=3.0), _beacon("c", x=4.0, y=-1.0))
    assert _bearings(world({"a": cart(1.0, beacon=ahead)}, floor=_FLOOR)) == pytest.approx([0.0, math.pi / 2])


def test_place_out_of_cone_or_range_or_behind_a_wall_is_not_seen() -> None:
    beacons = (
        _beacon("seen", cone_deg=90.0, max_range=5.1),
        _beacon("far", max_range=4.9),
        _beacon("beside", cone_deg=70.0),
        _beacon("turned", cone_deg=70.0, direction_deg=30.0),
        _beacon("behind", place="bed"),
        _beacon("over", place="bed", z=2.0 + 0.5),
    )
    seen = _bearings(world({"a": cart(1.0, 0.0, beacon=beacons)}, floor=_FLOOR))
    assert [value is not None for value in seen] == [True, False, False, True, False, True]
    assert seen[-1] == pytest.approx(math.pi)


def test_another_body_hides_a_place_and_the_own_does_not() -> None:
    robots = {"a": cart(1.0, beacon=(_beacon(),)), "b": cart(3.0, 1.5)}
    assert _bearings(world(robots, floor=_FLOOR)) == [None]
    robots["b"] = cart(3.0, -1.5)
    assert _bearings(world(robots, floor=_FLOOR)) != [None]


def test_noise_steps_and_a_walking_bias() -> None:
    state = world({"a": cart(1.0, beacon=tuple(_beacon(f"b{k}", noise_deg=2.0) for k in range(60)))}, floor=_FLOOR)
    found: list[float] = []
    for _ in range(20):
        found += [value for value in _bearings(state) if value is not None]
        state, _ = run(state, 1)
    assert math.degrees(float(np.std(found))) == pytest.approx(2.0, rel=0.085)  # four standard errors of 1200 draws
    stepped = _bearings(world({"a": cart(1.0, beacon=(_beacon(step_deg=10.0),))}, floor=_FLOOR))[0]
    assert stepped == pytest.approx(math.radians(40.0))
    state, _ = run(world({"a": cart(1.0, beacon=(_beacon(walk_deg=5.0),))}, floor=_FLOOR), 20)
    walked = _bearings(state)[0]
    assert walked is not None
    assert 0.0 < abs(walked - math.atan2(3.0, 4.0)) < math.radians(20.0)


def test_place_that_another_floor_has_not_is_not_seen_and_no_join_is_possible_there() -> None:
    state = world({"a": cart(1.0, beacon=(_beacon(),))}, floor=_FLOOR)
    state, outcome, _ = do(state, Restart(run=RUN, seed="1", map=floor_of()))
    assert (outcome.code, outcome.refused) == ("failed", "no-place")
    assert _bearings(state) != [None]
