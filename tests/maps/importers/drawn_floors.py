"""Random floors, and writers for each format that share no code with the importers."""

from __future__ import annotations

import io
import json
import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import shapely

from intellwheels_maps.check import ring_of, wall_pieces
from intellwheels_maps.importers import FloorSource, Imported, import_floor
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Map

CELL = 0.05
Point = tuple[float, float]


@dataclass
class DrawnDoor:
    """A doorway: left and right jamb as seen along the heading, and which way its leaf opens."""

    left: Point
    right: Point
    swing: float


@dataclass
class DrawnFloor:
    """Walls as lines of one thickness, doors between them, and places. All lengths are multiples of the cell."""

    walls: list[tuple[Point, Point]] = field(default_factory=list)
    doors: list[DrawnDoor] = field(default_factory=list)
    places: list[Point] = field(default_factory=list)
    thickness: float = 0.1
    turn: float = 0.0

    def turned(self, point: Point) -> Point:
        """Return a point in the frame of the site."""
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        return cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]

    def boxes(self) -> list[list[Point]]:
        """Return the corners of each wall, not turned, anticlockwise."""
        found = []
        half = self.thickness / 2
        for (ax, ay), (bx, by) in self.walls:
            west, east, south, north = min(ax, bx), max(ax, bx), min(ay, by), max(ay, by)
            if ay == by:
                south, north = south - half, north + half
            else:
                west, east = west - half, east + half
            found.append([(west, south), (east, south), (east, north), (west, north)])
        return found

    def area(self) -> Any:
        """Return the union of the walls in the frame of the site."""
        return shapely.union_all([shapely.Polygon([self.turned(corner) for corner in box]) for box in self.boxes()])


def drawn(seed: int) -> DrawnFloor:
    """Return a row of rooms with a door in each partition."""
    draw = random.Random(seed)
    floor = DrawnFloor(turn=draw.choice((0.0, draw.uniform(-3.0, 3.0))))
    depth = draw.randrange(60, 120) * CELL
    x = 0.0
    for room in range(draw.randrange(2, 6)):
        if room:
            gap, width = draw.randrange(10, 30) * CELL, draw.randrange(16, 26) * CELL
            floor.walls += [((x, 0.0), (x, gap)), ((x, gap + width), (x, depth))]
            low, high = (x, gap), (x, gap + width)
            hinge, other = (low, high) if draw.random() < 0.5 else (high, low)
            floor.doors.append(DrawnDoor(hinge, other, draw.choice((90.0, -90.0))))
        length = draw.randrange(50, 110) * CELL
        floor.places.append((x + length / 2, depth / 2))
        x += length
    floor.walls += [((0.0, 0.0), (x, 0.0)), ((0.0, depth), (x, depth)), ((0.0, 0.0), (0.0, depth))]
    floor.walls.append(((x, 0.0), (x, depth)))
    return floor


# ---------------------------------------------------------------- writers


def write_ros(floor: DrawnFloor) -> dict[str, bytes]:
    """Return a PGM of cells whose grid is turned, and its YAML file."""
    import numpy as np
    import yaml
    from PIL import Image, ImageDraw

    boxes = floor.boxes()
    wide = max(x for box in boxes for x, _ in box) + 0.5
    high = max(y for box in boxes for _, y in box) + 0.5
    columns, rows = round((wide + 0.5) / CELL), round((high + 0.5) / CELL)
    image = Image.fromarray(np.full((rows, columns), 254, dtype=np.uint8))
    for (west, south), _, (east, north), _ in boxes:
        left, right = round((west + 0.5) / CELL), round((east + 0.5) / CELL)
        top, bottom = rows - round((north + 0.5) / CELL), rows - round((south + 0.5) / CELL)
        ImageDraw.Draw(image).rectangle((left, top, right - 1, bottom - 1), fill=0)
    data = io.BytesIO()
    image.save(data, format="PPM")
    x, y = floor.turned((-0.5, -0.5))
    head = {"image": "floor.pgm", "resolution": CELL, "origin": [x, y, floor.turn], "negate": 0}
    head |= {"occupied_thresh": 0.65, "free_thresh": 0.196}
    return {"floor.yaml": yaml.safe_dump(head).encode(), "floor.pgm": data.getvalue()}


def write_rmf(floor: DrawnFloor) -> dict[str, bytes]:
    """Return a building of one level, in pixels of 2 cm."""
    import yaml

    vertices: list[list[Any]] = []

    def vertex(point: Point, name: str = "") -> int:
        x, y = floor.turned(point)
        vertices.append([50 * x, -50 * y, 0, name])
        return len(vertices) - 1

    def setting(value: object) -> list[object]:
        return [{str: 1, int: 2, float: 3}[type(value)], value]

    walls = [[vertex(a), vertex(b), {"texture_height": setting(2.5)}] for a, b in floor.walls]
    doors = []
    for number, door in enumerate(floor.doors):
        # Clockwise about the start, for a direction of 1: against the heading, with the start on the left.
        settings = {"type": "hinged", "name": f"d{number}", "motion_axis": "start", "motion_degrees": abs(door.swing)}
        settings["motion_direction"] = -1 if door.swing > 0 else 1
        given = {key: setting(value) for key, value in settings.items()}
        doors.append([vertex(door.left), vertex(door.right), given])
    places = [vertex(place, f"room{number}") for number, place in enumerate(floor.places)]
    lanes = [[a, b, {"bidirectional": [4, True]}] for a, b in pairwise(places)]
    measure = [[vertex((0.0, 0.0)), vertex((2.0, 0.0)), {"distance": [3, 2.0]}]]
    level = {"vertices": vertices, "walls": walls, "doors": doors, "lanes": lanes, "measurements": measure}
    level["elevation"] = 0  # type: ignore[assignment]
    return {"floor.building.yaml": yaml.safe_dump({"name": "b", "levels": {"L1": level}, "lifts": {}}).encode()}


def write_dxf(floor: DrawnFloor, units: int = 4) -> dict[str, bytes]:
    """Return a drawing in millimetres, or in feet for units 2; doors are blocks with the arc of a leaf of 1 m."""
    import ezdxf

    scale = {4: 1000.0, 2: 1 / 0.3048}[units]
    document = ezdxf.new()  # type: ignore[attr-defined]
    document.header["$INSUNITS"] = units
    document.layers.add("A-WALL")
    document.layers.add("A-DOOR")
    leaf = document.blocks.new("door 1000")
    leaf.add_line((0, 0), (0, scale))
    leaf.add_arc((0, 0), scale, 0, 90)
    space = document.modelspace()

    def point(place: Point) -> Point:
        x, y = floor.turned(place)
        return x * scale, y * scale

    for box in floor.boxes():
        space.add_lwpolyline([point(corner) for corner in box], close=True, dxfattribs={"layer": "A-WALL"})
    for door in floor.doors:
        (hx, hy), (ox, oy) = floor.turned(door.left), floor.turned(door.right)
        # The leaf is closed along the block's x axis and opens anticlockwise; mirrored, it opens clockwise.
        width, turn = math.hypot(ox - hx, oy - hy), math.degrees(math.atan2(oy - hy, ox - hx))
        mirror = 1.0 if door.swing > 0 else -1.0
        given = {"layer": "A-DOOR", "xscale": width, "yscale": mirror * width, "rotation": turn}
        space.add_blockref("door 1000", point(door.left), dxfattribs=given)
    text = io.StringIO()
    document.write(text)
    return {"floor.dxf": text.getvalue().encode()}


def write_geojson(floor: DrawnFloor) -> dict[str, bytes]:
    """Return features in degrees, around 41 N 8 W, by the radii of WGS 84 at the south west corner."""
    corners = [floor.turned(corner) for box in floor.boxes() for corner in box]
    west, south = min(x for x, _ in corners), min(y for _, y in corners)
    lat = math.radians(41.0)
    flat = 1 - 0.00669437999014 * math.sin(lat) ** 2
    north_radius = 6378137.0 * (1 - 0.00669437999014) / flat**1.5
    east_radius = 6378137.0 / math.sqrt(flat)

    def place(point: Point) -> list[float]:
        x, y = floor.turned(point)
        return [
            -8 + math.degrees((x - west) / (east_radius * math.cos(lat))),
            41 + math.degrees((y - south) / north_radius),
        ]

    def feature(kind: str, geometry: str, coordinates: object, **more: object) -> dict[str, Any]:
        return {
            "type": "Feature", "properties": {"type": kind, **more},
            "geometry": {"type": geometry, "coordinates": coordinates},
        }  # fmt: skip

    features = [feature("wall", "Polygon", [[place(one) for one in [*box, box[0]]]]) for box in floor.boxes()]
    features += [feature("door", "LineString", [place(door.left), place(door.right)]) for door in floor.doors]
    features += [feature("place", "Point", place(at), name=f"room{n}") for n, at in enumerate(floor.places)]
    return {"floor.geojson": json.dumps({"type": "FeatureCollection", "features": features}).encode()}


def write_lab(floor: DrawnFloor) -> dict[str, bytes]:
    """Return a lab and its grid. A lab has only positive coordinates, so the floor is moved by 20."""
    walls = ""
    for box in floor.boxes():
        corners = "".join(f'<Corner X="{x + 20:.9f}" Y="{y + 20:.9f}"/>' for x, y in map(floor.turned, box))
        walls += f'<Wall Height="3">{corners}</Wall>\n'
    starts = ""
    for x, y in map(floor.turned, floor.places):
        starts += f'<Position X="{x + 20:.9f}" Y="{y + 20:.9f}" Dir="90"/>'
    lab = f'<!-- drawn -->\n<Lab Name="Drawn" Height="60" Width="60">\n{walls}<Beacon X="59" Y="59" Height="2"/></Lab>'
    return {"MyLab.xml": lab.encode(), "MyGrid.xml": f"<Grid>{starts}</Grid>".encode()}


def write_ifc(floor: DrawnFloor) -> dict[str, bytes]:
    """Return a model in millimetres, each wall an extruded rectangle, each door a place and a width."""
    import ifcopenshell

    model: Any = ifcopenshell.file(schema="IFC4")
    make = model.create_entity

    def point(*values: float) -> Any:
        return make("IfcCartesianPoint", [float(value) for value in values])

    def axis(x: float, y: float, z: float, turn: float) -> Any:
        along = make("IfcDirection", [math.cos(turn), math.sin(turn), 0.0])
        return make("IfcAxis2Placement3D", point(x, y, z), make("IfcDirection", [0.0, 0.0, 1.0]), along)

    unit = make("IfcSIUnit", None, "LENGTHUNIT", "MILLI", "METRE")
    context = make("IfcGeometricRepresentationContext", None, "Model", 3, 1e-5, axis(0, 0, 0, 0), None)
    make("IfcProject", "0" * 22, None, "P", None, None, None, None, [context], make("IfcUnitAssignment", [unit]))
    make("IfcBuildingStorey", "1" + "0" * 21, Name="ground", Elevation=0.0)
    up = make("IfcDirection", [0.0, 0.0, 1.0])
    for number, box in enumerate(floor.boxes()):
        (west, south), (east, north) = box[0], box[2]
        x, y = floor.turned(((west + east) / 2, (south + north) / 2))
        size = (east - west) * 1000, (north - south) * 1000
        flat = make("IfcAxis2Placement2D", point(0, 0), make("IfcDirection", [1.0, 0.0]))
        profile = make("IfcRectangleProfileDef", "AREA", None, flat, *size)
        solid = make("IfcExtrudedAreaSolid", profile, axis(0, 0, 0, 0), up, 3000.0)
        body = make("IfcShapeRepresentation", context, "Body", "SweptSolid", [solid])
        wall = make("IfcWall", f"{number:022d}", Name="wall")
        wall.ObjectPlacement = make("IfcLocalPlacement", None, axis(x * 1000, y * 1000, 0, floor.turn))
        wall.Representation = make("IfcProductDefinitionShape", None, None, [body])
    for number, door in enumerate(floor.doors):
        (hx, hy), (ox, oy) = floor.turned(door.left), floor.turned(door.right)
        made = make("IfcDoor", f"9{number:021d}", Name=f"d{number}", OverallWidth=math.hypot(ox - hx, oy - hy) * 1000)
        # A leaf opens along y. With the hinge at the start, on the left, that is along the heading.
        start, end = ((hx, hy), (ox, oy)) if door.swing > 0 else ((ox, oy), (hx, hy))
        made.OperationType = "SINGLE_SWING_LEFT" if door.swing > 0 else "SINGLE_SWING_RIGHT"
        turn = math.atan2(end[1] - start[1], end[0] - start[0])
        made.ObjectPlacement = make("IfcLocalPlacement", None, axis(start[0] * 1000, start[1] * 1000, 0, turn))
    return {"floor.ifc": model.to_string().encode()}


# ---------------------------------------------------------------- readers


def read(files: dict[str, bytes], level: str | None = None) -> Imported:
    """Import the first of some files; the others are beside it."""

    def beside(name: str) -> bytes:
        if name not in files:
            raise WireError("value", f"{name}: expected a file, got none", name)
        return files[name]

    name = next(iter(files))
    return import_floor(FloorSource(name, files[name], beside, level))


def refusal(files: dict[str, bytes]) -> str | None:
    """Return why a file is refused, or None if it is read."""
    try:
        read(files)
    except WireError as error:
        return error.text
    return None


def area_of(document: Map) -> Any:
    """Return the union of the walls of a map."""
    return shapely.union_all([shapely.Polygon(piece) for wall in document.wall for piece in wall_pieces(wall)])


def solid_of(document: Map) -> Any:
    """Return the union of the walls and the obstacles of a map."""
    return shapely.union_all(
        [area_of(document), *(shapely.Polygon(ring_of(obstacle.corner)) for obstacle in document.obstacle)]
    )


def thickest(area: Any, unit: float) -> float:
    """Return the largest thickness of an area, to a tenth of a unit."""
    step = 0
    while step < 100 and not shapely.buffer(area, -step * unit / 20).is_empty:
        step += 1
    return step * unit / 10


Write = Callable[[DrawnFloor], dict[str, bytes]]
