"""Buildings of Open-RMF: levels, scale, doors, places, lanes, lifts, and what is refused."""

from __future__ import annotations

from typing import Any

import pytest
import yaml

from intellwheels_maps.check import check_map
from intellwheels_maps.importers import Imported
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Door
from tests.every_case import every_case
from tests.maps.importers.drawn_floors import read


def building(**level: Any) -> dict[str, Any]:
    """Return a building of 2 cm a pixel: a wall 2 m below the top of the drawing, with a gap from x = 4 to 5 m."""
    first = {
        "elevation": 0.0,
        "vertices": [
            [0, 100, 0, ""], [200, 100, 0, ""], [250, 100, 0, ""], [450, 100, 0, ""], [100, 50, 0, "desk"],
            [225, 50, 0, ""], [225, 150, 0, ""], [0, 0, 0, ""], [50, 0, 0, ""],
        ],
        "walls": [[0, 1, {"texture_height": [3, 3.0]}], [2, 3, {}]],
        "doors": [[1, 2, {"type": [1, "hinged"], "name": [1, "d 1"], "motion_degrees": [3, 80]}]],
        "lanes": [[5, 6, {"bidirectional": [4, False]}], [4, 5, {}]],
        "measurements": [[7, 8, {"distance": [3, 1.0]}]],
    }  # fmt: skip
    lift = {
        "x": 400, "y": 50, "yaw": 0.0, "width": 2.0, "depth": 1.0, "reference_floor_name": "L1",
        "level_doors": {"L1": ["a"]}, "doors": {"a": {"width": 1.0}},
    }  # fmt: skip
    upper = {"elevation": 3.0, "vertices": [[0, 0], [50, 0]], "walls": [[0, 1]], "measurements": first["measurements"]}
    upper["measurements"] = [[0, 1, {"distance": [3, 1.0]}]]
    return {"name": "Clinic", "levels": {"L2": upper, "L1": first | level}, "lifts": {"lift1": lift}}


def imported(document: dict[str, Any], level: str | None = None) -> Imported:
    return read({"b.building.yaml": yaml.safe_dump(document).encode()}, level)


def test_a_level_becomes_a_map() -> None:
    found = imported(building())
    document = found.map
    assert check_map(document) == []
    assert document.title == "Clinic, L1"
    assert [(wall.height, wall.thickness) for wall in document.wall] == [(3.0, 0.1), (2.5, 0.1)]
    assert [(corner.x, corner.y) for corner in document.wall[0].corner] == [(0.0, -2.0), (4.0, -2.0)]
    (doorway,) = document.doorway
    assert (doorway.name, doorway.x, doorway.y, doorway.width) == ("d-1", 4.5, -2.0, 1.0)
    # From the start at 4 m, which is on the left of the heading -y... clockwise from above is towards -y.
    assert doorway.heading_deg == 90.0
    assert doorway.door == Door(kind="hinged", side="left", swing_deg=-80.0)
    assert document.grid is not None
    assert [(place.name, place.kinds) for place in document.grid.position] == [
        ("desk", ()), ("vertex5", ("waypoint",)), ("vertex6", ("waypoint",)),
    ]  # fmt: skip
    assert [(route.places, route.one_way) for route in document.route] == [
        (("vertex5", "vertex6"), True),
        (("desk", "vertex5"), False),
    ]
    (lift,) = document.zone
    assert [(corner.x, corner.y) for corner in lift.corner] == [(7.0, -1.5), (9.0, -1.5), (9.0, -0.5), (7.0, -0.5)]
    assert found.left_out == (
        "levels.L2: another level, which FILE#LEVEL imports",
        "lifts.lift1.doors.a: doors of lifts are not in the map",
    )


def test_another_level_is_chosen_by_its_name() -> None:
    assert len(imported(building(), "L2").map.wall) == 1
    with pytest.raises(WireError, match=r"expected one of the levels \(L1, L2\) after '#', got 'L3'"):
        imported(building(), "L3")


@pytest.mark.parametrize(
    ("kind", "wanted"),
    [
        ("double_hinged", "double-hinged"), ("sliding", "sliding"), ("double_sliding", "double-sliding"),
        ("telescope", "sliding"), ("rolling", None),
    ],
)  # fmt: skip
def test_kinds_of_doors(kind: str, wanted: str | None) -> None:
    found = imported(building(doors=[[2, 1, {"type": [1, kind], "motion_axis": [1, "end"]}]]))
    (doorway,) = found.map.doorway
    assert (doorway.door.kind if doorway.door else None) == wanted
    assert any("door of the kind 'rolling'" in line for line in found.left_out) == (wanted is None)


def test_furniture_is_left_out_with_its_place() -> None:
    found = imported(building(models=[{"name": "chair"}, {"name": "bed"}]))
    assert found.left_out[-1] == "models are not in the map: 2 (levels.L1.models[0]; levels.L1.models[1])"
    assert found.things == 4  # with another level and the door of a lift


@every_case(
    ("level", "text"),
    [
        ({"measurements": []}, r"levels\.L1\.measurements: expected a measurement for the scale, got none"),
        ({"measurements": [[7, 8, {"distance": [3, 0.0]}]]}, r"measurements\[0\]: expected a distance above 0"),
        ({"measurements": [[7, 8, {"distance": [3, 1e5]}]]}, r"expected at most 9,000 m across, .*units right\?"),
        ({"walls": [[0, 99]]}, r"levels\.L1\.walls\[0\]: expected the number of one of the 9 vertices, got 99"),
        ({"walls": [[0, True]]}, r"walls\[0\]: expected the number of one of the 9 vertices, got true"),
        ({"walls": [7]}, r"walls\[0\]: expected a list of two vertices and settings, got 7"),
        ({"walls": 7}, r"levels\.L1\.walls: expected a list, got 7"),
        ({"walls": []}, "expected at least one wall, got none"),
        ({"vertices": [["x", 0]]}, r"vertices\[0\]: expected a number within 1e8, got 'x'"),
        ({"vertices": [[float("nan"), 0]]}, r"vertices\[0\]: expected a number within 1e8"),
        ({"vertices": [0]}, r"vertices\[0\]: expected a list of x, y, z and a name, got 0"),
        ({"doors": [[1, 1, {"type": [1, "hinged"]}]]}, r"doors\[0\]: expected two vertices, got one twice"),
    ],
)
def test_a_wrong_level_is_refused_with_its_place(level: dict[str, Any], text: str) -> None:
    with pytest.raises(WireError, match=text):
        imported(building(**level))


def test_other_coordinates() -> None:
    document = building() | {"coordinate_system": "cartesian_meters"}
    corners = imported(document).map.wall[0].corner
    assert [(corner.x, corner.y) for corner in corners] == [(0.0, 100.0), (200.0, 100.0)]
    with pytest.raises(WireError, match="coordinate_system: expected reference_image or cartesian_meters, got 'wgs84'"):
        imported(document | {"coordinate_system": "wgs84"})
    with pytest.raises(WireError, match="levels: expected keys and values, got null"):
        imported({"name": "x"})
