"""Maps written for the ROS map server: read by other programs, and imported again."""

from __future__ import annotations

import io

import numpy as np
import pytest
import shapely
import yaml
from PIL import Image

from intellwheels_maps import floor, names
from intellwheels_maps.ros_export import export_ros
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Corner, Map, SiteOffset, Wall
from tests.every_case import every_case
from tests.maps.importers.drawn_floors import area_of, drawn, read, solid_of, thickest, write_ros


@every_case("name", names("floors"))
def test_an_exported_map_that_is_imported_differs_by_half_a_cell(name: str) -> None:
    document = floor(name)
    files = export_ros(document, 0.05, "m.pgm")
    found = read({"m.yaml": files.head.encode(), "m.pgm": files.image}).map
    difference = shapely.symmetric_difference(solid_of(document), area_of(found))
    # The thickness is known to a tenth of a cell.
    assert thickest(difference, 0.05) <= 0.025 + 0.005 + 1e-9


@every_case("seed", range(8))
def test_a_map_of_cells_gets_the_same_cells_again(seed: int) -> None:
    plain = drawn(seed)
    plain.turn = 0.0
    first = read(write_ros(plain)).map
    files = export_ros(first, 0.05, "m.pgm")
    assert area_of(first).equals(area_of(read({"m.yaml": files.head.encode(), "m.pgm": files.image}).map).normalize())


def test_other_programs_read_the_files() -> None:
    document = floor("ward")
    files = export_ros(document, 0.1, "ward.pgm")
    head = yaml.safe_load(files.head)
    image = np.asarray(Image.open(io.BytesIO(files.image)))
    assert image.shape == (files.rows, files.columns)
    assert (head["image"], head["resolution"], head["negate"]) == ("ward.pgm", 0.1, 0)
    # The cell of a wall's corner is black: its column from the west, its row from the north.
    corner = document.wall[0].corner[0]
    column = int((corner.x - head["origin"][0]) / 0.1)
    row = image.shape[0] - 1 - int((corner.y - head["origin"][1]) / 0.1)
    assert image[row - 1 : row + 2, column - 1 : column + 2].min() == 0
    places = yaml.safe_load(files.places)
    assert document.grid is not None
    assert [place["name"] for place in places["places"]] == [place.name for place in document.grid.position]
    assert [door["name"] for door in places["doorways"]] == [doorway.name for doorway in document.doorway]


def far(x: float, epsg: str | None = None) -> Map:
    wall = Wall(thickness=0.1, corner=(Corner(x=0.0, y=0.0), Corner(x=5.0, y=0.0)))
    return Map(format="iw.v1", name="far", wall=(wall,), offset=SiteOffset(x=x, y=2000.0, epsg=epsg))


def test_coordinates_are_those_of_the_site() -> None:
    files = export_ros(far(600000.0), 0.05, "m.pgm")
    origin = yaml.safe_load(files.head)["origin"]
    assert origin == pytest.approx([600000.0 - 0.1, 2000.0 - 0.15, 0.0])
    found = read({"m.yaml": files.head.encode(), "m.pgm": files.image}).map
    assert found.offset is not None
    assert found.offset.x + area_of(found).bounds[0] == pytest.approx(600000.0)


def test_what_cannot_be_written_is_refused() -> None:
    with pytest.raises(WireError, match="far: expected a map in metres, got one whose site is in degrees"):
        export_ros(far(8.0, "EPSG:4326"), 0.05, "m.pgm")
    with pytest.raises(WireError, match="--resolution: expected at most 16,777,216 cells"):
        export_ros(floor("ward"), 0.001, "m.pgm")
    with pytest.raises(WireError, match="m: expected walls or obstacles, got none"):
        export_ros(Map(format="iw.v1", name="m"), 0.05, "m.pgm")
