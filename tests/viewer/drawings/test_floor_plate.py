from __future__ import annotations

import msgspec
import pytest
import viser

from intellwheels_maps import library
from intellwheels_schemas.messages import Map, Zone
from intellwheels_viewer.drawings import floor_plate
from intellwheels_viewer.drawings.building_colours import DAY
from intellwheels_viewer.drawings.rooms import extent
from tests.viewer.drawings.cast import node

ROOM = library.floor("room")
EMPTY = Map(format="iw.v1", name="empty")


def test_the_plate_reaches_half_a_metre_beyond_the_walls_and_lies_under_the_floor() -> None:
    plate = floor_plate.plate(ROOM).vertices
    assert plate.min(axis=0) == pytest.approx([-0.6, -0.6, -0.13])
    assert plate.max(axis=0) == pytest.approx([13.6, 8.6, -0.01])


def test_each_room_is_of_its_material_and_a_doorway_is_floor_too() -> None:
    made = floor_plate.materials(ROOM)
    assert {material: len(flat.faces) for material, flat in made.items()} == {"tiles": 2 + 2, "wood": 2}
    assert floor_plate.materials(EMPTY).keys() == {"tiles"}
    assert list(floor_plate.materials(library.floor("crossing"))) == ["paving", "asphalt"]


def test_a_picture_of_a_floor_has_its_size_in_metres() -> None:
    (wood,) = [each for each in floor_plate.surfaces(ROOM, DAY) if each.rgb == DAY.floors["wood"]]
    assert wood.uv is not None
    assert wood.uv * 1.6 == pytest.approx(wood.solid.vertices[:, :2], abs=1e-5)


def test_shade_is_dark_at_a_wall_and_fades_away_from_it() -> None:
    made = floor_plate.shade(ROOM, 80)
    assert made.colours is not None
    assert made.blend
    at_wall = made.colours[:, 3] == 80
    assert at_wall.sum() == (~at_wall).sum() == len(made.colours) / 2
    assert set(made.colours[~at_wall, 3].tolist()) == {0}


def test_names_lie_in_their_rooms() -> None:
    made = floor_plate.names(floor_plate.titles(ROOM.zone), DAY.letters)
    assert len(made.solid.faces) == 4
    first, second = made.solid.vertices[:4], made.solid.vertices[4:]
    assert first[:, :2].mean(axis=0) == pytest.approx([4.475, 4.0], abs=1e-4)
    assert float(second[:, 0].min()) > 9.05
    assert len(floor_plate.names([], DAY.letters).solid.faces) == 0


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
    strip = floor_plate.thresholds(ROOM).vertices
    assert float(strip[:, 1].max() - strip[:, 1].min()) == pytest.approx(1.1)
    assert float(strip[:, 0].mean()) == pytest.approx(9.0, abs=0.01)


def test_an_empty_map_has_a_plate_all_the_same() -> None:
    assert extent(EMPTY) == (-5.0, 5.0, -5.0, 5.0)


def test_another_map_hides_what_it_does_not_have(scene: viser.SceneApi) -> None:
    shown = floor_plate.Floor(scene)
    shown.show(ROOM)
    names, marks = node(scene, "/floor/names"), node(scene, "/floor/marks")
    assert names.visible
    shown.show(EMPTY)
    assert not names.visible
    assert not marks.visible
    shown.show(ROOM)
    assert node(scene, "/floor/names").visible
    assert node(scene, "/floor/marks").visible
