"""A learner sees ranges, the way to its goal and its speeds, in both forms the same."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from intellwheels_gym.observation import FARTHEST, Observer, observation_space
from intellwheels_maps import robot
from intellwheels_schemas.messages import (
    EncodersReading,
    Lidar,
    LidarReading,
    Measures,
    Position,
    ProximityReading,
    Sensors,
)

CHAIR = robot("rear-wheel")
START = Position(x=1.0, y=0.0, heading=0.0)


def seen(tick: int, **sensors: Any) -> Measures:
    return Measures(run="0" * 16, tick=tick, time=tick * 0.05, sensors=Sensors(**sensors))


def test_dictionary_and_flat_hold_the_same_numbers_inside_their_spaces() -> None:
    found = {}
    for kind in ("flat", "dict"):
        observer = Observer(CHAIR, START, (4.0, 4.0), 0.05, kind)
        observer.update(seen(0, proximity=(ProximityReading(id="left", value=0.7),)))
        found[kind] = observer.observation()
        assert observation_space(CHAIR, kind).contains(found[kind])
    assert np.concatenate(list(found["dict"].values())).tolist() == found["flat"].tolist()
    assert found["dict"]["ranges"].tolist() == pytest.approx([4.0, 4.0, 0.7, 4.0, 4.0, 4.0, 4.0, 4.0])
    assert found["dict"]["goal"].tolist() == pytest.approx([5.0, np.arctan2(4.0, 3.0)])


def test_speeds_and_the_way_to_the_goal_follow_from_the_encoders() -> None:
    observer = Observer(CHAIR, START, (4.0, 0.0), 0.05, "dict")
    per_metre = CHAIR.encoder_ticks / (np.pi * CHAIR.wheel_diameter)
    observer.update(seen(0, encoders=(EncodersReading(id="wheels", left=100, right=100),)))
    counts = 100 + round(0.05 * per_metre)
    observer.update(seen(1, encoders=(EncodersReading(id="wheels", left=counts, right=counts),)))
    found = observer.observation()
    assert found["speeds"].tolist() == pytest.approx([1.0, 0.0], abs=0.02)
    assert found["goal"][0] == pytest.approx(2.95, abs=0.001)
    observer.update(seen(2, encoders=(EncodersReading(id="wheels", left=counts - 50, right=counts + 50),)))
    assert observer.observation()["speeds"][1] == pytest.approx(100 / per_metre / 0.54 / 0.05, rel=1e-6)


def test_sensor_that_fails_or_rests_keeps_its_last_range() -> None:
    observer = Observer(CHAIR, START, (4.0, 0.0), 0.05, "dict")
    observer.update(seen(0, proximity=(ProximityReading(id="front", value=1.5),)))
    observer.update(seen(1, proximity=(ProximityReading(id="front", status="fault"),)))
    observer.update(seen(2, proximity=(ProximityReading(id="stranger", value=0.1),)))
    assert observer.observation()["ranges"][0] == 1.5
    observer.update(seen(3, proximity=(ProximityReading(id="front", status="near"),)))
    assert observer.observation()["ranges"][0] == pytest.approx(0.05)
    observer.update(seen(4, proximity=(ProximityReading(id="front", status="none"),)))
    assert observer.observation()["ranges"][0] == 4.0


def test_rays_of_a_lidar_follow_the_proximity_sensors() -> None:
    lidar = Lidar(id="scan", x=0.0, y=0.0, z=0.4, direction_deg=0.0, fov_deg=90.0, rays=3, min_range=0.1, max_range=9.0)
    body = msgspec.structs.replace(CHAIR, lidar=(lidar,))
    observer = Observer(body, START, (4.0, 0.0), 0.05, "dict")
    scan = LidarReading(
        id="scan", start_deg=-45.0, step_deg=45.0, ranges=(2.5, None, None), statuses=("ok", "near", "none")
    )
    observer.update(seen(0, lidar=(scan,)))
    assert observer.observation()["ranges"][8:].tolist() == pytest.approx([2.5, 0.1, 9.0])


def test_goal_beyond_the_horizon_stays_inside_the_space() -> None:
    observer = Observer(CHAIR, START, (-9000.0, 0.0), 0.05)
    found = observer.observation()
    assert found[8] == FARTHEST
    assert observation_space(CHAIR, "flat").contains(found)


def test_kind_and_robot_are_checked() -> None:
    with pytest.raises(ValueError, match="observation: expected flat or dict, got 'image'"):
        observation_space(CHAIR, "image")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="robot: expected encoders or odometry"):
        observation_space(msgspec.structs.replace(CHAIR, encoders=()), "flat")
