"""Every kind of reading as numbers."""

from __future__ import annotations

import pytest

from intellwheels_schemas.messages import (
    BeaconReading,
    GPSReading,
    IMUReading,
    LidarReading,
    Measures,
    ProximityReading,
    Sensors,
    TruthReading,
)
from intellwheels_viewer.panels.readings import _PANELS, Group, Row, groups
from tests.viewer.panels import made_up


def read(sensors: Sensors) -> list[Group]:
    return groups(Measures(run=made_up.RUN, tick=10, time=0.5, sensors=sensors))


def test_words_are_of_kinds_of_the_contract() -> None:
    assert set(_PANELS) <= set(Sensors.__struct_fields__)


def test_a_kind_without_words_of_its_own_shows_its_values(monkeypatch: pytest.MonkeyPatch) -> None:
    for field in ("imu", "gps"):
        monkeypatch.delitem(_PANELS, field)
    imu = IMUReading(id="i", forward=0.5, left=-0.25, turn_rate=1.0)
    fixes = (GPSReading(id="g", x=1.5, y=2.0), GPSReading(id="lost", status="fault"))
    assert read(Sensors(imu=(imu,), gps=fixes)) == [
        Group("gps: x, m; y, m", (Row("g", "1.50, 2.00"), Row("lost", "failed"))),
        Group("imu: forward, m/s2; left, m/s2; turn rate, rad/s", (Row("i", "0.50, \u22120.25, 1.00"),)),
    ]


def test_all_readings_of_a_chair_are_rows() -> None:
    found = groups(made_up.measures())
    assert [len(group.rows) for group in found] == [6, 1, 1, 1, 1, 1, 1, 1, 1]
    assert all(row.text for group in found for row in group.rows)


@pytest.mark.parametrize(("status", "text"), [("none", "nothing seen"), ("near", "too near"), ("fault", "failed")])
def test_a_reading_without_a_distance_says_why(status: str, text: str) -> None:
    (group,) = read(Sensors(proximity=(ProximityReading(id="front", status=status),)))  # type: ignore[arg-type]
    assert group.rows[0].text == text


def test_a_lidar_says_the_nearest_and_where() -> None:
    laser = LidarReading(id="l", start_deg=270, step_deg=45, ranges=(2.0, None, 0.5), statuses=("ok", "none", "ok"))
    (group,) = read(Sensors(lidar=(laser,)))
    assert group.rows == (Row("l", "0.50 at 0\u00b0, 2 of 3 rays", "near"),)


def test_an_old_reading_says_its_age() -> None:
    (group,) = read(Sensors(gps=(GPSReading(id="gps", tick=7, x=1.0, y=-2.0),)))
    assert group.rows == (Row("gps", "1.00, \u22122.00", "", 3),)


def test_angles_are_in_degrees() -> None:
    found = read(
        Sensors(
            beacon=(BeaconReading(id="b", value=0.5236),),
            truth=(TruthReading(id="t", x=1, y=2, heading=-1.5708, speed=0, turn_rate=0),),
        )
    )
    assert [group.rows[0].text for group in found] == ["30", "1.00, 2.00, \u221290"]


def test_no_sensors_give_no_groups() -> None:
    assert groups(Measures(run=made_up.RUN, tick=1, time=0.05)) == []
