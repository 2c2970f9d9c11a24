"""Public floors that others made; they are beside the checkout of whoever has them, and not part of the project."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from intellwheels_maps.library import imported
from tests.maps.importers.drawn_floors import area_of

FOLDER = Path(os.environ.get("PUBLIC_FLOORS", "/work/shared/floors"))

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="needs the public floors in the folder PUBLIC_FLOORS")


@pytest.mark.parametrize(
    ("file", "walls", "doorways", "doors", "area", "width", "height"),
    [
        ("depot.yaml", 250, 0, 0, 14.87, 30.20, 15.25),
        ("small_house.yaml", 78, 0, 0, 8.61, 18.85, 11.30),
        ("rmf_clinic.building.yaml", 360, 75, 75, 66.21, 52.89, 40.76),
        ("rmf_hotel.building.yaml", 56, 5, 5, 20.27, 30.5, 33.2),
        ("rmf_hotel.building.yaml#L2", 99, 7, 7, 31.00, 30.52, 33.17),
        # The longest by far. Other files in DXF are read in the suite.
        pytest.param("office_cad.dxf", 222, 17, 12, 106.68, 57.90, 27.90, marks=pytest.mark.soak),
        ("westport1.geojson", 65, 11, 0, 153.64, 59.02, 63.38),
        ("CiberRTSS08_FinalLab.xml", 12, 0, 0, 51.18, 28.2, 14.2),
    ],
)
def test_figures_of_public_floors(
    file: str, walls: int, doorways: int, doors: int, area: float, width: float, height: float
) -> None:
    found = imported(FOLDER / file).map
    solid = area_of(found)
    west, south, east, north = solid.bounds
    assert (len(found.wall), len(found.doorway)) == (walls, doorways)
    assert sum(doorway.door is not None for doorway in found.doorway) == doors
    assert (solid.area, east - west, north - south) == pytest.approx((area, width, height), rel=0.01)
