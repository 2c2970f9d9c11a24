from __future__ import annotations

import msgspec
import pytest

from intellwheels_maps import library
from intellwheels_schemas.messages import Map, Zone
from intellwheels_viewer.drawings.polygons import area
from intellwheels_viewer.drawings.rooms import (
    depth_of,
    extent,
    grounds,
    is_crossing,
    is_outdoors,
    is_street,
    material_of,
    passage,
    rooms_of,
)

ROOM, WARD, STREET = (library.floor(name) for name in ("room", "ward", "crossing"))
EMPTY = Map(format="iw.v1", name="empty")


def test_a_floor_is_of_what_its_name_says() -> None:
    made = {zone.name: material_of(zone) for zone in (*WARD.zone, *ROOM.zone, *STREET.zone)}
    assert made["bathroom"] == "small-tiles"
    assert made["corridor"] == made["anteroom"] == made["store"] == "tiles"
    assert made["room1"] == made["room"] == "wood"
    assert made["day-room"] == made["nurses-station"] == "carpet"
    assert made["street"] == made["crossing"] == "asphalt"
    assert material_of(Zone(name="zone7")) == "tiles"
    assert material_of(Zone(name="z", title="Kitchen")) == "small-tiles"


def test_a_street_is_outdoors_and_a_crossing_is_no_street() -> None:
    street, crossing = STREET.zone
    assert (is_street(street), is_crossing(street)) == (True, False)
    assert (is_street(crossing), is_crossing(crossing)) == (False, True)
    assert is_outdoors(STREET)
    assert not is_outdoors(WARD)


def test_the_building_is_where_the_zones_are_or_all_of_the_map() -> None:
    assert len(grounds(WARD)) == len(WARD.doorway)
    assert grounds(STREET) == [[(-30.1, -6.1), (30.1, -6.1), (30.1, 6.1), (-30.1, 6.1)]]
    few = msgspec.structs.replace(WARD, zone=WARD.zone[:1])
    assert len(grounds(few)) == 1
    assert grounds(EMPTY) == [[(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)]]


def test_a_doorway_is_as_deep_as_the_walls_beside_it() -> None:
    (doorway,) = ROOM.doorway
    assert depth_of(ROOM, doorway) == pytest.approx((-0.05, 0.05), abs=0.011)
    assert area(passage(ROOM, doorway)) == pytest.approx(1.1 * 0.1, abs=0.02)
    assert depth_of(EMPTY, doorway) == (-0.05, 0.05)


def test_a_point_is_in_the_first_zone_that_has_it() -> None:
    rooms = rooms_of(STREET)
    street = rooms.at(0.0, 0.0)
    assert street is not None
    assert street.name == "street"
    assert rooms.at(0.0, 5.0) is None


def test_an_empty_map_has_ten_metres_around_the_origin() -> None:
    assert extent(EMPTY) == (-5.0, 5.0, -5.0, 5.0)
