from __future__ import annotations

import pytest
import viser

from intellwheels_maps import library
from intellwheels_schemas.messages import Corner, Map, Wall
from intellwheels_viewer.drawings.extruded_walls import Walls, extruded, obstacles
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from tests.viewer.drawings.cast import node

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


def test_another_map_hides_the_colours_it_does_not_have(scene: viser.SceneApi) -> None:
    walls = Walls(scene)
    walls.show(WARD)
    names = [name for name in scene._handle_from_node_name if name.startswith("/obstacles/")]
    assert len(names) > 4
    walls.show(floor(line(height=2.5)))
    assert not any(node(scene, name).visible for name in names)
    assert node(scene, "/walls/sides").visible


def test_whole_walls_take_the_place_of_cut_ones_under_the_same_name(scene: viser.SceneApi) -> None:
    walls = Walls(scene)
    walls.show(ROOM)
    assert float(node(scene, "/walls/caps").vertices[:, 2].max()) == pytest.approx(HALF_HEIGHT)
    walls.show(ROOM, None)
    assert float(node(scene, "/walls/caps").vertices[:, 2].max()) == pytest.approx(2.5)
