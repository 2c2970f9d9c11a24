from __future__ import annotations

import pytest
import viser

from intellwheels_maps import library
from intellwheels_schemas.messages import Corner, Map, Wall
from intellwheels_viewer.drawings.building_colours import DAY
from intellwheels_viewer.drawings.extruded_walls import Walls, bands, extruded, obstacles, shaded
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from tests.viewer.drawings.cast import node, triangles

ROOM = library.floor("room")
WARD = library.floor("ward")


def floor(*walls: Wall) -> Map:
    return Map(format="iw.v1", name="f", wall=walls)


def line(**fields: float) -> Wall:
    return Wall(thickness=0.1, corner=(Corner(x=0.0, y=0.0), Corner(x=4.0, y=0.0)), **fields)


def test_a_line_is_as_thick_and_as_high_as_it_says() -> None:
    sides, caps = extruded(floor(line(height=2.5)), None)
    assert sides.vertices.min(axis=0) == pytest.approx([0.0, -0.05, 0.0])
    assert caps.vertices.max(axis=0) == pytest.approx([4.0, 0.05, 2.5])


def test_walls_are_cut_and_what_hangs_above_the_cut_is_not_drawn() -> None:
    _, caps = extruded(floor(line(height=2.5)), 1.1)
    assert float(caps.vertices[:, 2].max()) == pytest.approx(1.1)
    sides, caps = extruded(floor(line(height=2.5, bottom=2.0)), 1.1)
    assert len(sides.faces) == len(caps.faces) == 0


def test_a_low_wall_is_not_raised() -> None:
    _, caps = extruded(floor(line(height=0.5)), 1.1)
    assert float(caps.vertices[:, 2].max()) == pytest.approx(0.5)


def test_every_obstacle_of_the_ward_is_drawn_at_its_own_height() -> None:
    whole = obstacles(WARD, None)
    assert max(float(each.vertices[:, 2].max()) for each in whole.values()) == pytest.approx(2.0)
    cut = obstacles(WARD, 1.1)
    assert max(float(each.vertices[:, 2].max()) for each in cut.values()) == pytest.approx(1.35)


def test_a_wall_has_a_skirting_board_a_dado_and_a_rail_and_is_darker_at_the_floor() -> None:
    made = bands(0.0, 2.475, DAY, plain=False)
    assert (made[0][0], made[-1][1]) == (0.0, 2.475)
    assert [upper for _, upper, *_ in made[:-1]] == [lower for lower, *_ in made[1:]]
    assert {DAY.skirting, DAY.dado, DAY.rail, DAY.wall} <= {rgb for band in made for rgb in band[2:]}
    assert all(sum(low) <= sum(high) for _, upper, low, high in made if upper < 0.5)
    assert bands(0.0, 0.3, DAY, plain=False)[-1][1] == 0.3
    assert len(bands(2.1, 2.5, DAY, plain=False)) == len(bands(0.0, 2.5, DAY, plain=True)) == 1


@pytest.mark.parametrize("height", [None, HALF_HEIGHT])
def test_the_surface_of_the_walls_is_where_the_walls_are(height: float | None) -> None:
    surface = shaded(WARD, height, DAY)
    sides, caps = extruded(WARD, height)
    whole = sides + caps
    assert surface.solid.vertices.min(axis=0) == pytest.approx(whole.vertices.min(axis=0))
    assert surface.solid.vertices.max(axis=0) == pytest.approx(whole.vertices.max(axis=0))
    assert surface.colours is not None
    assert len(surface.colours) == len(surface.solid.vertices)


def test_another_map_hides_what_it_does_not_have(scene: viser.SceneApi) -> None:
    walls = Walls(scene)
    walls.show(WARD)
    assert triangles(node(scene, "/obstacles")) > 1000
    walls.show(floor(line(height=2.5)))
    assert not node(scene, "/obstacles").visible
    assert node(scene, "/walls/sides").visible


def test_whole_walls_take_the_place_of_cut_ones_under_the_same_name_and_have_signs(scene: viser.SceneApi) -> None:
    walls = Walls(scene)
    walls.show(ROOM)
    cut = node(scene, "/walls/sides").glb_data
    assert node(scene, "/walls/signs") is None
    walls.show(ROOM, None)
    assert node(scene, "/walls/sides").glb_data != cut
    assert node(scene, "/walls/signs").visible
    walls.show(ROOM)
    assert node(scene, "/walls/sides").glb_data == cut
    assert not node(scene, "/walls/signs").visible


def test_by_night_they_have_other_colours(scene: viser.SceneApi) -> None:
    Walls(scene).show(ROOM)
    by_day = node(scene, "/walls/sides").glb_data
    Walls(scene, dark=True).show(ROOM)
    assert node(scene, "/walls/sides").glb_data != by_day


def test_a_huge_map_has_plain_walls_few_triangles_and_no_windows() -> None:
    teeth = tuple(Corner(x=0.01 * index, y=3.0 + 0.2 * (index % 2)) for index in range(5000))
    huge = floor(Wall(corner=(*teeth, Corner(x=50.0, y=0.0), Corner(x=0.0, y=0.0))))
    assert len(shaded(huge, None, DAY).solid.faces) < 8 * 5000
