"""What the 3D panel draws."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.map_cells import map_cells
from intellwheels_agents.record_gateway import scene_messages as scene
from intellwheels_maps import floor, names, robot
from intellwheels_schemas.messages import Proximity, ProximityReading, Robot
from intellwheels_schemas.rules import parts_of
from tests.agents.record_gateway.decoded import decoded
from tests.every_case import every_case


@every_case("name", names("floors"))
def test_every_wall_of_a_map_has_a_face_for_each_side(name: str) -> None:
    document = floor(name)
    (entity,) = decoded(scene.floor_update(document, map_cells(document), 5)).entities
    walls = entity.triangles[0]
    sides = sum(len(wall.corner) if wall.thickness is None else 4 * (len(wall.corner) - 1) for wall in document.wall)
    assert 0 < len(walls.indices) <= 6 * sides
    assert max(walls.indices) < len(walls.points)
    assert {one.text for one in entity.texts} == {one.name for one in document.grid.position} if document.grid else True


def test_a_grid_has_a_byte_for_each_cell() -> None:
    cells = map_cells(floor("room"))
    found = decoded(scene.grid_message(cells, 5))
    assert (found.column_count, found.row_stride, len(found.data)) == (cells.columns, cells.columns, len(cells.cells))
    assert (found.pose.position.x, found.cell_size.x) == (cells.west, cells.size)


@every_case("name", names("robots"))
def test_a_body_is_its_boxes_in_the_frame_of_its_agent(name: str) -> None:
    (entity,) = decoded(scene.body_update("c", robot(name), 5)).entities
    assert (entity.frame_id, entity.frame_locked) == ("c/body", True)
    assert [(box.size.x, box.size.y) for box in entity.cubes] == [(p.length, p.width) for p in parts_of(robot(name))]


def test_a_wedge_ends_where_its_sensor_sees_something() -> None:
    sensor = Proximity(id="s", x=0.5, y=0.0, z=0.4, direction_deg=90.0, cone_deg=60.0, max_range=3.0)
    silent = Proximity(id="t", x=0.5, y=0.0, z=0.4, direction_deg=90.0, cone_deg=60.0, max_range=3.0)
    body = Robot(proximity=(sensor, silent))
    readings = [ProximityReading(id="s", value=2.0), ProximityReading(id="t", status="none"),
                ProximityReading(id="unknown", value=1.0)]  # fmt: skip
    (entity,) = decoded(scene.wedges_update("c", body, readings, 5)).entities
    (fan,) = entity.triangles
    assert all(math.hypot(point.x - 0.5, point.y) == pytest.approx(2.0) for point in fan.points[1:])
    angles = [math.degrees(math.atan2(point.y, point.x - 0.5)) for point in fan.points[1:]]
    assert (angles[0], angles[-1]) == pytest.approx((60.0, 120.0))


def test_a_removal_names_what_goes() -> None:
    assert [one.id for one in decoded(scene.removal(["body c", "wedges c"], 5)).deletions] == ["body c", "wedges c"]
