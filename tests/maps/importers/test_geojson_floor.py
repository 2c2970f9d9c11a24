"""GeoJSON: parts of a floor, systems of coordinates, and what is refused."""

from __future__ import annotations

import json
from typing import Any

import pytest

from intellwheels_maps.check import check_map
from intellwheels_maps.importers import Imported
from intellwheels_maps.site_frame import to_site
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case
from tests.maps.importers.drawn_floors import area_of, read

SQUARE = [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]
HOLE = [[1, 1], [9, 1], [9, 9], [1, 9], [1, 1]]


def feature(properties: object, kind: str, coordinates: object) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def imported(*features: object, epsg: str | None = "urn:ogc:def:crs:EPSG::3763") -> Imported:
    document: dict[str, Any] = {"type": "FeatureCollection", "features": list(features)}
    if epsg is not None:
        document["crs"] = {"type": "name", "properties": {"name": epsg}}
    return read({"f.geojson": json.dumps(document).encode()})


def test_parts_of_a_floor() -> None:
    found = imported(
        feature({"type": "wall", "height": 3}, "Polygon", [SQUARE, HOLE]),
        feature({"indoor": "wall", "thickness": 0.2}, "LineString", [[20, 0], [24, 0]]),
        feature({"indoor": "wall"}, "MultiLineString", [[[25, 0], [29, 0]], [[30, 0], [31, 0]]]),
        feature(
            {"type": "door", "name": "main"}, "Polygon", [[[24, -0.1], [25, -0.1], [25, 0.1], [24, 0.1], [24, -0.1]]]
        ),
        feature({"type": "elevator", "id": 7}, "Polygon", [HOLE]),
        feature({"type": "furniture", "height": 0.7, "name": "desk"}, "Polygon", [[[2, 2], [3, 2], [3, 3], [2, 2]]]),
        feature({"type": "furniture"}, "Polygon", [HOLE]),
        feature({"name": "start", "heading": 90}, "Point", [5, 5]),
        feature(None, "Point", [5, 5]),
    )
    document = found.map
    assert check_map(document) == []
    assert area_of(document).area == pytest.approx(100 - 64 + 4 * 0.2 + 5 * 0.02)
    assert document.wall[0].height == 3.0
    (doorway,) = document.doorway
    assert (doorway.name, doorway.x, doorway.width) == ("main", 24.5, 1.0)
    assert [zone.name for zone in document.zone] == ["elevator-7"]
    assert [(obstacle.name, obstacle.top) for obstacle in document.obstacle] == [("desk", 0.7)]
    assert document.grid is not None
    assert [(place.name, place.heading_deg) for place in document.grid.position] == [("start", 90.0)]
    assert found.left_out == (
        "features[6]: Polygon 'furniture', not known as a part of a floor",
        "features[8]: Point '', not known as a part of a floor",
    )
    assert document.offset is not None
    assert document.offset.epsg == "EPSG:3763"


def test_degrees_are_metres_inside_and_degrees_outside() -> None:
    line = [[-8.6, 41.1], [-8.599, 41.101]]
    document = imported(feature({"type": "wall"}, "LineString", line), epsg=None).map
    assert document.offset is not None
    assert (document.offset.x, document.offset.y, document.offset.epsg) == (-8.6, 41.1, "EPSG:4326")
    end = document.wall[0].corner[-1]
    # A millidegree at 41.1 N is 84.0 m along the parallel and 111.1 m along the meridian.
    assert (end.x, end.y) == pytest.approx((84.0, 111.05), abs=0.1)
    assert to_site(document, (end.x, end.y)) == pytest.approx((-8.599, 41.101), abs=1e-9)


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b'{"type": "FeatureCollection", "features": [', r"f\.geojson: line 1: expected JSON"),
        (b"[" * 100_000, r"f\.geojson: expected JSON, got too deep a nesting"),
        (b'{"type": "Topology"}', r"f\.geojson: expected a FeatureCollection with features, got 'Topology'"),
        (b'{"type": "FeatureCollection", "features": 1}', "expected a FeatureCollection with features"),
        (b'{"type": "FeatureCollection", "features": []}', "features: expected coordinates, got none"),
    ],
    ids=["cut", "deep", "other", "number", "empty"],
)
def test_what_is_no_collection_is_refused(data: bytes, text: str) -> None:
    with pytest.raises(WireError, match=text):
        read({"f.geojson": data})


@every_case(
    ("coordinates", "text"),
    [
        ([[0, 0], [1e9, 0]], r"features\[0\]\.geometry: expected coordinates within 100,000 km"),
        ([[0, 0], ["1", 0]], r"features\[0\]\.geometry: expected two numbers, got a list"),
        ([[0, 0], [1]], "expected two numbers"),
        ([[0, 0], 7], "expected two numbers, got 7"),
        ([], "expected a list of coordinates, got a list"),
        ({}, "expected a list of coordinates, got an object"),
        ([[0, 0], [float("nan"), 0]], "expected coordinates within"),
        ([[0, 0], [int("9" * 400), 0]], "expected coordinates within"),
        ([[0, 0], [90_000, 0]], r"expected at most 9,000 m across.*units right\?"),
    ],
)
def test_wrong_coordinates_are_refused_with_their_feature(coordinates: object, text: str) -> None:
    with pytest.raises(WireError, match=text):
        imported(feature({"type": "wall"}, "LineString", coordinates))


def test_wrong_systems_and_numbers_are_refused() -> None:
    wall = feature({"type": "wall"}, "LineString", [[500_000, 0], [500_005, 0]])
    with pytest.raises(WireError, match="expected longitude and latitude in degrees, got 500000 0; name the crs"):
        imported(wall, epsg=None)
    with pytest.raises(WireError, match="crs: expected CRS84 or an EPSG code, got 'local'"):
        imported(wall, epsg="local")
    tall = feature({"type": "wall", "height": -1}, "LineString", [[0, 0], [5, 0]])
    with pytest.raises(WireError, match=r"features\[0\]\.properties\.height: expected a number in \[0\.01, 1000\]"):
        imported(tall)
    with pytest.raises(WireError, match=r"features\[0\]: expected a feature with a geometry, got 3"):
        imported(3)
