from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from intellwheels_maps import library
from intellwheels_maps.check import wall_pieces
from intellwheels_maps.plane_geometry import contains
from intellwheels_schemas.messages import Obstacle
from intellwheels_viewer.drawings.building_colours import DAY
from intellwheels_viewer.drawings.rooms import rooms_of
from intellwheels_viewer.drawings.windows import HEAD, SILL, beside, places, windows

ROOM, WARD = library.floor("room"), library.floor("ward")


@pytest.mark.parametrize("name", ["room", "ward"])
def test_a_window_has_a_room_before_it_and_nothing_behind(name: str) -> None:
    floor = library.floor(name)
    rooms = rooms_of(floor)
    pieces = [piece for wall in floor.wall for piece in wall_pieces(wall)]
    found = list(places(floor))
    assert len(found) >= 9
    for x, y, heading, thick in found:
        dx, dy = math.cos(heading), math.sin(heading)
        assert rooms.at(x + 0.3 * dx, y + 0.3 * dy) is not None
        far = (x - (thick + 0.3) * dx, y - (thick + 0.3) * dy)
        assert rooms.at(*far) is None
        assert not any(contains(piece, far) for piece in pieces)
        assert any(contains(piece, (x - 0.02 * dx, y - 0.02 * dy)) for piece in pieces)


def test_a_cupboard_hides_a_window() -> None:
    low = {(round(x), round(y)) for x, y, *_ in places(ROOM)}
    cupboard = library.floor("room").obstacle[0]
    corners = [msgspec.structs.replace(c, x=c.x - 10.2, y=c.y - 0.0) for c in cupboard.corner]
    more = msgspec.structs.replace(ROOM, obstacle=(*ROOM.obstacle, Obstacle(name="b", top=1.9, corner=tuple(corners))))
    assert {(round(x), round(y)) for x, y, *_ in places(more)} <= low


def test_a_street_a_map_without_rooms_and_a_huge_one_have_none() -> None:
    assert list(places(library.floor("crossing"))) == []
    assert list(places(msgspec.structs.replace(ROOM, zone=()))) == []
    assert list(places(msgspec.structs.replace(ROOM, wall=ROOM.wall * 100))) == []


def test_a_cut_window_is_a_strip_in_the_cap() -> None:
    glass = windows(places(ROOM), None, DAY)[DAY.glass].vertices
    assert (float(glass[:, 2].min()), float(glass[:, 2].max())) == pytest.approx((SILL, HEAD), abs=0.07)
    assert float(windows(places(ROOM), 1.1, DAY)[DAY.glass].vertices[:, 2].max()) == pytest.approx(1.104, abs=0.002)


def test_a_window_goes_with_the_part_of_the_wall_that_is_cut_away() -> None:
    found = list(places(ROOM))
    x, y, heading, thick = found[0]
    at = np.array([x - thick / 2 * np.cos(heading), y - thick / 2 * np.sin(heading)])
    along = np.array([-np.sin(heading), np.cos(heading)])
    gone = np.array([[*(at - 0.5 * along), *(at + 0.5 * along), 0.0, 2.5]])
    assert beside(found, gone) == found[1:]
    assert beside(found, gone[:0]) == found
