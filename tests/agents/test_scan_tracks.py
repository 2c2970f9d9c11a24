"""What a pedestrian sees."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.scan_tracks import LIDAR, RAYS, ScanTracks, with_view
from intellwheels_maps import robot
from intellwheels_schemas.messages import LidarReading, Position, Sensors, Status

BODY = with_view(robot("person"))
FORWARD = RAYS // 2
Ranges = dict[int, float]


def seen(ranges: Ranges) -> Sensors:
    """Return a scan with these ranges, by ray from straight ahead to the left."""
    row = tuple(ranges.get(k - FORWARD) for k in range(RAYS))
    statuses: tuple[Status, ...] = tuple("none" if one is None else "ok" for one in row)
    return Sensors(lidar=(LidarReading(id=LIDAR, start_deg=-180.0, step_deg=2.0, ranges=row, statuses=statuses),))


@pytest.fixture
def pose() -> Odometry:
    return Odometry(BODY, Position(x=1.0, y=2.0, heading=math.pi / 2.0))


def test_robot_has_one_lidar_all_round_however_often_it_is_added() -> None:
    assert with_view(BODY) == BODY
    assert BODY.proximity == ()
    assert [one.fov_deg for one in BODY.lidar] == [360.0]


def test_points_are_along_the_axes_of_the_map(pose: Odometry) -> None:
    view = ScanTracks(0.05)
    view.update(seen({0: 2.0}), pose)
    (point,) = view.points
    assert point == pytest.approx((0.0, 2.0, 0.0, 0.0))


@pytest.mark.parametrize("period", [0.02, 0.05, 0.1])
def test_approaching_object_has_its_velocity(pose: Odometry, period: float) -> None:
    view = ScanTracks(period)
    for i in range(round(2.0 / period)):
        view.update(seen(dict.fromkeys(range(-3, 4), 4.0 - period * i)), pose)
    assert view.points
    for _, _, velocity_x, velocity_y in view.points:
        assert (velocity_x, velocity_y) == pytest.approx((0.0, -1.0), abs=0.03)
    assert view.count(pose, 2.5) == 1
    assert view.count(pose, 1.0) == 0


def test_object_across_the_first_ray_is_one(pose: Odometry) -> None:
    view = ScanTracks(0.05)
    view.update(seen(dict.fromkeys((-90, -89, 88, 89), 1.0)), pose)
    assert view.count(pose, 2.0) == 1


def test_wall_has_no_velocity(pose: Odometry) -> None:
    view = ScanTracks(0.05)
    for i in range(20):
        view.update(seen({k: (2.0 - 0.05 * i) / math.cos(math.radians(2.0 * k)) for k in range(-30, 31)}), pose)
    assert {point[2:] for point in view.points} == {(0.0, 0.0)}
    assert view.count(pose, 9.0) == 0


def test_only_a_moving_object_longer_than_a_person_may_be_a_chair(pose: Odometry) -> None:
    for rays, chair in ((range(-14, 15), True), (range(-4, 5), False)):
        view = ScanTracks(0.05)
        for i in range(20):
            view.update(seen(dict.fromkeys(rays, 2.0 - 0.03 * i)), pose)
        assert bool(view.large) is chair


def test_missing_scan_changes_nothing(pose: Odometry) -> None:
    view = ScanTracks(0.05)
    view.update(seen({0: 2.0}), pose)
    view.update(None, pose)
    view.update(Sensors(), pose)
    assert len(view.points) == 1
