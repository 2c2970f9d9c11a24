from __future__ import annotations

import math

import pytest

from intellwheels_maps.site_frame import degree_lengths, from_site, to_site
from intellwheels_schemas.messages import Map, SiteOffset


def moved(x: float, y: float, epsg: str | None) -> Map:
    return Map(format="iw.v1", name="m", offset=SiteOffset(x=x, y=y, epsg=epsg))


def test_without_an_offset_both_frames_are_one() -> None:
    document = Map(format="iw.v1", name="m")
    assert to_site(document, (1.0, 2.0)) == from_site(document, (1.0, 2.0)) == (1.0, 2.0)


def test_metres_are_added() -> None:
    document = moved(489000.0, 4412000.0, "EPSG:32629")
    assert to_site(document, (1.5, 2.0)) == (489001.5, 4412002.0)
    assert from_site(document, (489001.5, 4412002.0)) == (1.5, 2.0)


@pytest.mark.parametrize("latitude", [-60.0, 0.0, 41.1, 78.0])
def test_degrees_go_there_and_back(latitude: float) -> None:
    document = moved(-8.6, latitude, "EPSG:4326")
    assert from_site(document, to_site(document, (123.0, -45.0))) == pytest.approx((123.0, -45.0), abs=1e-6)


@pytest.mark.parametrize(("latitude", "east", "north"), [(0.0, 111319.49, 110574.28), (60.0, 55800.0, 111412.28)])
def test_lengths_of_a_degree(latitude: float, east: float, north: float) -> None:
    # Published for WGS 84: at the equator and at 60 degrees.
    assert degree_lengths(latitude) == pytest.approx((east, north), abs=2.0)


def test_a_small_map_is_flat_enough() -> None:
    # 100 m from the origin, at 60 degrees: the parallel there is shorter by the tangent of the latitude.
    error = 100.0 * 100.0 / 6.4e6 * math.tan(math.radians(60.0))
    assert error < 0.003
