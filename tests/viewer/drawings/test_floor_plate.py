from __future__ import annotations

import msgspec
import pytest
import viser

from intellwheels_maps import library
from intellwheels_schemas.messages import Map, Zone
from intellwheels_viewer.drawings import floor_plate
from tests.viewer.drawings.cast import node

ROOM = library.floor("room")
EMPTY = Map(format="iw.v1", name="empty")


def test_the_plate_reaches_half_a_metre_beyond_the_walls_and_lies_under_the_floor() -> None:
    plate = floor_plate.plate(ROOM).vertices
    assert plate.min(axis=0) == pytest.approx([-0.6, -0.6, -0.12])
    assert plate.max(axis=0) == pytest.approx([13.6, 8.6, 0.0])


def test_the_grid_has_a_line_a_metre() -> None:
    lines = len(floor_plate.grid(ROOM).faces) // 2
    assert lines == 14 + 9


def test_each_zone_has_its_own_area_in_one_of_the_tints() -> None:
    tints = floor_plate.tinted(ROOM.zone)
    assert [len(each.faces) for each in tints] == [2, 2, 0, 0]


def test_names_fit_into_their_rooms_and_stand_in_the_middle() -> None:
    room, anteroom = floor_plate.titles(ROOM.zone)
    assert (room.text, room.x, room.y) == ("Room", 4.475, 4.0)
    assert room.room < 8.95
    assert 0.16 <= anteroom.height <= 0.46


def test_the_name_of_a_narrow_room_runs_along_it_and_a_closet_has_none() -> None:
    def zone(width: float, depth: float) -> Zone:
        corners = ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))
        return msgspec.convert({"Name": "z", "Corner": [{"X": x, "Y": y} for x, y in corners]}, Zone, str_keys=True)

    assert floor_plate.titles((zone(1.2, 8.0),))[0].upright
    assert not floor_plate.titles((zone(8.0, 1.2),))[0].upright
    assert floor_plate.titles((zone(0.3, 0.3),)) == []


def test_a_doorway_is_marked_as_wide_as_it_is() -> None:
    strip = floor_plate.thresholds(ROOM.doorway).vertices
    assert float(strip[:, 1].max() - strip[:, 1].min()) == pytest.approx(1.1)
    assert float(strip[:, 0].mean()) == pytest.approx(9.0)


def test_an_empty_map_has_a_plate_all_the_same() -> None:
    assert floor_plate.extent(EMPTY) == (-5.0, 5.0, -5.0, 5.0)


def test_another_map_hides_what_it_does_not_have(scene: viser.SceneApi) -> None:
    shown = floor_plate.Floor(scene)
    shown.show(ROOM)
    assert node(scene, "/floor/names/1").visible
    doorways = node(scene, "/floor/doorways")
    shown.show(EMPTY)
    assert not node(scene, "/floor/names/0").visible
    assert not doorways.visible
    shown.show(ROOM)
    assert node(scene, "/floor/names/0").visible
    assert node(scene, "/floor/doorways").visible
