"""What Foxglove's 3D panel draws: the map, the bodies, and the wedges of proximity sensors. Pure.

Each entity is in the frame of what it belongs to: the map in `map`, a body and its wedges in the frame of its agent.
Positions are in metres.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

from foxglove.messages import (
    Color,
    CubePrimitive,
    Grid,
    LinePrimitive,
    LinePrimitiveLineType,
    PackedElementField,
    PackedElementFieldNumericType,
    Point3,
    Pose,
    Quaternion,
    SceneEntity,
    SceneEntityDeletion,
    SceneUpdate,
    TextPrimitive,
    TriangleListPrimitive,
    Vector2,
    Vector3,
)

from intellwheels_agents.map_cells import MapCells
from intellwheels_agents.record_gateway.motion_messages import MAP, frame_of, stamp_of, start_frame_of
from intellwheels_maps.check import ring_of, wall_pieces
from intellwheels_schemas.agent_colours import FIXTURES, RGB, THING, colour_of
from intellwheels_schemas.messages import Map, Proximity, ProximityReading, Robot, Zone
from intellwheels_schemas.rules import has_motors, parts_of

WALL: Final = (120, 124, 130)
OBSTACLE: Final = (176, 146, 108)
FLOOR: Final = (236, 236, 232)
ZONE: Final = (90, 140, 200)
FLOOR_THICKNESS: Final = 0.02
"""Thickness of the plate below the map, m."""
FAN_STEP: Final = math.radians(10.0)
"""Largest angle of a triangle of a wedge, rad."""
TEXT_SIZE: Final = 0.3
"""Height of names, m."""

_STILL: Final = Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)


def floor_update(document: Map, grid: MapCells, time: int) -> SceneUpdate:
    """Return the map as one entity: floor, walls, obstacles, zones and the names of places.

    Args:
        document: The map.
        grid: Its cells, for the extent.
        time: Time of the message, ns.
    """
    width, depth = grid.columns * grid.size, grid.rows * grid.size
    plate = CubePrimitive(
        pose=_at(grid.west + width / 2.0, grid.south + depth / 2.0, -FLOOR_THICKNESS / 2.0),
        size=Vector3(x=width, y=depth, z=FLOOR_THICKNESS),
        color=_colour(FLOOR),
    )
    walls = [(ring, wall.bottom, wall.height) for wall in document.wall for ring in wall_pieces(wall)]
    obstacles = [(ring_of(one.corner), one.bottom, one.top) for one in document.obstacle]
    places = () if document.grid is None else document.grid.position
    texts = [_text(place.name, place.x, place.y, 0.1) for place in places]
    entity = SceneEntity(
        timestamp=stamp_of(time),
        frame_id=MAP,
        id="map",
        cubes=[plate],
        triangles=[_sides(walls, WALL), _sides(obstacles, OBSTACLE)],
        lines=[*_outlines(walls, WALL), *_outlines(obstacles, OBSTACLE), *(_border(zone) for zone in document.zone)],
        texts=texts,
    )
    return SceneUpdate(entities=[entity])


def grid_message(grid: MapCells, time: int) -> Grid:
    """Return the cells of a map as a grid with the field `occupied`: 1 or 0."""
    return Grid(
        timestamp=stamp_of(time),
        frame_id=MAP,
        pose=_at(grid.west, grid.south, 0.0),
        column_count=grid.columns,
        cell_size=Vector2(x=grid.size, y=grid.size),
        row_stride=grid.columns,
        cell_stride=1,
        fields=[PackedElementField(name="occupied", offset=0, type=PackedElementFieldNumericType.Uint8)],
        data=grid.cells,
    )


def body_update(agent: str, robot: Robot, time: int) -> SceneUpdate:
    """Return the boxes of a body and its name, as an entity that moves with the frame of its agent."""
    colour = colour_of(agent) if has_motors(robot) and robot.kind not in FIXTURES else FIXTURES.get(robot.kind, THING)
    parts = parts_of(robot)
    boxes = [
        CubePrimitive(
            pose=_at(part.x, part.y, (part.bottom + part.top) / 2.0),
            size=Vector3(x=part.length, y=part.width, z=part.top - part.bottom),
            color=_colour(colour),
        )
        for part in parts
    ]
    top = max((part.top for part in parts), default=0.0)
    entity = SceneEntity(
        timestamp=stamp_of(time),
        frame_id=frame_of(agent),
        id=f"body {agent}",
        frame_locked=True,
        cubes=boxes,
        texts=[_text(agent, 0.0, 0.0, top + TEXT_SIZE)],
    )
    return SceneUpdate(entities=[entity])


def wedges_update(agent: str, robot: Robot, readings: Sequence[ProximityReading], time: int) -> SceneUpdate:
    """Return the wedges of proximity sensors that see something, out to what they see. They replace earlier ones."""
    sensors = {sensor.id: sensor for sensor in robot.proximity}
    seen = [(sensors[one.id], one.value) for one in readings if one.value is not None and one.id in sensors]
    groups = (("wedges", "body", frame_of(agent)), ("start wedges", "start", start_frame_of(agent)))
    entities = [
        SceneEntity(
            timestamp=stamp_of(time),
            frame_id=frame,
            id=f"{word} {agent}",
            frame_locked=True,
            triangles=[_fan(sensor, value, colour_of(agent)) for sensor, value in seen if sensor.mount == mount],
        )
        for word, mount, frame in groups
        if any(sensor.mount == mount for sensor in robot.proximity)
    ]
    return SceneUpdate(entities=entities)


def removal(ids: Iterable[str], time: int) -> SceneUpdate:
    """Return the removal of entities."""
    return SceneUpdate(deletions=[SceneEntityDeletion(timestamp=stamp_of(time), id=one) for one in ids])


def _fan(sensor: Proximity, value: float, colour: RGB) -> TriangleListPrimitive:
    """Return a sector around a sensor as triangles."""
    cone, middle = math.radians(sensor.cone_deg), math.radians(sensor.direction_deg)
    count = max(1, math.ceil(cone / FAN_STEP))
    angles = [middle + cone * (index / count - 0.5) for index in range(count + 1)]
    points = [
        Point3(x=sensor.x + value * math.cos(angle), y=sensor.y + value * math.sin(angle), z=sensor.z)
        for angle in angles
    ]
    indices = [index for k in range(count) for index in (0, k + 1, k + 2)]
    corner = Point3(x=sensor.x, y=sensor.y, z=sensor.z)
    return TriangleListPrimitive(
        pose=_at(0.0, 0.0, 0.0), points=[corner, *points], indices=indices, color=_colour(colour, 0.25)
    )


_Solid = tuple[Sequence[tuple[float, float]], float, float]


def _sides(solids: Iterable[_Solid], colour: RGB) -> TriangleListPrimitive:
    """Return the upright faces of solids, each an outline with a lower and an upper edge."""
    points: list[Point3] = []
    indices: list[int] = []
    for ring, bottom, top in solids:
        first, count = len(points), len(ring)
        points += [Point3(x=x, y=y, z=z) for x, y in ring for z in (bottom, top)]
        for k in range(count):
            a, b = first + 2 * k, first + 2 * ((k + 1) % count)
            indices += [a, b, a + 1, b, b + 1, a + 1]
    return TriangleListPrimitive(pose=_at(0.0, 0.0, 0.0), points=points, indices=indices, color=_colour(colour))


def _outlines(solids: Iterable[_Solid], colour: RGB) -> list[LinePrimitive]:
    """Return the upper edges of solids."""
    dark = (colour[0] // 2, colour[1] // 2, colour[2] // 2)
    return [_loop(ring, top, dark) for ring, _, top in solids]


def _border(zone: Zone) -> LinePrimitive:
    return _loop(ring_of(zone.corner), 0.01, ZONE)


def _loop(ring: Sequence[tuple[float, float]], z: float, colour: RGB) -> LinePrimitive:
    return LinePrimitive(
        type=LinePrimitiveLineType.LineLoop,
        pose=_at(0.0, 0.0, 0.0),
        thickness=2.0,
        scale_invariant=True,
        points=[Point3(x=x, y=y, z=z) for x, y in ring],
        color=_colour(colour),
    )


def _text(text: str, x: float, y: float, z: float) -> TextPrimitive:
    return TextPrimitive(pose=_at(x, y, z), billboard=True, font_size=TEXT_SIZE, text=text, color=_colour((30, 30, 34)))


def _at(x: float, y: float, z: float) -> Pose:
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=_STILL)


def _colour(colour: RGB, opacity: float = 1.0) -> Color:
    red, green, blue = colour
    return Color(r=red / 255.0, g=green / 255.0, b=blue / 255.0, a=opacity)
