"""How near things are."""

from __future__ import annotations

import msgspec

from intellwheels_schemas.messages import Body, Lidar, LidarReading, Measures, ProximityReading, Sensors
from intellwheels_viewer.panels.ranges import nearest, tone
from intellwheels_viewer.snapshot import Sample, Snapshot
from tests.viewer.panels import made_up

LIDAR = Lidar(id="laser", x=0, y=0, z=0.3, direction_deg=0, fov_deg=180, rays=3, min_range=0.02, max_range=9)


def snapshot(sensors: Sensors) -> Snapshot:
    robot = msgspec.structs.replace(made_up.robot("chair1"), lidar=(LIDAR,))
    body = Body(run=made_up.RUN, tick=0, robot=robot)
    measures = Measures(run=made_up.RUN, tick=1, time=0.05, sensors=sensors)
    return Snapshot(bodies={"chair1": body}, measures={"chair1": measures})


def test_tones_change_at_their_bounds() -> None:
    assert [tone(value) for value in (0.49, 0.5, 1.49, 1.5)] == ["near", "middle", "middle", "far"]


def test_nearest_is_the_smallest_of_all_sensors() -> None:
    readings = (ProximityReading(id="front", value=1.2), ProximityReading(id="left", status="none"))
    laser = LidarReading(id="laser", start_deg=-90, step_deg=90, ranges=(3.0, None, 0.9), statuses=("ok", "none", "ok"))
    assert nearest(snapshot(Sensors(proximity=readings, lidar=(laser,))), "chair1") == 0.9


def test_too_near_counts_as_the_least_range_of_its_sensor() -> None:
    assert nearest(snapshot(Sensors(proximity=(ProximityReading(id="front", status="near"),))), "chair1") == 0.05
    laser = LidarReading(id="laser", start_deg=0, step_deg=90, ranges=(None,), statuses=("near",))
    assert nearest(snapshot(Sensors(lidar=(laser,))), "chair1") == 0.02


def test_nothing_seen_and_a_failure_are_no_distance() -> None:
    readings = (ProximityReading(id="front", status="fault"), ProximityReading(id="left", status="none"))
    assert nearest(snapshot(Sensors(proximity=readings)), "chair1") is None


def test_without_measures_the_newest_sample_counts() -> None:
    history = (Sample(0, 0, 0, 0, 0, (0.1,)), Sample(1, 0, 0, 0, 0, (0.7, None, 0.4)))
    assert nearest(Snapshot(history={"chair1": history}), "chair1") == 0.4


def test_a_body_of_which_nothing_is_known_has_no_nearest() -> None:
    assert nearest(Snapshot(), "chair1") is None
