"""Maps as labs."""

from __future__ import annotations

import pytest

from intellwheels_agents.ciber_gateway.lab_frame import lab_of
from intellwheels_maps import floor
from intellwheels_schemas.messages import Corner, Map, Wall, Zone
from tests.agents.ciber_gateway.stand_in_clients import GRID, LAB
from tests.maps.importers.drawn_floors import read


def test_an_imported_lab_has_its_own_numbers_again() -> None:
    lab = lab_of(read({"MyLab.xml": LAB, "MyGrid.xml": GRID}).map)
    assert lab.name == "Small Lab"
    assert (lab.west, lab.south, lab.width, lab.height) == pytest.approx((0.0, 0.0, 12.0, 8.0))
    assert [(wall.height, len(wall.corners)) for wall in lab.walls] == [(3.0, 4), (1.0, 4)]
    assert sum(lab.walls[0].corners, ()) == pytest.approx((5, 0, 5.5, 0, 5.5, 5, 5, 5))
    assert [(place.x, place.y) for place in lab.beacons] == [(10.0, 6.0)]
    assert [(place.x, place.y, place.heading_deg) for place in lab.starts] == [(2, 2, 0), (2, 6, 0), (2, 4, 90)]
    (target,) = lab.targets
    assert (target.x, target.y, target.radius) == pytest.approx((10.0, 6.0, 1.5), abs=1e-3)
    assert (lab.target_number("target"), lab.target_number("other"), lab.target_number(None)) == (0, -1, -1)


def test_a_map_without_a_border_begins_at_its_corner() -> None:
    ward = floor("ward")
    lab = lab_of(ward)
    points = [point for wall in lab.walls for point in wall.corners]
    assert min(x for x, _ in points) >= -1e-9
    assert min(y for _, y in points) >= -1e-9
    assert max(x for x, _ in points) <= lab.width + 1e-9
    assert len(lab.targets) == len(ward.zone)
    assert all("goal" not in place.kinds for place in lab.starts)


def test_a_target_is_the_circle_around_its_zone() -> None:
    corners = tuple(Corner(x=x, y=y) for x, y in ((1, 1), (7, 1), (7, 9), (4, 9), (1, 9)))
    (target,) = lab_of(Map(format="iw.v1", name="m", zone=(Zone(name="z", corner=corners),))).targets
    assert (target.x, target.y, target.radius) == (4.0, 5.0, 5.0)


def test_an_empty_map_is_a_lab() -> None:
    assert (lab_of(Map(format="iw.v1", name="m")).width, lab_of(Map(format="iw.v1", name="m")).starts) == (1.0, ())


def test_a_wall_around_a_part_is_no_border() -> None:
    ring = tuple(Corner(x=x, y=y) for x, y in ((0, 0), (2, 0), (2, 2), (0, 2), (0, 0)))
    far = tuple(Corner(x=x, y=y) for x, y in ((5, 5), (6, 5)))
    document = Map(format="iw.v1", name="m", wall=(Wall(thickness=0.1, corner=ring), Wall(thickness=0.1, corner=far)))
    assert len(lab_of(document).walls) == 5
