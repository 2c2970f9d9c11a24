"""Every kind of reading as numbers."""

from __future__ import annotations

import math

import pytest

from intellwheels_schemas.messages import (
    BeaconReading,
    GPSReading,
    Heading,
    LidarReading,
    Measures,
    ProximityReading,
    Range,
    Record,
    Sensors,
    Status,
    TruthReading,
)
from intellwheels_viewer.panels.readings import _READERS, Group, Row, groups
from tests.viewer.panels import made_up


def read(sensors: Sensors) -> list[Group]:
    return groups(Measures(run=made_up.RUN, tick=10, time=0.5, sensors=sensors))


class SonarReading(Record, frozen=True, kw_only=True):
    """A kind of sensor that the viewer does not know."""

    id: str
    tick: int | None = None
    distance: Range | None = None
    bearing: Heading = 0.0
    echoes: tuple[int, ...] = ()
    confirmed: bool = False
    status: Status = "ok"


class SensorsWithSonar(Sensors, frozen=True, kw_only=True):
    """The sensors of a contract with one more kind."""

    ultra_sonar: tuple[SonarReading, ...] = ()


def test_every_kind_of_the_contract_has_a_row_of_its_own_making() -> None:
    assert set(_READERS) <= set(Sensors.__struct_fields__)


def test_an_unknown_kind_of_sensor_is_shown_by_its_fields_and_units() -> None:
    front = SonarReading(id="front", tick=8, distance=1.234, bearing=math.pi / 2, echoes=(4, 7), confirmed=True)
    found = read(SensorsWithSonar(ultra_sonar=(front, SonarReading(id="rear", status="fault"))))
    assert found == [
        Group(
            "ultra_sonar",
            "ultra sonar: distance, m; bearing, \u00b0; echoes; confirmed",
            (Row("front", "1.23, 90, [4 7], yes", "", 2), Row("rear", "failed")),
        )
    ]


def test_an_unknown_kind_shows_absent_values_and_shortens_long_lists() -> None:
    (group,) = read(SensorsWithSonar(ultra_sonar=(SonarReading(id="a", status="none", echoes=tuple(range(99))),)))
    assert group.rows[0].text == "nothing seen"
    (group,) = read(SensorsWithSonar(ultra_sonar=(SonarReading(id="a", echoes=tuple(range(99))),)))
    assert group.rows[0].text == "\u2013, 0, 99 values, no"


def test_all_readings_of_a_chair_are_rows() -> None:
    found = groups(made_up.measures())
    assert [len(group.rows) for group in found] == [6, 1, 1, 1, 1, 1, 1, 1, 1]
    assert all(row.text for group in found for row in group.rows)


@pytest.mark.parametrize(("status", "text"), [("none", "nothing seen"), ("near", "too near"), ("fault", "failed")])
def test_a_reading_without_a_distance_says_why(status: str, text: str) -> None:
    (group,) = read(Sensors(proximity=(ProximityReading(id="front", status=status),)))  # type: ignore[arg-type]
    assert group.rows[0].text == text


def test_a_lidar_says_the_nearest_and_where() -> None:
    laser = LidarReading(id="l", start_deg=270, step_deg=45, ranges=(2.0, None, 0.4), statuses=("ok", "none", "ok"))
    (group,) = read(Sensors(lidar=(laser,)))
    assert group.rows == (Row("l", "0.40 at 0\u00b0, 2 of 3 rays", "near"),)


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
